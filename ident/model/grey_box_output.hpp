// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>

#include "ident/model/model.hpp"

namespace eha::ident {

/// Returns the linear form of a grey box with a delay, its terms by falling order and the coefficient of s 1.
/// Precondition: as many values as the kind has parameters.
[[nodiscard]] TransferFunction linear_form(const GreyBox& box, double delay_s);

/// Response of a model's grey box, initial_output left out: N samples for an input held between them; 0 before the
/// first. Exact or as finely integrated as its kind says, the delay exactly.
/// @param v  u + input_bias
/// Precondition: the model has a grey box. Cost O(N).
[[nodiscard]] Eigen::VectorXd grey_box_output(const Model& model, const Eigen::Ref<const Eigen::VectorXd>& v,
                                              double step_s);

/// Whether a model of a record is the linear form of a kind, so that the kind may describe the record better: it
/// integrates once where the kind does, else it has two real poles. Whole orders, no map, no zeros.
[[nodiscard]] bool is_linear_form_of(const GreyBoxKind& kind, const Model& model);

/// @throws ConfigError  the model has a grey box, where a linear plant is needed
/// @param why  "eha tune designs for a linear plant"
void require_linear(const Model& model, std::string_view why);

}  // namespace eha::ident
