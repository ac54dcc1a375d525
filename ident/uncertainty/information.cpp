// SPDX-License-Identifier: GPL-3.0-or-later
#include "ident/uncertainty/information.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace eha::ident {

InformationCriteria information(double mean_square, std::size_t parameters, double effective_samples) {
  constexpr double kNever = std::numeric_limits<double>::infinity();
  const double n = effective_samples;
  const auto p = static_cast<double>(parameters);
  const double fit = n * std::log(std::max(mean_square, 1e-300));
  InformationCriteria criteria{parameters, n, fit + 2.0 * p, kNever, fit + p * std::log(n), kNever};
  // With no more independent samples than parameters the corrections have no finite value.
  if (n > p + 1.0) criteria.aicc = criteria.aic + 2.0 * p * (p + 1.0) / (n - p - 1.0);
  if (n > p) criteria.fpe = mean_square * (n + p) / (n - p);
  return criteria;
}

void compare_on_equal_terms(std::span<Model* const> models) {
  const Model* best = nullptr;
  for (const Model* m : models) {
    if (!m->estimation || !m->estimation->information) continue;
    if (best == nullptr || m->estimation->score.mse < best->estimation->score.mse) best = m;
  }
  if (best == nullptr) return;
  const double effective = best->estimation->information->effective_samples;
  for (Model* m : models) {
    if (!m->estimation || !m->estimation->information) continue;
    m->estimation->information =
        information(m->estimation->score.mse, m->estimation->information->parameters, effective);
  }
}

}  // namespace eha::ident
