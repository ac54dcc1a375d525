// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>

#include "daemon/report/subject.hpp"

namespace eha::report {

// What the box of a report says next, with commands that can be copied as they are.

/// Whether a fault ended the run.
[[nodiscard]] bool has_tripped(const Subject& subject);

/// What comes first after a trial that tripped: "repair the leak first, ...", without capital and point.
[[nodiscard]] std::string first_after_trial(const Subject& subject);

/// What to do before a run that tripped is recorded again: what its record shows to help, else "correct what ended the
/// run".
[[nodiscard]] std::string against_end(const Subject& subject);

/// The run's folder as a word of a command; RUN where the subject has none.
[[nodiscard]] std::string folder_word(const Subject& subject);

/// `eha fit RUN` for the record of a run that ended early, with --discard 0 where it is no longer than that.
[[nodiscard]] std::string fit_of_part(const Subject& subject);

/// What to do with an accepted model, as text.
/// @param has_changed  the rig, by its valve sheet
[[nodiscard]] std::string next_steps(const Subject& subject, const ReportedModel& reported, bool has_changed);

/// What to do where no model can be used, as HTML; empty where the reasons say it all.
[[nodiscard]] std::string next_of_none(const Subject& subject);

}  // namespace eha::report
