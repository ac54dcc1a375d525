// SPDX-License-Identifier: GPL-3.0-or-later
#include "ident/design/known_model.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <vector>

#include "core/error.hpp"
#include "ident/model/grey_box_output.hpp"
#include "ident/uncertainty/covariance.hpp"
#include "ident/uncertainty/output_derivatives.hpp"
#include "ident/uncertainty/stored_covariance.hpp"

namespace eha::ident {

KnownModel known_model(const Model& model, const std::string& parameter, const ImprovementTask& task) {
  require_linear(model, "an experiment is designed for a linear plant");
  KnownModel known{with_rising_terms(model), stored_covariance(model), {}, 0};
  const bool has_noise = model.estimation && model.estimation->noise && model.estimation->compared_step_s;
  if (!has_noise || known.covariance.parameters.empty()) {
    throw ConfigError(fmt::format(
        "model {}: a prediction needs the standard errors and the noise that `eha fit` writes", model.name));
  }
  known.noise = *model.estimation->noise;
  known.compared_step_s = *model.estimation->compared_step_s;
  std::vector<std::string> names;
  for (const ParameterKey& key : known.covariance.parameters) names.push_back(key.name);
  const auto at = std::find(names.begin(), names.end(), parameter);
  if (at == names.end()) {
    throw ConfigError(
        fmt::format("model {}: expected a parameter that it estimates and its record determines (one of "
                    "{}), got {}",
                    model.name, fmt::join(names, ", "), parameter));
  }
  known.target = static_cast<std::size_t>(at - names.begin());
  const double compared_step_s = task.limits.step_s * task.options.decimation;
  if (std::abs(known.compared_step_s - compared_step_s) > 1e-6 * compared_step_s) {
    throw ConfigError(fmt::format(
        "model {}: its noise is known at samples {:.6g} s apart, but the experiment would compare every {:.6g} s",
        model.name, known.compared_step_s, compared_step_s));
  }
  return known;
}

double std_by(const KnownModel& known, const Eigen::Ref<const Eigen::VectorXd>& input, const ImprovementTask& task) {
  Record record;
  record.step_s = task.limits.step_s;
  record.input = input;
  record.output = Eigen::VectorXd::Zero(input.size());
  const Comparison comparison =
      compare_every(static_cast<std::size_t>(input.size()), static_cast<std::size_t>(task.options.decimation),
                    discarded_rows(task.options.discard_s, record.step_s));
  OutputOnRecord outputs(record, comparison);
  const Eigen::MatrixXd all = output_derivatives(known.model, outputs, known.covariance);
  const auto rows = static_cast<Eigen::Index>(std::lround(task.options.split * static_cast<double>(all.rows())));
  if (rows <= 2 * kHighestAutoregression + all.cols() || !all.allFinite()) {
    return std::numeric_limits<double>::infinity();
  }
  std::vector<std::string> names;
  for (const ParameterKey& key : known.covariance.parameters) names.push_back(key.name);
  // As the model was estimated: with its noise model, or without one and with the errors due to the coloured residual.
  const Eigen::MatrixXd seen = known.noise.with_parameters ? whitened(all.topRows(rows), whitening_model(known.noise))
                                                           : Eigen::MatrixXd(all.topRows(rows));
  const Uncertainty expected = uncertainty(seen, names,
                                           known.noise.with_parameters ? white_residual(known.noise, seen.rows())
                                                                       : coloured_residual(known.noise, seen.rows()));
  const auto& lost = expected.indistinguishable;
  if (std::find(lost.begin(), lost.end(), names[known.target]) != lost.end()) {
    return std::numeric_limits<double>::infinity();
  }
  const auto i = static_cast<Eigen::Index>(known.target);
  return std::sqrt(expected.covariance(i, i));
}

}  // namespace eha::ident
