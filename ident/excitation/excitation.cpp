// SPDX-License-Identifier: GPL-3.0-or-later
#include "ident/excitation/excitation.hpp"

#include <fmt/format.h>

#include <cmath>
#include <limits>
#include <string>

#include "core/error.hpp"
#include "core/range_text.hpp"

namespace eha::ident {
namespace {

/// Checks the values of a kind's keys against their ranges.
class RangeCheck {
 public:
  std::vector<OptionIssue> issues;

  void number(std::string_view key, double value, const Range& range, Need = Need::required) {
    if (!range.contains(value)) add(key, eha::describe(range), fmt::format("{}", value));
  }
  template <class Integer>
  void integer(std::string_view key, Integer value, std::int64_t low, std::int64_t high, Need = Need::required) {
    if (std::in_range<std::int64_t>(value) && std::cmp_greater_equal(value, low) && std::cmp_less_equal(value, high)) {
      return;
    }
    add(key, eha::describe_integers(low, high), fmt::format("{}", value));
  }
  void table(std::string_view key, const auto& table) { check_beneath(key, table); }
  template <class Table>
  void tables(std::string_view key, const std::vector<Table>& tables) {
    if (tables.empty()) add(key, "an array of at least one table", "none");
    for (std::size_t i = 0; i < tables.size(); ++i) check_beneath(fmt::format("{}[{}]", key, i), tables[i]);
  }
  // Nothing to check here: the reader of the file accepts no other values.
  void text(std::string_view, const std::string&, Need = Need::required) {}
  void choice(std::string_view, const auto&, const auto&, Need = Need::required) {}
  void volts_file(std::string_view, const VoltsFile&) {}

 private:
  void check_beneath(std::string_view key, const auto& table) {
    const std::string outer = prefix_;
    prefix_ = fmt::format("{}{}.", outer, key);
    table.visit_keys(table, *this);
    prefix_ = outer;
  }
  void add(std::string_view key, const std::string& expected, const std::string& got) {
    issues.push_back({fmt::format("{}{}", prefix_, key), fmt::format("expected {}, got {}", expected, got)});
  }

  std::string prefix_;
};

void check(const Excitation& excitation, double step_s, std::size_t samples) {
  if (!(step_s > 0.0) || !std::isfinite(step_s)) throw ConfigError("excitation: expected a tick above 0 s");
  if (samples == 0) throw ConfigError("excitation: expected at least one sample");
  const std::vector<OptionIssue> issues = issues_of(excitation);
  if (!issues.empty()) throw ConfigError(to_lines(issues, "excitation"));
}

}  // namespace

Eigen::VectorXd excitation(const Excitation& excitation, double step_s, std::size_t samples) {
  check(excitation, step_s, samples);
  return std::visit([&](const auto& kind) { return kind.volts(step_s, samples); }, excitation.kind).array() +
         excitation.offset_V;
}

std::vector<double> excited_lines(const Excitation& excitation, double step_s, std::size_t samples) {
  check(excitation, step_s, samples);
  return std::visit(
      [&](const auto& kind) -> std::vector<double> {
        if constexpr (requires { kind.lines_Hz(step_s, samples); }) return kind.lines_Hz(step_s, samples);
        return {};
      },
      excitation.kind);
}

std::vector<OptionIssue> issues_of(const Excitation& excitation) {
  RangeCheck ranges;
  ranges.number("offset_V", excitation.offset_V, Range::any());
  std::visit(
      [&](const auto& kind) {
        kind.visit_keys(kind, ranges);
        if constexpr (requires { kind.check(); }) {
          const std::vector<OptionIssue> more = kind.check();
          ranges.issues.insert(ranges.issues.end(), more.begin(), more.end());
        }
      },
      excitation.kind);
  return ranges.issues;
}

std::vector<OptionIssue> timing_issues_of(const Excitation& excitation, double step_s, double duration_s) {
  return std::visit(
      [&](const auto& kind) -> std::vector<OptionIssue> {
        if constexpr (requires { kind.check_timing(step_s, duration_s); }) return kind.check_timing(step_s, duration_s);
        return {};
      },
      excitation.kind);
}

std::vector<KeyFrequency> key_frequencies_of(const Excitation& excitation) {
  return std::visit(
      [](const auto& kind) -> std::vector<KeyFrequency> {
        if constexpr (requires { kind.key_frequencies(); }) return kind.key_frequencies();
        return {};
      },
      excitation.kind);
}

std::optional<double> shortest_level_s(const Excitation& excitation, double duration_s) {
  return std::visit(
      [&](const auto& kind) -> std::optional<double> {
        if constexpr (requires { kind.shortest_level_s(duration_s); }) return kind.shortest_level_s(duration_s);
        return std::nullopt;
      },
      excitation.kind);
}

double crest_factor(const Eigen::Ref<const Eigen::VectorXd>& signal) {
  if (signal.size() == 0) throw DataError("crest_factor: expected at least one sample");
  const Eigen::ArrayXd centred = signal.array() - signal.mean();
  const double peak = centred.abs().maxCoeff();
  if (!(peak > 1e-14 * signal.cwiseAbs().maxCoeff())) throw DataError("crest_factor: the signal is constant");
  return peak / std::sqrt(centred.square().mean());
}

}  // namespace eha::ident
