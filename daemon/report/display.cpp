// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/report/display.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "ident/model/output_unit.hpp"

namespace eha::report {
namespace {

ident::Model shown(ident::Model model, const DisplayUnit& unit) {
  const std::string name = unit.of(model.output_unit);
  if (name == model.output_unit) return model;
  const double factor = unit.factor(model.output_unit);
  return ident::in_output_unit(std::move(model), name, factor);
}

void rescale(identify::FitTable& table, const DisplayUnit& unit) {
  const double factor = unit.factor(table.output.unit);
  for (double& y : table.measured) y *= factor;
  for (identify::FitColumn& model : table.models) {
    for (double& y : model.simulated) y *= factor;
  }
  table.output.unit = unit.of(table.output.unit);
}

/// Columns of frequency_response.csv: gains as ratios and in dB. Noise and distortion are relative to the output.
void rescale_response(record::NumberTable& table, double factor) {
  for (std::size_t i = 0; i < table.names.size(); ++i) {
    const std::string& name = table.names[i];
    if (name == "gain" || name == "std") {
      for (double& value : table.columns[i]) value *= factor;
    } else if (name.ends_with("gain_dB")) {
      for (double& value : table.columns[i]) value += 20.0 * std::log10(factor);
    }
  }
}

}  // namespace

Subject in_unit(Subject subject, const DisplayUnit& unit) {
  const std::string* output = !subject.models.empty() ? &subject.models.front().model.output_unit
                              : subject.record        ? &subject.record->output_channel.unit
                                                      : nullptr;
  if (subject.response && output != nullptr) rescale_response(*subject.response, unit.factor(*output));
  for (ReportedModel& reported : subject.models) reported.model = shown(std::move(reported.model), unit);
  for (ident::Model& model : subject.paper) model = shown(std::move(model), unit);
  rescale(subject.fit, unit);
  rescale(subject.paper_fit, unit);
  if (subject.record) {
    subject.record->output *= unit.factor(subject.record->output_channel.unit);
    subject.record->output_channel.unit = unit.of(subject.record->output_channel.unit);
  }
  return subject;
}

}  // namespace eha::report
