// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include "core/option_issue.hpp"
#include "ident/excitation/excitation_kind.hpp"

// A kind of excitation is a struct with these members:
//
//   static constexpr std::string_view kName;         value of the key `kind`
//   static void visit_keys(auto& self, auto& keys);  its keys with their ranges, see core/keys.hpp
//   Eigen::VectorXd volts(double step_s, std::size_t samples) const;      the table, t = k step_s, without offset_V
//
// and, if they apply to it:
//
//   std::vector<OptionIssue> check() const;                               conditions beyond the keys' ranges
//   std::vector<OptionIssue> check_timing(double step_s, double duration_s) const;
//   std::vector<double> lines_Hz(double step_s, std::size_t samples) const;   its frequencies, rising
//   std::vector<KeyFrequency> key_frequencies() const;                    frequencies in its keys
//   double shortest_level_s(double duration_s) const;                     shortest time between two of its jumps
//   std::uint64_t seed;                                                   seed of a random kind
//   int realisations, periods;                                            parts of the table, each so many periods
//
// Add it to excitation_kind.hpp; no other code depends on a kind's name.

namespace eha::ident {

/// The signal that is played on the valve.
struct Excitation {
  ExcitationKind kind;
  double offset_V = 0.0;  ///< added to every sample [V]
};

/// The table of volts that an experiment plays, one a tick, t = k step_s, k = 0..samples-1, offset_V included. The same
/// excitation gives the same table on every machine, to the rounding of sin and cos.
/// @param step_s  tick [s], positive   @param samples  at least 1
/// @returns [V]
/// @throws ConfigError  an invalid option, or a band without a line
/// Cost O(N log N), and O(N) for each tone that is no harmonic of the table's length. Thread-safe.
[[nodiscard]] Eigen::VectorXd excitation(const Excitation& excitation, double step_s, std::size_t samples);

/// Frequencies of an excitation [Hz], rising; empty for a continuous spectrum.
/// @throws as excitation()
[[nodiscard]] std::vector<double> excited_lines(const Excitation& excitation, double step_s, std::size_t samples);

/// Value of the key `kind`.
[[nodiscard]] inline std::string_view name_of(const ExcitationKind& kind) {
  return std::visit([](const auto& options) { return std::string_view(options.kName); }, kind);
}

/// Every key with an invalid value; keys as below [excitation].
[[nodiscard]] std::vector<OptionIssue> issues_of(const Excitation& excitation);

/// Every key with a time that does not fit the tick and the length of the table.
[[nodiscard]] std::vector<OptionIssue> timing_issues_of(const Excitation& excitation, double step_s, double duration_s);

/// Frequencies in keys, for comparison with a Nyquist frequency.
[[nodiscard]] std::vector<KeyFrequency> key_frequencies_of(const Excitation& excitation);

/// Shortest time between two jumps [s]; none for an excitation without jumps.
[[nodiscard]] std::optional<double> shortest_level_s(const Excitation& excitation, double duration_s);

/// Seed of a random excitation.
[[nodiscard]] inline std::optional<std::uint64_t> seed_of(const Excitation& excitation) {
  return std::visit(
      [](const auto& kind) -> std::optional<std::uint64_t> {
        if constexpr (requires { kind.seed; }) return kind.seed;
        return std::nullopt;
      },
      excitation.kind);
}

/// Independent signals of the same lines in one table, one after the other, each for the same number of periods, the
/// first of which is a transient.
struct Realisations {
  std::size_t count = 0;    ///< at least 2
  std::size_t periods = 0;  ///< at least 3
};

/// None for a table of one signal.
[[nodiscard]] inline std::optional<Realisations> realisations_of(const Excitation& excitation) {
  return std::visit(
      [](const auto& kind) -> std::optional<Realisations> {
        if constexpr (requires { kind.realisations; }) {
          if (kind.realisations > 1) {
            return Realisations{static_cast<std::size_t>(kind.realisations), static_cast<std::size_t>(kind.periods)};
          }
        }
        return std::nullopt;
      },
      excitation.kind);
}

/// Each kind with its default options.
[[nodiscard]] inline std::array<ExcitationKind, std::variant_size_v<ExcitationKind>> all_excitation_kinds() {
  return []<std::size_t... index>(std::index_sequence<index...>) {
    return std::array<ExcitationKind, sizeof...(index)>{std::variant_alternative_t<index, ExcitationKind>{}...};
  }
  (std::make_index_sequence<std::variant_size_v<ExcitationKind>>{});
}

/// Peak over RMS of a signal, its mean removed: 1.41 for a sine. Throws DataError for an empty or constant signal.
[[nodiscard]] double crest_factor(const Eigen::Ref<const Eigen::VectorXd>& signal);

}  // namespace eha::ident
