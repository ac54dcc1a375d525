// SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include "daemon/report/advice.hpp"
#include "daemon/report/figures.hpp"
#include "daemon/report/html.hpp"
#include "daemon/report/section.hpp"
#include "ident/model/parameter_text.hpp"

namespace eha::report {
namespace {

constexpr double kClose_dB = 1.0;
constexpr double kClose_deg = 7.0;
constexpr double kMuchDistortion_dB = -30.0;

/// Greatest deviations of a model from the measured lines.
struct Distance {
  std::size_t lines = 0;
  double lowest_Hz = 0.0;
  double highest_Hz = 0.0;
  double gain_dB = 0.0;
  double phase_deg = 0.0;
  std::size_t missed = 0;  ///< lines whose 95 % bar of the gain error does not hold 0
  std::size_t lines_in_band = 0;
  double gain_in_band_dB = 0.0;  ///< of the lines in the usable band
  double phase_in_band_deg = 0.0;
};

using Band = std::optional<ident::FrequencyInterval>;

/// Adds a line and how far off it the model is.
void add_line(double frequency_Hz, double gain_dB, double phase_deg, const Band& band, Distance& distance) {
  distance.gain_dB = std::max(distance.gain_dB, std::abs(gain_dB));
  distance.phase_deg = std::max(distance.phase_deg, std::abs(phase_deg));
  if (!band || frequency_Hz < band->lowest_Hz || frequency_Hz > band->highest_Hz) return;
  ++distance.lines_in_band;
  distance.gain_in_band_dB = std::max(distance.gain_in_band_dB, std::abs(gain_dB));
  distance.phase_in_band_deg = std::max(distance.phase_in_band_deg, std::abs(phase_deg));
}

/// Whether the bar of a line, as gain_error_panel() draws it, does not hold 0.
bool misses_0(const record::NumberTable& response, std::size_t line, double error_dB) {
  const auto* level = response.find("gain");
  const auto* deviation = response.find("std");
  if (level == nullptr || deviation == nullptr || !std::isfinite((*deviation)[line])) return false;
  const double relative = std::min(0.9, ident::kInterval95 * (*deviation)[line] / (*level)[line]);
  return error_dB + 20.0 * std::log10(1.0 - relative) > 0.0 || error_dB + 20.0 * std::log10(1.0 + relative) < 0.0;
}

Distance distance_of(const record::NumberTable& response, const std::string& model, const Band& band) {
  Distance distance;
  const auto* f = response.find("frequency_Hz");
  const auto* gain = response.find("gain_dB");
  const auto* phase = response.find("phase_deg");
  const auto* model_gain = response.find(model + "_gain_dB");
  const auto* model_phase = response.find(model + "_phase_deg");
  if (f == nullptr || gain == nullptr || phase == nullptr || model_gain == nullptr || model_phase == nullptr) return {};
  for (std::size_t i = 0; i < f->size(); ++i) {
    const double error_dB = (*gain)[i] - (*model_gain)[i];
    if (misses_0(response, i, error_dB)) ++distance.missed;
    add_line((*f)[i], error_dB, (*phase)[i] - (*model_phase)[i], band, distance);
  }
  distance.lines = f->size();
  if (!f->empty()) {
    distance.lowest_Hz = f->front();
    distance.highest_Hz = f->back();
  }
  return distance;
}

/// The same with the model's valve map, where shows_map().
Distance distance_with_map(const record::NumberTable& response, const ident::Model& model,
                           const identify::FitTable& fit, const Band& band) {
  const ident::BodeCurve curve = curve_at_lines(model, response, &fit);
  const std::vector<double>& gain = *response.find("gain_dB");
  const std::vector<double>& phase = *response.find("phase_deg");
  Distance distance{
      .lines = gain.size(), .lowest_Hz = curve.frequency_Hz.front(), .highest_Hz = curve.frequency_Hz.back()};
  for (std::size_t i = 0; i < gain.size(); ++i) {
    if (misses_0(response, i, gain[i] - curve.gain_dB[i])) ++distance.missed;
    add_line(curve.frequency_Hz[i], gain[i] - curve.gain_dB[i], std::remainder(phase[i] - curve.phase_deg[i], 360.0),
             band, distance);
  }
  return distance;
}

/// Returns the greatest distortion at or beside the lines, relative to the output there; none if it was not measured.
std::optional<double> greatest_distortion_dB(const record::NumberTable& response) {
  std::optional<double> greatest;
  for (const char* name : {"even_distortion_dB", "odd_distortion_dB", "distortion_dB"}) {
    const auto* column = response.find(name);
    if (column == nullptr) continue;
    for (const double value : *column) {
      if (std::isfinite(value) && (!greatest || value > *greatest)) greatest = value;
    }
  }
  return greatest;
}

/// Returns the median of a column's values; none without any.
std::optional<double> median(const record::NumberTable& response, const char* name) {
  const auto* column = response.find(name);
  if (column == nullptr) return std::nullopt;
  std::vector<double> values;
  for (const double value : *column) {
    if (std::isfinite(value)) values.push_back(value);
  }
  if (values.empty()) return std::nullopt;
  std::sort(values.begin(), values.end());
  return values[values.size() / 2];
}

/// Describes noise and distortion at the lines of several realisations; "" for one.
std::string median_sentence(const record::NumberTable& response) {
  const std::optional<double> distortion = median(response, "distortion_dB");
  const std::optional<double> noise = median(response, "noise_dB");
  if (!distortion || !noise) return "";
  return fmt::format(
      " At the median line the distortion is {:.0f} dB and the noise {:.0f} dB, by the spread of the realisations and "
      "of their periods.",
      *distortion, *noise);
}

Remark without_response(const ReportedModel& reported) {
  return {
      .seen = fmt::format(
          "There is no measured response to compare {} with: the record has no excited lines that are known to repeat.",
          reported.model.name),
      .good = "The bounds are narrow, and the measured response lies within them.",
      .to_do =
          "For a measured response excite with a multisine of whole periods, at least two of them after the discarded "
          "time."};
}

/// What to do where model and measurement differ, seen at `where`.
std::string against_difference(const ident::Model& model, const std::string& where, double gain_dB) {
  const std::string box = named_in_box(model);
  return fmt::format(
      "The model misses a part of the plant at the frequencies where {} differ: {}", where,
      !box.empty() ? box
                   : fmt::format("use it where an error of {} dB does not matter there.", ident::figure_text(gain_dB)));
}

Remark remark_on(const Subject& subject, const ReportedModel& reported, const record::NumberTable* response) {
  const bool has_map = shows_map(reported.model, response, &subject.fit);
  const Band band = reported.usable_band();
  const Distance distance = has_map               ? distance_with_map(*response, reported.model, subject.fit, band)
                            : response != nullptr ? distance_of(*response, reported.model.name, band)
                                                  : Distance{};
  if (distance.lines == 0) return without_response(reported);
  const std::optional<double> distortion = greatest_distortion_dB(*response);
  Remark remark;
  remark.seen = fmt::format("At the {}, {} is within {} dB and {} deg of the measured response.",
                            distance.lines == 1 ? fmt::format("measured frequency {:.3g} Hz", distance.lowest_Hz)
                                                : fmt::format("{} measured frequencies from {:.3g} to {:.3g} Hz",
                                                              distance.lines, distance.lowest_Hz, distance.highest_Hz),
                            reported.model.name + (has_map ? " with its map" : ""),
                            ident::figure_text(distance.gain_dB), ident::figure_text(distance.phase_deg));
  if (distance.lines_in_band > 0 && distance.lines_in_band < distance.lines) {
    remark.seen +=
        fmt::format(" Within the usable band it is within {} dB and {} deg.",
                    ident::figure_text(distance.gain_in_band_dB), ident::figure_text(distance.phase_in_band_deg));
  }
  remark.seen += distortion ? fmt::format(" The distortion is at most {:.0f} dB relative to the output.", *distortion)
                            : " Distortion was not measured; an odd_random_multisine would.";
  remark.seen += median_sentence(*response);
  remark.good =
      "The bars of the gain error reach 0. The line passes through the points, noise and distortion lie at least 30 dB "
      "below the gain. Outside the measured "
      "frequencies the model extrapolates.";
  const std::string grey =
      reported.usable_band()
          ? " The shaded frequencies are the usable band, where the grey band about the line shows the 95 % bounds: "
            "beyond, the record does not test the structure."
          : " The grey band shows the 95 % bounds.";
  remark.good += grey;
  const bool is_close = distance.gain_dB < kClose_dB && distance.phase_deg < kClose_deg;
  if (distance.missed > 0) {
    remark.seen += fmt::format(" The bars of {} of the {} lines do not hold 0: more than noise is left there.",
                               distance.missed, distance.lines);
  }
  const std::string nothing =
      distance.missed == 0
          ? "Nothing."
          : fmt::format(
                "Use the model where an error of {} dB does not matter: what is left is small, but the "
                "model's, not noise.",
                ident::figure_text(distance.gain_dB));
  if (has_map) {
    remark.seen +=
        " The line is the linear part above the dead band, which no record shows alone; the crosses are the same model "
        "behind its map, linearised for this record's input.";
    remark.good =
        "The bars of the gain error reach 0, and the crosses lie on the measured points: below the line, as the dead "
        "band takes its share of the amplitude. Outside the measured frequencies the model extrapolates." +
        grey;
    remark.to_do = is_close ? nothing + " For commands of another amplitude the crosses move; the line does not."
                            : against_difference(reported.model, "crosses and points", distance.gain_dB);
  } else if (reported.model.input_map) {
    remark.good =
        "Bars of the gain error on a level line below 0: the dead band takes that share of the amplitude." + grey;
    remark.seen += " The line shows the linear part above the dead band; the valve map lowers the measured gain.";
    remark.to_do =
        "Judge this model by the plot over time: with a dead band no transfer function alone passes through the bars.";
  } else if (distortion && *distortion > kMuchDistortion_dB) {
    const std::string box = named_in_box(reported.model);
    remark.to_do = "The plant is not linear at this amplitude: " +
                   (box.empty() ? "use this model at the recorded amplitudes." : box);
  } else {
    remark.to_do = is_close ? nothing + " To learn the response at other frequencies, excite them."
                            : against_difference(reported.model, "line and bars", distance.gain_dB);
  }
  return remark;
}

}  // namespace

Section frequency_section(const Subject& subject) {
  Section section{.title = "Frequency response"};
  if (subject.models.empty()) return section;
  const std::vector<const ReportedModel*> shown = subject.pictured();
  const record::NumberTable* response = subject.response ? &*subject.response : nullptr;
  Item item{.heading = response != nullptr ? "Gain and phase of the models over the measured response"
                                           : "Gain and phase of the models"};
  item.figure =
      bode_figure(shown, response,
                  response != nullptr ? "Bode plot of the models and the measured response" : "Bode plot of the models",
                  &subject.fit);
  item.remark = remark_on(subject, *shown.front(), response);
  if (const auto& notes = subject.part("identification", "frequency_response_notes"); notes.is_array()) {
    for (const auto& note : notes) item.html += paragraph("About this plot: " + note.get<std::string>() + ".");
  }
  section.items.push_back(std::move(item));
  return section;
}

}  // namespace eha::report
