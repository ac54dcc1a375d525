// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>

#include "daemon/identify/scored_model.hpp"

namespace eha::identify {

/// Why a record says nothing of a model that does not follow it, with what to look at, as a sentence: its input hardly
/// moves beside that which estimated the model, or stays within the dead band of its map; its output stands where the
/// model moves; or the output moves the other way. Empty where the model follows, or where none of these is so. Cost
/// O(N).
/// @param scored  of the model on the record   @param factor  of a length, for people   @param unit  of the output
[[nodiscard]] std::string why_silent(const ident::Model& model, const ident::Record& record, const ScoredModel& scored,
                                     double factor, const std::string& unit);

}  // namespace eha::identify
