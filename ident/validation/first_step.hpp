// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "ident/model/model.hpp"

namespace eha::ident {

/// What stands before every use of a record's models. Of several the first of this list.
enum class FirstStep {
  look_at_sensor,     ///< the record shows no motion: shows_no_motion()
  mend_input,         ///< the input column is not what the plant got
  take_rows_as_even,  ///< rows that had been sampled evenly were moved to even times
  cut,                ///< a part of the record is none of the plant: a frozen sensor, an end stop, a jump, gaps
  against_lost_rows,  ///< ticks of a run were late or lost: its computer is in the way, which no longer record mends
  smaller_amplitude,  ///< the output is at an end now and then, which no cut leaves out
  longer_record,      ///< the record is too short to judge the recommended model
  none,               ///< nothing does
};

/// A first step, and the options of `eha fit` that take it.
struct NextStep {
  FirstStep first = FirstStep::none;
  /// Of FirstStep::cut, "--to 27.68"; empty where more than one part is left.
  std::string cut_options = {};
};

/// Decides what a terminal, a page and a report name first. A longer record is none for one with an end stop, a
/// jump or a sensor that does not move: it would have the same.
/// @param models  those of the record @param recommended  the name of one of them; empty: none
/// Cost: none to speak of.
[[nodiscard]] NextStep next_step(const std::vector<const Model*>& models, std::string_view recommended);

/// Whether a model's output is plain noise in which the input has no part, on both parts of the record: the sensor is
/// dead, or nothing moves.
/// @param verdict  of this model; its criteria are read
[[nodiscard]] bool shows_no_motion(const Model& model, const Verdict& verdict);

}  // namespace eha::ident
