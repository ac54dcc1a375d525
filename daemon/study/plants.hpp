// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string_view>

#include "ident/record.hpp"

namespace eha::study {

/// A kind of plant whose records are studied. Each seed gives another plant of the kind and other sensor noise.
struct PlantKind {
  std::string_view name;                  ///< in tables: "rig_with_friction"
  std::string_view title;                 ///< displayed name
  std::string_view what;                  ///< one sentence
  std::optional<double> true_order = {};  ///< highest order of G; none: the plant is no transfer function
  ident::Record (*record)(
      std::uint64_t seed);  ///< 50 s at 1 ms of the paper's three tones, noise and converter included
};

/// The simulated rig with friction and without, and plants that are a transfer function of integer and of fractional
/// order behind an input bias. Parameters vary by 20 % about the shipped rig's, or about fixed values.
/// Cost of a record: some 0.2 s.
[[nodiscard]] const std::array<PlantKind, 4>& plant_kinds();

}  // namespace eha::study
