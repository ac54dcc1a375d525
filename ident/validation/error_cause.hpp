// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>

#include "ident/model/model.hpp"

namespace eha::ident {

/// What explains the greatest part of a model's error on a record, by the findings of its validation. Of several the
/// first of this list.
enum class ErrorCause {
  wrong_input,   ///< the input column is not what the plant got
  moved_rows,    ///< rows that had been sampled evenly were moved to other even times, and a check shows it
  frozen,        ///< the sensor froze, and the model is off
  slow_rows,     ///< the rows are too slow for the plant
  end_stop,      ///< the output stands at an end
  jump,          ///< one sudden lasting change
  other_plant,   ///< the model is of another plant
  input_noise,   ///< noise of the measured input makes what the model leaves over
  missing_part,  ///< the input moves the residual, or it is far above the noise between periods
  nonlinear,     ///< the residual depends on level, motion or position
  feedback,      ///< the residual correlates with the input that follows; loop_in_record() stands before end_stop
  drift,         ///< the residual wanders, and nothing of the above
  white_noise,   ///< every test passed: uncorrelated with the input and with itself, and no offset
  unknown,       ///< none of these, or too few samples to tell
};

/// Whether an R2 is too low by a slow part of the error alone, as where a sensor drifts: the faster motion is followed.
[[nodiscard]] bool wanders(const Model& model, const Verdict& verdict);

/// What the residual depends on; none where no such test failed.
[[nodiscard]] std::optional<NonlinearKind> nonlinear_kind(const Model& model, const Verdict& verdict);

/// The kind of plant that may describe what a model leaves over, null without one. Of dry friction that depends on the
/// direction of motion, or moves the rod within the dead band of a map (noted_shift()), which takes friction for one;
/// and the model integrates, as that plant does. Of an outflow it depends on the position, and the model comes to rest.
/// Whether the kind does describe it only its fit tells.
[[nodiscard]] const GreyBoxKind* grey_box_to_try(const Model& model, const Verdict& verdict);

/// The same of a model that misses something, whatever its residual looks like: strong friction or a tank that runs
/// empty bends a record so far that the residual of a linear model tells no effect. Null where it misses nothing, or
/// something that lies in the record does that.
[[nodiscard]] const GreyBoxKind* grey_box_left_to_try(const Model& model, const Verdict& verdict);

/// Either one where such a fit to the record of the model holds, as its provenance says (kGreyBoxHolds); else null.
[[nodiscard]] const GreyBoxKind* grey_box_to_advise(const Model& model, const Verdict& verdict);

/// Whether the nonlinear effects of a residual are shown by more than what past input linearly leaves in it, which they
/// then make, too; else those effects may be what a linear part that is missing looks like.
[[nodiscard]] bool is_rather_nonlinear(const Model& model, const Verdict& verdict);

/// @param verdict  of this model
/// @returns unknown without a validation
/// Cost: none to speak of.
[[nodiscard]] ErrorCause error_cause(const Model& model, const Verdict& verdict);

}  // namespace eha::ident
