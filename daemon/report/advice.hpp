// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>

#include "daemon/report/subject.hpp"

namespace eha::report {

/// Whether a model of the subject has a valve's map.
[[nodiscard]] bool has_valve_map(const Subject& subject);

/// Gives advice, in one sentence, for a model that misses a part of the plant: those of valve map, more poles and delay
/// that no model of the subject has.
[[nodiscard]] std::string what_to_try(const Subject& subject, const ident::Model& model);

/// What to do about a model's error, by the cause that the box at the top of the page names; empty if none is known.
[[nodiscard]] std::string against_error(const Subject& subject, const ident::Model& model);

}  // namespace eha::report
