// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/eha/model_options.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>

#include "core/error.hpp"

namespace eha::cli {
namespace {

using ident::ParameterRequest;
using ident::StructureKind;
using ident::StructureOptions;

std::string_view name_of(StructureKind kind) {
  switch (kind) {
    case StructureKind::io:
      return "io";
    case StructureKind::fo:
      return "fo";
    case StructureKind::commensurate:
      return "commensurate";
    case StructureKind::lag:
      return "lag";
  }
  return "";
}

StructureOptions plain(StructureKind kind) {
  StructureOptions structure;
  structure.name = name_of(kind);
  structure.kind = kind;
  return structure;
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

bool has_degrees(const StructureOptions& structure) {
  return structure.kind == StructureKind::io || structure.kind == StructureKind::commensurate;
}

void apply_degrees(const ModelOptions& options, std::vector<StructureOptions>& structures) {
  if (!options.poles && !options.zeros) return;
  if (std::none_of(structures.begin(), structures.end(), has_degrees)) {
    throw UsageError("--poles and --zeros are for the models io and commensurate, and none of these is asked for");
  }
  for (StructureOptions& structure : structures) {
    if (!has_degrees(structure)) continue;
    structure.poles = options.poles.value_or(structure.poles);
    structure.zeros = options.zeros.value_or(structure.zeros);
    if (structure.zeros > structure.poles) {
      throw UsageError(fmt::format("--zeros: expected at most {} as there are so many poles, got {}", structure.poles,
                                   structure.zeros));
    }
  }
}

void apply_delay(const std::string& text, StructureOptions& structure) {
  structure.delay_free = text == "free";
  if (structure.delay_free) return;
  structure.delay_s = number(text, "--delay", text);
  if (structure.delay_s < 0.0) throw UsageError(fmt::format("--delay: expected free or seconds >= 0, got {}", text));
}

std::vector<StructureOptions> chosen(const ModelOptions& options, const std::vector<StructureOptions>& configured) {
  if (options.kinds.empty()) {
    if (!configured.empty()) return configured;
    return {plain(StructureKind::io), plain(StructureKind::fo)};
  }
  std::vector<StructureOptions> structures;
  for (auto kind = options.kinds.begin(); kind != options.kinds.end(); ++kind) {
    if (std::find(options.kinds.begin(), kind, *kind) != kind) {
      throw UsageError(fmt::format("--model {} is given twice, and each would be written to {}.json", name_of(*kind),
                                   name_of(*kind)));
    }
    const std::size_t before = structures.size();
    std::copy_if(configured.begin(), configured.end(), std::back_inserter(structures),
                 [&](const StructureOptions& structure) { return structure.kind == *kind; });
    if (structures.size() == before) structures.push_back(plain(*kind));
  }
  return structures;
}

}  // namespace

std::vector<StructureOptions> structures_for(const ModelOptions& options,
                                             const std::vector<StructureOptions>& configured) {
  std::vector<StructureOptions> structures = chosen(options, configured);
  apply_degrees(options, structures);
  for (StructureOptions& structure : structures) {
    if (options.delay) apply_delay(*options.delay, structure);
    structure.initial_state = options.initial_state.value_or(structure.initial_state);
    apply_parameters(options, structure);
  }
  return structures;
}

ident::FitOptions with(ident::FitOptions options, const RecordOptions& record) {
  options.decimation = record.decimation.value_or(options.decimation);
  options.discard_s = record.discard_s.value_or(options.discard_s);
  options.split = record.split.value_or(options.split);
  return options;
}

}  // namespace eha::cli
