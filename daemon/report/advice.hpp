// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>

#include "daemon/report/subject.hpp"

namespace eha::report {

/// Whether a model of the subject has a valve's map.
[[nodiscard]] bool has_valve_map(const Subject& subject);

/// What to do about a part of the plant that a model lacks: whatever of a valve's map, more poles and a delay no model
/// of the subject has. A sentence.
[[nodiscard]] std::string what_to_try(const Subject& subject, const ident::Model& model);

}  // namespace eha::report
