// SPDX-License-Identifier: GPL-3.0-or-later
#include "ident/uncertainty/information.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <string>

#include "ident/signal/autoregression.hpp"

namespace eha::ident {
namespace {

constexpr double kNever = std::numeric_limits<double>::infinity();
constexpr double kLeastVariance = 1e-300;

/// FNV-1a of the samples' bits: equal samples in equal order give the same text, others practically never.
std::string identity_of(const Eigen::VectorXd& samples) {
  std::uint64_t hash = 0xcbf29ce484222325U;
  for (const double sample : samples) {
    const auto bits = std::bit_cast<std::uint64_t>(sample);
    for (int shift = 0; shift < 64; shift += 8) hash = (hash ^ ((bits >> shift) & 0xffU)) * 0x100000001b3U;
  }
  return fmt::format("{:016x}", hash);
}

}  // namespace

InformationCriteria information(const Eigen::VectorXd& residual, const Eigen::VectorXd& measured,
                                std::size_t parameters, double effective_samples) {
  const double mean_square = residual.squaredNorm() / static_cast<double>(residual.size());
  const double effective = effective_samples;
  const auto p = static_cast<double>(parameters);
  const double fit = effective * std::log(std::max(mean_square, kLeastVariance));
  InformationCriteria criteria;
  criteria.parameters = parameters;
  criteria.effective_samples = effective;
  criteria.aic = fit + 2.0 * p;
  criteria.bic = fit + p * std::log(effective);
  // With no more independent samples than parameters the corrections have no finite value.
  criteria.aicc = effective > p + 1.0 ? criteria.aic + 2.0 * p * (p + 1.0) / (effective - p - 1.0) : kNever;
  criteria.fpe = effective > p ? mean_square * (effective + p) / (effective - p) : kNever;

  criteria.record = identity_of(measured);
  criteria.ar_bic = kNever;
  if (residual.size() <= kHighestAutoregression) return criteria;
  const Autoregression noise = autoregression(residual);
  const Eigen::VectorXd compared = measured.tail(static_cast<Eigen::Index>(noise.samples));
  const double spread = (compared.array() - compared.mean()).square().mean();
  const auto n = static_cast<double>(noise.samples);
  criteria.samples = noise.samples;
  criteria.ar_order = static_cast<std::size_t>(noise.coefficients.size());
  criteria.ar_bic = n * std::log(std::max(noise.variance / std::max(spread, kLeastVariance), kLeastVariance)) +
                    (p + static_cast<double>(criteria.ar_order)) * std::log(n);
  return criteria;
}

}  // namespace eha::ident
