// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "ident/model/model.hpp"

namespace eha::ident {

/// What explains the greatest part of a model's error on a record, by the findings of its validation. Of several the
/// first of this list.
enum class ErrorCause {
  end_stop,      ///< the output stands at an end
  jump,          ///< one sudden lasting change
  other_plant,   ///< the model is of another plant
  missing_part,  ///< the input moves the residual, or it is far above the noise between periods
  nonlinear,     ///< the residual depends on level, motion or position
  feedback,      ///< the residual correlates with the input that follows
  drift,         ///< the residual wanders
  white_noise,   ///< every test passed: uncorrelated with the input and with itself, and no offset
  unknown,       ///< none of these, or too few samples to tell
};

/// @param verdict  of this model
/// @returns unknown without a validation
/// Cost: none to speak of.
[[nodiscard]] ErrorCause error_cause(const Model& model, const Verdict& verdict);

}  // namespace eha::ident
