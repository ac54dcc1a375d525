// SPDX-License-Identifier: GPL-3.0-or-later
#include "ident/uncertainty/stored_covariance.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

namespace eha::ident {

ParameterCovariance stored_covariance(const Model& model) {
  ParameterCovariance known;
  if (!model.estimation || !model.estimation->correlation) return known;
  const ParameterCorrelation& correlation = *model.estimation->correlation;
  std::vector<std::size_t> rows;
  std::vector<double> deviations;
  for (std::size_t i = 0; i < std::min(correlation.names.size(), correlation.matrix.size()); ++i) {
    const auto at = std::find_if(model.parameters.begin(), model.parameters.end(),
                                 [&](const ParameterEstimate& p) { return p.name == correlation.names[i]; });
    if (at == model.parameters.end() || !std::isfinite(at->std)) continue;
    rows.push_back(i);
    deviations.push_back(at->std);
    known.parameters.push_back(key_of(at->name, model.transfer_function.numerator.size()));
  }
  known.matrix.resize(static_cast<Eigen::Index>(rows.size()), static_cast<Eigen::Index>(rows.size()));
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const std::vector<double>& row = correlation.matrix[rows[i]];
    for (std::size_t j = 0; j < rows.size(); ++j) {
      const double r = rows[j] < row.size() && std::isfinite(row[rows[j]]) ? row[rows[j]] : (i == j ? 1.0 : 0.0);
      known.matrix(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j)) = r * deviations[i] * deviations[j];
    }
  }
  return known;
}

}  // namespace eha::ident
