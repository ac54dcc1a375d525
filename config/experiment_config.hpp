// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <numbers>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include "config/experiment_kind.hpp"
#include "config/named_files.hpp"
#include "config/position.hpp"
#include "config/rig_config.hpp"
#include "ident/acceptance_limits.hpp"
#include "ident/fit_options.hpp"
#include "ident/structure/structure_options.hpp"

namespace eha::config {

/// One day; a longer time probably has the wrong unit.
inline constexpr double kLongestRun_s = 86400.0;

/// The keys of [record], which are members of FitOptions.
struct RecordKeys {
  static void visit_keys(auto& fit, auto& keys) {
    keys.number("discard_s", fit.discard_s, Range::between(0.0, kLongestRun_s), Need::optional);
    keys.integer("decimation", fit.decimation, 1, 100'000, Need::optional);
    keys.number("split", fit.split, Range{.low = 0.0, .high = 1.0, .low_excluded = true}, Need::optional);
    keys.number("input_before_V", fit.input_before, Range::any());
  }
};

/// The keys of [acceptance], which are members of AcceptanceLimits.
struct AcceptanceKeys {
  static void visit_keys(auto& limits, auto& keys) {
    keys.number("min_validation_r2_percent", limits.min_validation_r2_percent, Range::between(0.0, 100.0),
                Need::optional);
    keys.number("max_abs_error_in", limits.max_abs_error, Range::above(0.0), Need::optional);
    keys.boolean("require_stable", limits.require_stable, Need::optional);
    keys.number("min_stability_margin_rad", limits.min_stability_margin_rad,
                Range::between(0.0, std::numbers::pi / 2.0), Need::optional);
    keys.number("usable_gain_error_dB", limits.usable_gain_error_dB, Range::above(0.0), Need::optional);
    keys.number("usable_phase_error_deg", limits.usable_phase_error_deg, Range::above(0.0), Need::optional);
  }
};

/// The keys of [[model.parameter]], which are members of ParameterRequest.
struct ParameterKeys {
  static void visit_keys(auto& request, auto& keys) {
    keys.text("name", request.name);
    keys.boolean("fixed", request.fixed);
    keys.number("start", request.start, Range::any());
    keys.number("lower", request.lower, Range::any());
    keys.number("upper", request.upper, Range::any());
  }
};

/// [identification]
struct Identification {
  enum class Procedures { standard, paper, both };
  static constexpr auto kProcedures = std::to_array<std::pair<std::string_view, Procedures>>(
      {{"default", Procedures::standard}, {"paper", Procedures::paper}, {"both", Procedures::both}});
  Procedures procedures = Procedures::standard;
  std::uint64_t seed = ident::FitOptions{}.seed;

  static void visit_keys(auto& self, auto& keys) {
    keys.choice("procedure", self.procedures, kProcedures, Need::optional);
    keys.integer("seed", self.seed, 0, std::numeric_limits<std::int64_t>::max(), Need::optional);
  }
};

/// A whole experiment.toml.
struct ExperimentConfig {
  std::string name;
  ExperimentKind kind;
  double duration_s = 0.0;  ///< of one repetition [s]
  int repetitions = 1;
  ident::FitOptions fit;  ///< decimation, discarded time, split, procedure, seed
  /// procedure = "both": also fits by the paper's procedure, for comparison.
  bool compares_with_paper = false;
  std::vector<ident::StructureOptions> models;
  ident::AcceptanceLimits acceptance;
  std::string file_name;  ///< as given, for messages
  std::string text;       ///< the file's content as read, for the run's manifest
  PositionMap positions;  ///< position of each key in the file

  /// The excitation and its playing options; none for a kind whose record is not fitted.
  [[nodiscard]] const Played* played() const noexcept { return std::get_if<Played>(&kind); }
  // None for the other kinds.
  [[nodiscard]] const Placing* placing() const noexcept { return std::get_if<Placing>(&kind); }
  [[nodiscard]] const Tracking* tracking() const noexcept { return std::get_if<Tracking>(&kind); }
  /// Whether the record is measured for the valve sheet.
  [[nodiscard]] bool characterises() const noexcept { return std::holds_alternative<SheetRun>(kind); }

  [[nodiscard]] Identification identification() const noexcept {
    using Procedures = Identification::Procedures;
    const bool is_paper = fit.procedure == ident::Procedure::paper;
    return {.procedures = compares_with_paper ? Procedures::both
                          : is_paper          ? Procedures::paper
                                              : Procedures::standard,
            .seed = fit.seed};
  }
};

/// Reads an experiment file and the files that it names, and reports everything that is wrong at once, in file order.
/// Checks that need the tick or the rig are in prepare(), see prepared_experiment.hpp.
/// @throws ConfigError      missing, unreadable, not TOML, or wrong
/// @throws PermissionError  the caller may not read it
[[nodiscard]] ExperimentConfig load_experiment(const std::string& path);

/// Reads an experiment from text in memory. file_name is used in messages, and with NamedFiles::read also to locate the
/// experiment's own files.
/// @throws ConfigError as load_experiment
[[nodiscard]] ExperimentConfig parse_experiment(std::string_view text, const std::string& file_name,
                                                NamedFiles named_files = NamedFiles::refuse);

/// Returns the number of ticks of one repetition. Valid after prepare().
[[nodiscard]] std::size_t samples_per_repetition(const ExperimentConfig& experiment, const RigConfig& rig);

}  // namespace eha::config
