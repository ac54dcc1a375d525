// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <map>
#include <string>

namespace eha::ident {

/// Counts the work of a search, independently of the machine.
struct Work {
  std::size_t global_searches = 0;
  std::size_t local_searches = 0;
  std::size_t evaluations = 0;  ///< trials of the model, unstable ones included
  std::size_t jacobians = 0;
  std::size_t transforms = 0;  ///< Fourier transforms, forward and inverse

  [[nodiscard]] std::size_t simulations() const noexcept { return evaluations + jacobians; }

  Work& operator+=(const Work& other) {
    global_searches += other.global_searches;
    local_searches += other.local_searches;
    evaluations += other.evaluations;
    jacobians += other.jacobians;
    transforms += other.transforms;
    return *this;
  }

  bool operator==(const Work&) const = default;
};

/// The work of each stage of a fit: "search", "refine", "noise", "intervals"; "inside" for the fits of sub-structures,
/// "left_out" for those without a term of a free order.
using WorkByStage = std::map<std::string, Work>;

inline void add(WorkByStage& sum, const WorkByStage& other) {
  for (const auto& [stage, work] : other) sum[stage] += work;
}

[[nodiscard]] inline Work total(const WorkByStage& stages) {
  Work sum;
  for (const auto& [stage, work] : stages) sum += work;
  return sum;
}

}  // namespace eha::ident
