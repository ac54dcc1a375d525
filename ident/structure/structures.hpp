// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "ident/structure/structure.hpp"

namespace eha::ident {

/// Most poles of a structure that has degrees.
inline constexpr int kHighestDegree = 10;

/// Named structures.
namespace structures {

/// Integer orders. @throws ConfigError  the degrees make no sense
[[nodiscard]] Structure io(const Degrees& degrees = {});
/// K / (a2 s^2 + a1 s): a pole at 0, as of a position whose speed is set, and a lag.
[[nodiscard]] Structure integrator_lag();
/// K / (a3 s^3 + a2 s^2 + a1 s): a pole at 0 before a resonance, as of a hydraulic cylinder on its oil column.
[[nodiscard]] Structure cylinder();
/// K / (a1 s + a0).
[[nodiscard]] Structure io1();
/// K / (a3 s^3 + a2 s^2 + a1 s + a0), or with one zero.
[[nodiscard]] Structure io3(int zeros = 0);
/// K s^b0 / (a2 s^n2 + a1 s^n1 + a0); b0 is 0 until freed.
[[nodiscard]] Structure fo();
/// (b1 s + b0) / (a2 s^n2 + a1 s^n1 + a0).
[[nodiscard]] Structure fo_with_zero();
/// Polynomials in s^q. @throws ConfigError  the degrees make no sense
[[nodiscard]] Structure commensurate(const Degrees& degrees = {});
/// K / (a1 s^n1 + a0).
[[nodiscard]] Structure lag();

/// A plant of a kind of grey box, on request alone: the ladder does not climb it.
[[nodiscard]] Structure grey_box(const GreyBoxKind& kind);

/// Returns the structure with a valve map before G in place of the input bias.
/// @throws ConfigError  before a grey box
[[nodiscard]] Structure behind_valve(Structure structure);

}  // namespace structures

/// The name of a family in files and on the command line, and its structure.
struct StructureFamily {
  std::string_view name;
  bool has_degrees = false;                ///< poles and zeros are its keys
  Structure (*make)(const Degrees&) = {};  ///< degrees are ignored by a family that has none
};

/// Every family, in the order of messages.
[[nodiscard]] std::span<const StructureFamily> structure_families();

/// @throws ConfigError  no family has this name
[[nodiscard]] const StructureFamily& structure_family(std::string_view name);

/// A named static map before G, for files and the command line.
struct InputMapKind {
  std::string_view name;
  std::string_view suffix;                  ///< appended to the name of a model without a name of its own
  Structure (*put_before)(Structure) = {};  ///< returns the structure with this map in place of its own
};

/// Every kind, in the order of messages: "none", "valve".
[[nodiscard]] std::span<const InputMapKind> input_map_kinds();

/// The kind that a structure has.
[[nodiscard]] const InputMapKind& input_map_kind_of(const Structure& structure);

/// One term of a structure that is given term by term.
struct TermOptions {
  double order = 0.0;                      ///< value, or start when free
  bool free = false;                       ///< whether the order is estimated
  std::optional<double> coefficient = {};  ///< held at this value; none: estimated
  std::optional<double> lower = {};        ///< bounds of a free order
  std::optional<double> upper = {};
};

struct TermLists {
  std::vector<TermOptions> numerator = {TermOptions{}};  ///< 1..11 terms in any order
  std::vector<TermOptions> denominator = {};             ///< the same
};

/// An error in one term.
struct TermFault {
  std::string place;  ///< "denominator[2].order", or "denominator"
  std::string expected;
  std::string got;
};

/// Returns every error for which structure_of_terms() would refuse these terms.
[[nodiscard]] std::vector<TermFault> faults_in_terms(const TermLists& lists);

/// The family name of structures given term by term.
inline constexpr std::string_view kTermsFamily = "terms";

/// Builds a structure of any number of terms. A free order stays within lower and upper. Without these it stays between
/// the nearest orders that are not free, or within 0.05..3 if there are none. The coefficient of the second lowest
/// order of the denominator is 1.
/// @throws ConfigError  the first of faults_in_terms()
[[nodiscard]] Structure structure_of_terms(const TermLists& lists);

}  // namespace eha::ident
