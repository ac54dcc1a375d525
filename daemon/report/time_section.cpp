// SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <span>
#include <utility>

#include "core/capitalised.hpp"
#include "core/display_unit.hpp"
#include "core/time_text.hpp"
#include "daemon/record/manifest.hpp"
#include "daemon/report/advice.hpp"
#include "daemon/report/figures.hpp"
#include "daemon/report/next_text.hpp"
#include "daemon/report/section.hpp"
#include "ident/model/parameter_text.hpp"
#include "ident/validation/verdict.hpp"

namespace eha::report {
namespace {

using Json = nlohmann::ordered_json;

constexpr double kMuchLarger = 1.5;          // error of the validation part over that of the other one
constexpr double kNotCentred = 0.7;          // mean error of the validation part over its RMS value
constexpr double kNegligible_percent = 2.0;  // largest error, of the measured range
constexpr double kNearLimit = 0.1;           // of the measured range: a travel limit so near is drawn

/// Error of one model, split at the end of its estimating part.
struct Errors {
  double rms_estimating = 0.0;
  double rms_unseen = 0.0;
  double mean_unseen = 0.0;
  // Absolute, where it was estimated and on the unseen part.
  double largest[2] = {0.0, 0.0};
  double largest_at_s[2] = {0.0, 0.0};
};

Errors errors_of(const identify::FitTable& table, const identify::FitColumn& column, std::size_t estimating) {
  Errors errors;
  double squares[2] = {0.0, 0.0};
  std::size_t counts[2] = {0, 0};
  double sum = 0.0;
  for (std::size_t i = 0; i < table.time_s.size(); ++i) {
    const double error = table.measured[i] - column.simulated[i];
    if (!std::isfinite(error)) continue;
    const std::size_t part = i < estimating ? 0 : 1;
    squares[part] += error * error;
    ++counts[part];
    if (part == 1) sum += error;
    if (std::abs(error) > errors.largest[part]) {
      errors.largest[part] = std::abs(error);
      errors.largest_at_s[part] = table.time_s[i];
    }
  }
  const auto root_mean = [&](std::size_t part) {
    return counts[part] == 0 ? 0.0 : std::sqrt(squares[part] / static_cast<double>(counts[part]));
  };
  errors.rms_estimating = root_mean(0);
  errors.rms_unseen = root_mean(1);
  if (counts[1] > 0) errors.mean_unseen = sum / static_cast<double>(counts[1]);
  return errors;
}

/// "is larger on the unseen part and follows the input"; empty for a noise-like error.
std::string systematic_text(const ident::Model& model, bool grows) {
  using Kind = ident::CriterionKind;
  const auto fails = [&](Kind kind) { return model.verdict && fails_any(*model.verdict, {kind}); };
  std::vector<std::string> found;
  if (grows) found.emplace_back("is larger on the unseen part");
  if (fails(Kind::error_over_noise)) found.emplace_back("is far above the noise of the record");
  if (fails(Kind::residual_input)) found.emplace_back("follows the input");
  if (fails(Kind::nonlinearity)) found.emplace_back("depends on motion or level");
  return fmt::format("{}", fmt::join(found, " and "));
}

Remark remark_on(const Subject& subject, const ident::Model& model, const identify::FitColumn& column,
                 std::size_t estimating) {
  const identify::FitTable& table = subject.fit;
  const Errors errors = errors_of(table, column, estimating);
  const auto [least, greatest] = std::minmax_element(table.measured.begin(), table.measured.end());
  const double range = *greatest - *least;
  const double percent = range > 0.0 ? 100.0 * std::max(errors.largest[0], errors.largest[1]) / range : 0.0;
  const bool has_unseen = estimating < table.time_s.size();
  const auto error = [&](double value) { return ident::error_text(value, model.output_unit); };
  Remark remark;
  const auto largest = [&](int part) {
    return fmt::format("{} at {:.4g} s", error(errors.largest[part]), errors.largest_at_s[part]);
  };
  // The box gives the error of the unseen part.
  remark.seen = has_unseen ? fmt::format(
                                 "The largest error of {} is {} on the unseen part, and {} where it was estimated; the "
                                 "greater is {} % of "
                                 "the measured range.",
                                 model.name, largest(1), largest(0), ident::figure_text(percent))
                           : fmt::format("The largest error of {} is {}, {} % of the measured range.", model.name,
                                         largest(0), ident::figure_text(percent));
  if (has_unseen) {
    remark.seen += fmt::format(" Its RMS error is {} where it was estimated and {} on the unseen part.",
                               error(errors.rms_estimating), error(errors.rms_unseen));
  }
  remark.good =
      "The model's line covers the measured one. The error has the same size on both sides of the dashed line, no "
      "slope, and no oscillation at the input's frequencies.";
  const bool drifts = has_unseen && std::abs(errors.mean_unseen) > kNotCentred * errors.rms_unseen;
  const bool grows = has_unseen && errors.rms_unseen > kMuchLarger * errors.rms_estimating;
  if (percent < kNegligible_percent) {
    const std::string systematic = systematic_text(model, grows);
    const std::string beside_verdict =
        "The error is small beside the motion; the box above says why the model is not accepted all the same.";
    remark.to_do =
        model.verdict && !model.verdict->accepted ? beside_verdict
        : drifts ? "The error of the unseen part is small but keeps one sign: to predict over longer times than this "
                   "record, record longer."
        : systematic.empty()
            ? "Nothing."
            : fmt::format(
                  "The error is small but not as good as it can be: it {}. Nothing, where {} (rms) does "
                  "not matter; else see the notes in the box above.",
                  systematic, error(has_unseen ? errors.rms_unseen : errors.rms_estimating));
  } else if (const std::string known = against_error(model); !known.empty()) {
    remark.to_do = known;
  } else if (const std::string box = named_in_box(model); !box.empty()) {
    remark.to_do = "The error is large: " + box;
  } else if (drifts) {
    remark.to_do = fmt::format(
        "The error of the unseen part keeps one sign (mean {}), of a cause that no test shows: record longer or "
        "with slower tones.",
        error(errors.mean_unseen));
  } else if (grows) {
    remark.to_do =
        "The error is larger on unseen data, of a cause that no test shows: record longer, or use fewer parameters.";
  } else {
    remark.to_do = "The error is large, of a cause that no test shows: look at the record where it is largest.";
  }
  return remark;
}

}  // namespace

void name_left_out(const Subject& subject, plot::Figure& figure) {
  constexpr double kWorthAWord = 0.05;                              // of the time that is drawn
  if (subject.is_of_files() || subject.fit.time_s.empty()) return;  // the clock of a file may begin anywhere
  const double first_s = subject.fit.time_s.front();
  if (!(first_s > kWorthAWord * (subject.fit.time_s.back() - first_s))) return;
  figure.panels.back().x_label += fmt::format(", the first {:.3g} s left out", first_s);
}

void draw_limits(const Subject& subject, std::pair<double, double> span_s, std::span<const double> measured,
                 const std::string& unit, plot::Panel& output) {
  if (measured.empty()) return;
  const auto [least, greatest] = std::minmax_element(measured.begin(), measured.end());
  const double near = kNearLimit * (*greatest - *least);
  for (const char* key : {"travel_min_in", "travel_max_in"}) {
    const Json& limit_in = subject.part("rig", "limits", key);
    if (!limit_in.is_number()) continue;
    const double limit = DisplayUnit(unit).factor("in") * limit_in.get<double>();
    if (limit < *least - near || limit > *greatest + near) continue;
    output.series.push_back({.label = fmt::format("travel limit, {:.4g} {}", limit, unit),
                             .x = {span_s.first, span_s.second},
                             .y = {limit, limit},
                             .style = plot::kGuideStyle});
  }
}

namespace {

/// From the first row to the last. @param table  with rows
std::pair<double, double> span_of(const identify::FitTable& table) {
  return {table.time_s.front(), table.time_s.back()};
}

Item of_record(const Subject& subject) {
  Item item{.heading = "What was recorded"};
  const ident::Record& record = *subject.record;
  if (subject.track.time_s.empty()) {
    item.figure = record_figure(record, "Input and output of " + subject.name);
    const double last = static_cast<double>(record.output.size() - 1);
    draw_limits(subject, {record.start_s, record.start_s + last * record.step_s},
                {record.output.data(), static_cast<std::size_t>(record.output.size())}, record.output_channel.unit,
                item.figure->panels.front());
  } else {
    item.heading = "Rod, reference and command until the trial ended";
    item.figure = ended_trial_figure(subject.track, item.heading + ", " + subject.name);
    draw_limits(subject, span_of(subject.track), subject.track.measured, subject.track.output.unit,
                item.figure->panels.front());
  }
  if (const auto trip_s = subject.trip_s()) mark_trip(*item.figure, *trip_s);
  const double range = record.output.maxCoeff() - record.output.minCoeff();
  item.remark.seen = fmt::format("{} rows over {:.4g} s; the output moves over {:.3g} {}, the input over {:.3g} {}.",
                                 record.output.size(), static_cast<double>(record.output.size()) * record.step_s, range,
                                 record.output_channel.unit, record.input.maxCoeff() - record.input.minCoeff(),
                                 record.input_channel.unit);
  if (subject.is_constant()) {
    item.remark = {};  // the box says what there is to say
    return item;
  }
  item.remark.good = "The output moves through a large part of its travel and touches neither end.";
  const Json& outcome = subject.part("outcome");
  item.remark.to_do =
      subject.part("experiment", "track").is_string()
          ? capitalised(has_tripped(subject) ? first_after_trial(subject) : "play it again with `eha track`") + "."
      : outcome.is_string() && record::is_whole(outcome.get<std::string>())
          ? fmt::format("Fit it: `eha fit {}`.", folder_word(subject))
      : has_tripped(subject) ? capitalised(against_end(subject) + "; then record again") + "."
                             : "Record again, to the end.";
  return item;
}

/// Says which part of a run that tripped is drawn as it was fitted, and which as it was read; empty where nothing lies
/// beyond the fit.
std::string which_rows(const identify::FitTable& table, const ident::Record& record) {
  const double end_s = record.start_s + static_cast<double>(record.output.size() - 1) * record.step_s;
  if (!(end_s > table.time_s.back())) return {};
  const std::size_t rows = table.time_s.size();
  const bool is_filtered = rows > 1 && table.time_s[1] - table.time_s[0] > 1.5 * record.step_s;
  return fmt::format(
      " To {} s the curves show the rows of the fit{}; from there to the trip each reading and command by itself, with "
      "all its noise.",
      time_text(table.time_s.back()),
      is_filtered ? fmt::format(", filtered and one every {:.4g} ms, which hides the noise of a single reading",
                                1e3 * (table.time_s[1] - table.time_s[0]))
                  : "");
}

}  // namespace

Section time_section(const Subject& subject) {
  Section section{.title = "Over time"};
  if (subject.fit.time_s.empty()) {
    if (subject.record && subject.record->output.size() > 0) section.items.push_back(of_record(subject));
    return section;
  }
  std::vector<std::string> names;
  const ident::Model* first = nullptr;
  for (const ReportedModel* reported : subject.pictured()) {
    if (subject.fit.find(reported->model.name) == nullptr) continue;
    if (first == nullptr) first = &reported->model;
    names.push_back(reported->model.name);
  }
  if (first == nullptr) return section;
  const std::size_t estimating =
      first->estimation ? std::min(first->estimation->score.samples, subject.fit.time_s.size()) : 0;
  const std::optional<double> split_s = subject.split_s();
  Item item{.heading = split_s ? "Measured, models and errors; right of the dashed line nothing was estimated"
                               : "Measured, models and errors"};
  item.figure = fit_figure(subject.fit, names, split_s, "Measured and simulated output over time");
  draw_limits(subject, span_of(subject.fit), subject.fit.measured, subject.fit.output.unit,
              item.figure->panels.front());
  name_left_out(subject, *item.figure);
  if (subject.trip_s() && subject.record) add_rest(*item.figure, subject.fit, *subject.record);
  if (const auto trip_s = subject.trip_s()) mark_trip(*item.figure, *trip_s);
  item.remark = remark_on(subject, *first, *subject.fit.find(first->name), estimating);
  if (subject.trip_s() && subject.record) item.remark.seen += which_rows(subject.fit, *subject.record);
  section.items.push_back(std::move(item));
  return section;
}

}  // namespace eha::report
