// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <string>

#include "ident/design/improvement.hpp"
#include "ident/design/residual_noise.hpp"
#include "ident/model/model.hpp"
#include "ident/uncertainty/bode_curve.hpp"

namespace eha::ident {

/// A model file prepared for predictions of one parameter's standard error.
struct KnownModel {
  Model model;  ///< terms rising
  ParameterCovariance covariance;
  ResidualNoise noise;
  double compared_step_s = 0.0;  ///< between the samples of the noise model
  std::size_t target = 0;        ///< index of the parameter in the covariance
};

/// @throws ConfigError  as predicted_std()
[[nodiscard]] KnownModel known_model(const Model& model, const std::string& parameter, const ImprovementTask& task);

/// Returns the target's standard error after an estimation from a new input; infinite if the input does not determine
/// it.
[[nodiscard]] double std_by(const KnownModel& known, const Eigen::Ref<const Eigen::VectorXd>& input,
                            const ImprovementTask& task);

}  // namespace eha::ident
