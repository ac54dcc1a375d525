// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/report/display.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "ident/validation/output_unit.hpp"

namespace eha::report {
namespace {

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
  for (ReportedModel& reported : subject.models) {
    ident::Model shown = in_unit(reported.model, unit);
    subject.reason = requoted(std::move(subject.reason), reported.model, shown);
    reported.model = std::move(shown);
  }
  for (ident::Model& model : subject.paper) model = in_unit(std::move(model), unit);
  subject.unit = unit;
  rescale(subject.fit, unit);
  rescale(subject.paper_fit, unit);
  rescale(subject.track, unit);
  if (subject.record) {
    subject.record->output *= unit.factor(subject.record->output_channel.unit);
    subject.record->output_channel.unit = unit.of(subject.record->output_channel.unit);
  }
  return subject;
}

}  // namespace eha::report
