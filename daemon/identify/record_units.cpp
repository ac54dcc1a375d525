// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/identify/record_units.hpp"

#include <fmt/format.h>

#include <optional>
#include <utility>

#include "core/display_unit.hpp"
#include "core/error.hpp"
#include "ident/validation/input_unit.hpp"
#include "ident/validation/output_unit.hpp"

namespace eha::identify {
namespace {

/// Units of the second in one of the first; an unknown (empty) one counts as the other. None: they cannot be converted.
std::optional<double> factor_between(const std::string& from, const std::string& to) {
  return from.empty() || to.empty() ? std::optional(1.0) : unit_factor(from, to);
}

/// The model from one unit to another; none where it cannot be converted.
std::optional<ident::Model> converted(ident::Model model, const std::string& input, const std::string& output) {
  const std::optional<double> of_input = factor_between(model.input_unit, input);
  const std::optional<double> of_output = factor_between(model.output_unit, output);
  if (!of_input || !of_output) return std::nullopt;
  if (!input.empty() && !model.input_unit.empty() && model.input_unit != input) {
    model = ident::in_input_unit(std::move(model), input, *of_input);
  }
  if (!output.empty() && !model.output_unit.empty() && model.output_unit != output) {
    model = ident::in_output_unit(std::move(model), output, *of_output);
  }
  return model;
}

constexpr const char* kExpected =
    "expected the same units, or such as can be converted: lengths, volts and mV, A and mA";

}  // namespace

ident::Model in_units_of(const Source& source, ident::Model model, const std::string& name) {
  const std::string& input = source.record.input_channel.unit;
  const std::string& output = source.record.output_channel.unit;
  const std::string of_model = fmt::format("{} to {}", model.input_unit, model.output_unit);
  if (auto same = converted(std::move(model), input, output)) return *std::move(same);
  throw DataError(fmt::format("{} is a model from {}, and {} is a record in {} and {}; {}", name, of_model, source.name,
                              input, output, kExpected));
}

std::string unit_taken_as_same(const Source& source, const ident::Model& model) {
  const auto told = [&](const char* what, const std::string& of_model, const std::string& of_record) {
    if (of_model.empty() == of_record.empty()) return std::string();
    const bool lacks_model = of_model.empty();
    return fmt::format(
        "the {0} of {1} has no unit, and that of {2} is in {3}: they are taken to be the same; if not, {4} "
        "--{0}-unit",
        what, lacks_model ? model.name : source.name, lacks_model ? source.name : model.name,
        lacks_model ? of_record : of_model, lacks_model ? "fit its record again with" : "say so with");
  };
  std::string input = told("input", model.input_unit, source.record.input_channel.unit);
  const std::string output = told("output", model.output_unit, source.record.output_channel.unit);
  return input.empty() || output.empty() ? input + output : input + "; " + output;
}

std::vector<ident::Model> in_units_of_first(std::vector<ident::Model> models, const std::vector<std::string>& names) {
  for (std::size_t i = 1; i < models.size(); ++i) {
    const std::string& input = models.front().input_unit;
    const std::string& output = models.front().output_unit;
    const std::string of_model = fmt::format("{} to {}", models[i].input_unit, models[i].output_unit);
    auto same = converted(std::move(models[i]), input, output);
    if (!same) {
      throw DataError(fmt::format("{} is a model from {} to {}, and {} one from {}; {}", names.front(), input, output,
                                  names[i], of_model, kExpected));
    }
    models[i] = *std::move(same);
  }
  return models;
}

std::vector<Source> in_units_of_first(std::vector<Source> sources) {
  const ident::Channel input = sources.front().record.input_channel;
  const ident::Channel output = sources.front().record.output_channel;
  for (Source& source : sources) {
    ident::Record& record = source.record;
    const auto of_input = unit_factor(record.input_channel.unit, input.unit);
    const auto of_output = unit_factor(record.output_channel.unit, output.unit);
    if (!of_input || !of_output) {
      throw DataError(fmt::format("{} is in {} and {}, {} in {} and {}; {}", source.name, record.input_channel.unit,
                                  record.output_channel.unit, sources.front().name, input.unit, output.unit,
                                  kExpected));
    }
    record.input *= *of_input;
    record.output *= *of_output;
    record.input_channel.unit = input.unit;
    record.output_channel.unit = output.unit;
  }
  return sources;
}

}  // namespace eha::identify
