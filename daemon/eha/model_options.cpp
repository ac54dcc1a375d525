// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/eha/model_options.hpp"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>

#include "config/structure_file.hpp"
#include "core/error.hpp"
#include "daemon/eha/option_values.hpp"

namespace eha::cli {
namespace {

constexpr std::array kIntersample{Choice<ident::Intersample>{"zoh", ident::Intersample::held},
                                  Choice<ident::Intersample>{"foh", ident::Intersample::straight}};

using ident::ParameterRequest;
using ident::Structure;
using ident::StructureOptions;

StructureOptions plain(Structure structure) {
  StructureOptions asked;
  asked.name = structure.family;
  asked.structure = std::move(structure);
  return asked;
}

double number(std::string_view text, const std::string& option, const std::string& whole) {
  double value = 0.0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size() || !std::isfinite(value)) {
    throw UsageError(fmt::format("{} {}: expected a finite number, got \"{}\"", option, whole, text));
  }
  return value;
}

/// Splits at the first `separator`. @throws UsageError  there is none, or a part is empty
std::pair<std::string_view, std::string_view> split(std::string_view text, char separator, const std::string& option,
                                                    const char* form) {
  const std::size_t at = text.find(separator);
  if (at == std::string_view::npos || at == 0 || at + 1 == text.size()) {
    throw UsageError(fmt::format("{} {}: expected {}", option, text, form));
  }
  return {text.substr(0, at), text.substr(at + 1)};
}

ParameterRequest& request_for(StructureOptions& structure, std::string_view name) {
  auto found = std::find_if(structure.parameters.begin(), structure.parameters.end(),
                            [&](const ParameterRequest& request) { return request.name == name; });
  if (found == structure.parameters.end()) {
    structure.parameters.emplace_back().name = name;
    found = structure.parameters.end() - 1;
  }
  return *found;
}

void apply_parameters(const ModelOptions& options, StructureOptions& structure) {
  for (const std::string& text : options.fixed) {
    const auto [name, value] = split(text, '=', "--fix", "NAME=VALUE");
    ParameterRequest& request = request_for(structure, name);
    request.fixed = true;
    request.start = number(value, "--fix", text);
  }
  for (const std::string& name : options.free) request_for(structure, name).fixed = false;
  for (const std::string& text : options.starts) {
    const auto [name, value] = split(text, '=', "--start", "NAME=VALUE");
    request_for(structure, name).start = number(value, "--start", text);
  }
  for (const std::string& text : options.bounds) {
    const auto [name, range] = split(text, '=', "--bound", "NAME=LOW:HIGH");
    if (range.find(':') == std::string_view::npos) {
      throw UsageError(fmt::format("--bound {}: expected NAME=LOW:HIGH", text));
    }
    const auto [low, high] = split(range, ':', "--bound", "NAME=LOW:HIGH");
    ParameterRequest& request = request_for(structure, name);
    request.lower = number(low, "--bound", text);
    request.upper = number(high, "--bound", text);
    if (!(*request.lower < *request.upper)) {
      throw UsageError(fmt::format("--bound {}: the lower bound must be below the upper one", text));
    }
  }
}

/// Lists the names of the families that have degrees, for a sentence.
std::string names_with_degrees() {
  std::vector<std::string_view> names;
  for (const ident::StructureFamily& family : ident::structure_families()) {
    if (family.has_degrees) names.push_back(family.name);
  }
  return fmt::format("{}", fmt::join(names, " and "));
}

/// Returns the degrees, changed by the options. @throws UsageError  more zeros than poles
ident::Degrees with_options(ident::Degrees degrees, const ModelOptions& options) {
  degrees.poles = options.poles.value_or(degrees.poles);
  degrees.zeros = options.zeros.value_or(degrees.zeros);
  if (degrees.zeros > degrees.poles) {
    throw UsageError(
        fmt::format("--zeros: expected at most {}, the number of poles, got {}", degrees.poles, degrees.zeros));
  }
  return degrees;
}

void apply_degrees(const ModelOptions& options, std::vector<StructureOptions>& structures) {
  if (!options.poles && !options.zeros) return;
  const auto has_degrees = [](const StructureOptions& asked) { return asked.structure.degrees.has_value(); };
  if (std::none_of(structures.begin(), structures.end(), has_degrees)) {
    throw UsageError(
        fmt::format("--poles and --zeros are for the models {}, and none of these is asked for", names_with_degrees()));
  }
  for (StructureOptions& asked : structures) {
    if (!has_degrees(asked)) continue;
    const ident::Degrees degrees = with_options(*asked.structure.degrees, options);
    const Structure before = asked.structure;
    asked.structure = ident::structure_family(asked.structure.family).make(degrees);
    asked.structure.delay = before.delay;
    asked.structure.input_map = before.input_map;
  }
}

void apply_delay(const std::string& text, ident::StructureParameter& delay) {
  const bool free = text == "free";
  delay.freedom = free ? ident::Freedom::free : ident::Freedom::held;
  if (free) return;
  delay.value = number(text, "--delay", text);
  if (delay.value < 0.0) throw UsageError(fmt::format("--delay: expected free or seconds >= 0, got {}", text));
}

const ident::InputMapKind& input_map_kind(const std::string& name) {
  const auto kinds = ident::input_map_kinds();
  return *std::find_if(kinds.begin(), kinds.end(), [&](const auto& kind) { return kind.name == name; });
}

/// If the option adds or removes a map, the model's name no longer fits.
void apply_input_map(const std::string& name, StructureOptions& asked) {
  const ident::InputMapKind& before = ident::input_map_kind_of(asked.structure);
  if (before.name == name) return;
  const ident::InputMapKind& kind = input_map_kind(name);
  asked.structure = kind.put_before(std::move(asked.structure));
  if (!before.suffix.empty() && asked.name.ends_with(before.suffix)) {
    asked.name.resize(asked.name.size() - before.suffix.size());
  }
  asked.name += kind.suffix;
}

/// The experiment's models of the family, else a plain one.
void choose(const std::string& family, const std::vector<StructureOptions>& configured,
            std::vector<StructureOptions>& structures) {
  const std::size_t before = structures.size();
  std::copy_if(configured.begin(), configured.end(), std::back_inserter(structures),
               [&](const StructureOptions& asked) { return asked.structure.family == family; });
  if (structures.size() == before) structures.push_back(plain(ident::structure_family(family).make({})));
}

/// The map that the name of a model ends in, as that of io_valve; none for a family's own name.
const ident::InputMapKind* map_in_name(const std::string& name) {
  const auto families = ident::structure_families();
  for (const ident::InputMapKind& kind : ident::input_map_kinds()) {
    if (kind.suffix.empty() || !name.ends_with(kind.suffix)) continue;
    const std::string family = name.substr(0, name.size() - kind.suffix.size());
    if (std::any_of(families.begin(), families.end(), [&](const auto& known) { return known.name == family; })) {
      return &kind;
    }
  }
  return nullptr;
}

std::vector<StructureOptions> chosen(const ModelOptions& options, const std::vector<StructureOptions>& configured) {
  if (options.families.empty() && options.structure_files.empty()) return configured;
  if (climbs_ladder(options)) return {};
  std::vector<StructureOptions> structures;
  for (auto family = options.families.begin(); family != options.families.end(); ++family) {
    const auto same = [&](const std::string& other) { return other == *family; };
    if (std::any_of(options.families.begin(), family, same)) {
      throw UsageError(
          fmt::format("--model {} is given twice, and each would be written to {}.json", *family, *family));
    }
    // "io_valve", as the tables name it, is io behind a valve's map.
    const ident::InputMapKind* map = map_in_name(*family);
    const std::size_t before = structures.size();
    choose(map == nullptr ? *family : family->substr(0, family->size() - map->suffix.size()), configured, structures);
    for (std::size_t i = before; map != nullptr && i < structures.size(); ++i) {
      apply_input_map(std::string(map->name), structures[i]);
    }
  }
  for (const std::string& file : options.structure_files) {
    StructureOptions asked = config::load_structure(file);
    const auto same_name = [&](const StructureOptions& other) { return other.name == asked.name; };
    if (std::any_of(structures.begin(), structures.end(), same_name)) {
      throw UsageError(
          fmt::format("--structure {}: another model is named {}, and each would be written to {}.json; "
                      "give it another `name`",
                      file, asked.name, asked.name));
    }
    structures.push_back(std::move(asked));
  }
  return structures;
}

}  // namespace

