// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "ident/estimation/ladder.hpp"
#include "ident/fit_options.hpp"
#include "ident/signal/intersample.hpp"
#include "ident/structure/structure_options.hpp"

namespace CLI {
class App;
}

namespace eha::cli {

/// Options on the use of a record. For unset members the experiment's value or the default applies.
struct RecordOptions {
  std::optional<int> decimation = {};
  std::optional<double> discard_s = {};
  std::optional<double> split = {};
  std::optional<double> input_before = {};
  std::optional<ident::Intersample> intersample = {};  ///< none: as the model says, else held
};

/// Adds --decimate, --discard and --intersample.
void add_record_options(CLI::App& app, RecordOptions& record);

/// Adds --intersample alone.
void add_intersample_option(CLI::App& app, std::optional<ident::Intersample>& intersample);

/// " --intersample foh" for a command that is offered after one with that option; empty without it.
[[nodiscard]] std::string intersample_words(const std::optional<ident::Intersample>& given);

/// Options on the models to fit.
struct ModelOptions {
  /// --model, in order, of model_names(), or kLadder alone; without --structure too: the experiment's
  std::vector<std::string> families = {};
  std::vector<std::string> structure_files = {};  ///< --structure, in order
  std::optional<int> poles = {};
  std::optional<int> zeros = {};
  std::optional<std::string> delay = {};  ///< "free" or seconds
  std::optional<ident::InitialState> initial_state = {};
  std::optional<std::string> input_map = {};  ///< "none" or "valve"
  std::vector<std::string> fixed = {};        ///< NAME=VALUE
  std::vector<std::string> free = {};         ///< NAME
  std::vector<std::string> starts = {};       ///< NAME=VALUE
  std::vector<std::string> bounds = {};       ///< NAME=LOW:HIGH
};

/// The word of `eha fit --model` for every structure of the ladder, where an experiment names models.
inline constexpr std::string_view kLadder = "ladder";

/// The names of structures that --model takes: of each family, and of each behind each map ("io_valve").
[[nodiscard]] std::vector<std::string> model_names();

/// Whether the ladder is asked for, whatever an experiment names. @throws UsageError  beside a structure
[[nodiscard]] bool climbs_ladder(const ModelOptions& options);

/// Returns the models that a command line requests.
/// @param configured  the experiment's models; --model selects those of a structure, or a plain one if there is none;
///                    --structure adds the one of a file; without both all of them: if there are none, or kLadder is
///                    asked for, returns none, and the caller climbs the ladder with ladder_for()
/// @throws UsageError  a malformed NAME=VALUE, a structure requested twice, --poles although no model has poles
/// @throws ConfigError, PermissionError  as config::load_structure
[[nodiscard]] std::vector<ident::StructureOptions> structures_for(
    const ModelOptions& options, const std::vector<ident::StructureOptions>& configured);

/// Returns the options' requirements on every structure of the ladder; --poles and --zeros apply to its `io`.
/// @throws UsageError  as structures_for()
[[nodiscard]] ident::LadderOptions ladder_for(const ModelOptions& options);

/// Overrides the options that the command line sets. @param parts  rows of the record for one of the file's
/// @returns the changed `options`
[[nodiscard]] ident::FitOptions with(ident::FitOptions options, const RecordOptions& record, int parts);

/// Models named on the command line are required; those of an experiment may be replaced by others.
[[nodiscard]] bool names_models(const ModelOptions& options);

}  // namespace eha::cli
