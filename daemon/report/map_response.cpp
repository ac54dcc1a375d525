// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/report/map_response.hpp"

#include <Eigen/Core>
#include <cmath>
#include <cstddef>
#include <numbers>

#include "ident/linear_algebra/least_squares_solvers.hpp"

namespace eha::report {

std::vector<std::complex<double>> map_response(const ident::ValveMap& map, const identify::FitTable& input,
                                               const std::vector<double>& lines_Hz) {
  constexpr double kLeastPart = 1e-6;  // of the input's standard deviation
  const auto rows = static_cast<Eigen::Index>(input.applied.size());
  const auto lines = static_cast<Eigen::Index>(lines_Hz.size());
  if (lines == 0 || rows < 2 * (2 * lines + 1) || input.time_s.size() != input.applied.size()) return {};
  const Eigen::Map<const Eigen::ArrayXd> time_s(input.time_s.data(), rows);
  const Eigen::Map<const Eigen::VectorXd> u(input.applied.data(), rows);
  if (!u.allFinite()) return {};
  Eigen::MatrixXd tones(rows, 2 * lines + 1);
  tones.col(0).setOnes();
  for (Eigen::Index k = 0; k < lines; ++k) {
    const double w = 2.0 * std::numbers::pi * lines_Hz[static_cast<std::size_t>(k)];
    tones.col(2 * k + 1) = (w * time_s).cos();
    tones.col(2 * k + 2) = (w * time_s).sin();
  }
  Eigen::MatrixXd both(rows, 2);
  both << u, mapped(map, u);
  const Eigen::MatrixXd parts = ident::solve_pivoted(tones, both);
  const double least = kLeastPart * std::sqrt((u.array() - u.mean()).square().mean());
  std::vector<std::complex<double>> response;
  for (Eigen::Index k = 0; k < lines; ++k) {
    const std::complex<double> in(parts(2 * k + 1, 0), -parts(2 * k + 2, 0));
    const std::complex<double> out(parts(2 * k + 1, 1), -parts(2 * k + 2, 1));
    if (!(std::abs(in) > least) || !(std::abs(out) > 0.0)) return {};
    response.push_back(out / in);
  }
  return response;
}

}  // namespace eha::report