bool climbs_ladder(const ModelOptions& options) {
  const auto& families = options.families;
  if (std::find(families.begin(), families.end(), kLadder) == families.end()) return false;
  if (families.size() == 1 && options.structure_files.empty()) return true;
  throw UsageError("--model ladder fits every structure of the ladder: leave out the other structures");
}

std::vector<std::string> model_names() {
  std::vector<std::string> names;
  for (const ident::InputMapKind& kind : ident::input_map_kinds()) {
    for (const ident::StructureFamily& family : ident::structure_families()) {
      const bool takes_map = kind.suffix.empty() || !family.make({}).grey_box;
      if (takes_map) names.push_back(std::string(family.name) + std::string(kind.suffix));
    }
  }
  return names;
}

void add_record_options(CLI::App& app, RecordOptions& record) {
  app.add_option("--decimate", record.decimation, "Compare every Nth sample, filtered (default 1, or the experiment's)")
      ->type_name("N")
      ->check(CLI::Range(1, 1000000).description(""));
  app.add_option("--discard", record.discard_s, "Do not compare the first SECONDS (default 0, or the experiment's)")
      ->type_name("SECONDS")
      ->check(finite_number("seconds >= 0", [](double s) { return s >= 0.0; }));
  add_intersample_option(app, record.intersample);
}

