// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>

#include "ident/fractional/simulate.hpp"
#include "ident/model/model.hpp"
#include "ident/record.hpp"
#include "ident/signal/decimation.hpp"

namespace eha::ident {

/// Output of the whole model, bias or map, offset and free response included: N samples at the input's times.
/// @throws as simulate(TransferFunction, ...)
[[nodiscard]] Eigen::VectorXd simulate(const Model& model, const Eigen::Ref<const Eigen::VectorXd>& input,
                                       double step_s, SimulationMethod method = SimulationMethod::exact);

/// The parts of a model's output at the rows of a comparison, filtered like the data.
struct ModelOutput {
  Eigen::VectorXd forced;  ///< G(v), count rows
  Eigen::MatrixXd free;    ///< to each term of the initial state, then of the past input, unscaled; none for neither
  [[nodiscard]] Eigen::VectorXd total(const Model& model) const;
};

/// A model that grows is simulated by the direct recursion and may overflow; one that does not, exactly.
[[nodiscard]] ModelOutput output_at(const Model& model, const Record& record, const Comparison& comparison);

/// The model with initial_output and initial_state fitted anew to `measured` over the same rows.
[[nodiscard]] Model with_offset_fitted(const Model& model, const ModelOutput& output, const Eigen::VectorXd& measured);

}  // namespace eha::ident
