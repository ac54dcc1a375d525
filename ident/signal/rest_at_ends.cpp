// SPDX-License-Identifier: GPL-3.0-or-later
#include "ident/signal/rest_at_ends.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "ident/signal/kept_values.hpp"
#include "ident/statistics/robust.hpp"

namespace eha::ident {
namespace {

constexpr std::size_t kFewestAtAnEnd = 8;
constexpr double kSameInput = 0.02;  // of the input's range
constexpr double kNearlyAll = 0.9;   // of the rows at an end

std::vector<double> inputs_at(const Eigen::Ref<const Eigen::VectorXd>& input,
                              const Eigen::Ref<const Eigen::VectorXd>& output, double end) {
  std::vector<double> found;
  for (Eigen::Index k = 0; k < output.size(); ++k) {
    if (is_same_value(output[k], end)) found.push_back(input[k]);
  }
  return found;
}

}  // namespace

bool rests_at_both_ends(const Eigen::Ref<const Eigen::VectorXd>& input,
                        const Eigen::Ref<const Eigen::VectorXd>& output) {
  if (output.size() == 0 || input.size() != output.size()) return false;
  const std::vector<double> above = inputs_at(input, output, output.maxCoeff());
  const std::vector<double> below = inputs_at(input, output, output.minCoeff());
  if (std::min(above.size(), below.size()) < kFewestAtAnEnd) return false;
  const double range = input.maxCoeff() - input.minCoeff();
  const auto are_all_about = [&](const std::vector<double>& inputs, double one) {
    const auto near =
        std::count_if(inputs.begin(), inputs.end(), [&](double u) { return std::abs(u - one) <= kSameInput * range; });
    return static_cast<double>(near) >= kNearlyAll * static_cast<double>(inputs.size());
  };
  return are_all_about(above, median_of(below)) && are_all_about(below, median_of(above));
}

}  // namespace eha::ident