void add_intersample_option(CLI::App& app, std::optional<ident::Intersample>& intersample) {
  add_choice(
      app, "--intersample", intersample, kIntersample,
      "The input of a file between its rows: zoh, held as a controller's output; foh, in straight lines as a "
      "signal that was sampled (default: as a given model was estimated, else zoh; `eha fit`: as the record shows "
      "clearly)");
}

std::string intersample_words(const std::optional<ident::Intersample>& given) {
  if (!given) return {};
  const auto at = std::find_if(kIntersample.begin(), kIntersample.end(),
                               [&](const auto& choice) { return choice.value == *given; });
  return fmt::format(" --intersample {}", at->name);
}

std::vector<StructureOptions> structures_for(const ModelOptions& options,
                                             const std::vector<StructureOptions>& configured) {
  std::vector<StructureOptions> structures = chosen(options, configured);
  if (structures.empty()) return structures;
  apply_degrees(options, structures);
  for (StructureOptions& asked : structures) {
    if (options.delay) apply_delay(*options.delay, asked.structure.delay);
    if (options.input_map) apply_input_map(*options.input_map, asked);
    asked.initial_state = options.initial_state.value_or(asked.initial_state);
    apply_parameters(options, asked);
  }
  return structures;
}

ident::LadderOptions ladder_for(const ModelOptions& options) {
  StructureOptions common;
  apply_parameters(options, common);
  ident::LadderOptions ladder;
  ladder.parameters = std::move(common.parameters);
  ladder.initial_state = options.initial_state.value_or(ladder.initial_state);
  ladder.io = with_options(ladder.io, options);
  if (options.delay) {
    ladder.delay = ident::Structure().delay;
    apply_delay(*options.delay, *ladder.delay);
  }
  if (options.input_map) ladder.input_map = &input_map_kind(*options.input_map);
  return ladder;
}

ident::FitOptions with(ident::FitOptions options, const RecordOptions& record, int parts) {
  options.decimation = parts * record.decimation.value_or(options.decimation);
  options.discard_s = record.discard_s.value_or(options.discard_s);
  options.split = record.split.value_or(options.split);
  if (record.input_before) options.input_before = record.input_before;
  return options;
}

bool names_models(const ModelOptions& options) { return !options.families.empty() || !options.structure_files.empty(); }

}  // namespace eha::cli
