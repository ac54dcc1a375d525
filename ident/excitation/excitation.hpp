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
// and, where they mean something for it:
//
//   std::vector<OptionIssue> check() const;                               what the keys' ranges cannot say
//   std::vector<OptionIssue> check_timing(double step_s, double duration_s) const;
//   std::vector<double> lines_Hz(double step_s, std::size_t samples) const;   frequencies it consists of, rising
//   std::vector<KeyFrequency> key_frequencies() const;                    frequencies in its keys
//   double shortest_level_s(double duration_s) const;                     it jumps, and stays at least so long
//   std::uint64_t seed;                                                   it is random
//
// Add it to excitation_kind.hpp; nothing else asks for a kind's name.

namespace eha::ident {

/// What is played on the valve.
struct Excitation {
  ExcitationKind kind;
  double offset_V = 0.0;  ///< added to every sample [V]
};

/// The table of volts that an experiment plays, one a tick, t = k step_s, k = 0..samples-1, offset_V included. The same
/// excitation gives the same table on every machine, to the rounding of sin and cos.
/// @param step_s  tick [s], positive   @param samples  at least 1
/// @returns [V]
/// @throws ConfigError  an option that makes no sense for its kind, or a band that holds no line
/// Cost O(N log N), and O(N) for each tone that is no harmonic of the table's length. Thread-safe.
[[nodiscard]] Eigen::VectorXd excitation(const Excitation& excitation, double step_s, std::size_t samples);

/// Frequencies that an excitation consists of [Hz], rising; empty for a continuous spectrum.
/// @throws as excitation()
[[nodiscard]] std::vector<double> excited_lines(const Excitation& excitation, double step_s, std::size_t samples);

/// Value of the key `kind`.
[[nodiscard]] inline std::string_view name_of(const ExcitationKind& kind) {
  return std::visit([](const auto& options) { return std::string_view(options.kName); }, kind);
}

/// Every key with a value that makes no sense; keys as beneath [excitation].
[[nodiscard]] std::vector<OptionIssue> issues_of(const Excitation& excitation);

/// Every key with a time that does not suit the tick and the length of the table.
[[nodiscard]] std::vector<OptionIssue> timing_issues_of(const Excitation& excitation, double step_s, double duration_s);

/// Frequencies in keys, for comparison with a Nyquist frequency.
[[nodiscard]] std::vector<KeyFrequency> key_frequencies_of(const Excitation& excitation);

/// Shortest time between two jumps of an excitation that jumps [s]; none of one that does not.
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
