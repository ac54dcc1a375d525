// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/report/comparison_page.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <span>
#include <tuple>
#include <utility>

#include "core/error.hpp"
#include "daemon/plot/envelope.hpp"
#include "daemon/report/change_causes.hpp"
#include "daemon/report/figures.hpp"
#include "daemon/report/html.hpp"
#include "ident/model/band_text.hpp"
#include "ident/model/difference_text.hpp"
#include "ident/model/parameter_text.hpp"
#include "ident/validation/verdict.hpp"

namespace eha::report {
namespace {

constexpr double kMostShown = 10.0;  // joint half widths to both sides

/// The commands of a text on one record, for the rig of that record.
std::string on_its_rig(const ComparedSubject& subject, const std::string& text) {
  return subject.rig ? suggest::completed(text, *subject.rig) : text;
}

std::string changes_table(const ComparedSubject& first, const ComparedSubject& subject) {
  const ident::Model& model = subject.model;
  std::vector<std::vector<std::string>> rows;
  for (const ident::ParameterChange& p : subject.change->parameters) {
    const ident::DifferenceText text = ident::difference_text(p.after - p.before, p.half_width);
    rows.push_back({p.name, ident::unit_of(p, model), ident::value_text(p.name, p.before, first.model, text.resolution),
                    ident::value_text(p.name, p.after, model, text.resolution), text.difference, text.half_width,
                    change_word(subject, p.changed)});
  }
  if (const identify::LeftOver& e = subject.left_over; e.before > 0.0) {
    rows.push_back({"left over, rms", model.output_unit, fmt::format("{:.3g}", e.before),
                    fmt::format("{:.3g}", e.after), fmt::format("{:.3g}", e.after - e.before),
                    fmt::format("factor {:g}", identify::kOtherLeftOver), left_over_word(subject)});
    if (subject.first_model_error > 0.0) {
      rows.push_back({"of the first model, rms", model.output_unit, fmt::format("{:.3g}", e.before),
                      fmt::format("{:.3g}", subject.first_model_error),
                      fmt::format("{:.3g}", subject.first_model_error - e.before),
                      fmt::format("factor {:g}", ident::kGreatestErrorOverRefit), first_model_word(subject)});
    }
  }
  return table({{"parameter"},
                {"unit"},
                {"before", Column::number},
                {"after", Column::number},
                {"difference", Column::number},
                {"shows from ±", Column::number},
                {"changed"}},
               rows);
}

/// Draws each difference over half its joint interval: beyond +-1 it is a change.
plot::Figure changes_figure(const ident::PlantChange& change, const std::string& title) {
  plot::Panel panel{.x_label = "", .y_label = "difference [half intervals]"};
  plot::Series bars{.label = "", .mark = plot::Mark::error_bars, .style = 1};
  double most = 2.0;
  for (const ident::ParameterChange& p : change.parameters) {
    const double x = static_cast<double>(panel.x_ticks.size()) + 1.0;
    const double size = p.half_width > 0.0 ? (p.after - p.before) / p.half_width : 0.0;
    panel.x_ticks.push_back({.at = x, .text = p.name});
    most = std::max(most, std::min(std::abs(size), kMostShown) + 1.0);
    // Outside the panel: an arrow and no bar, whose ends would be read.
    if (std::abs(size) > kMostShown) {
      panel.captions.push_back({.x = x,
                                .y = std::copysign(kMostShown, size),
                                .text = fmt::format("{} {:.0f}", size > 0.0 ? "↑" : "↓", size)});
      continue;
    }
    bars.x.push_back(x);
    bars.y.push_back(size);
    bars.lower.push_back(size - 1.0);
    bars.upper.push_back(size + 1.0);
  }
  panel.x_range = std::pair(0.5, static_cast<double>(panel.x_ticks.size()) + 0.5);
  panel.y_range = std::pair(-1.1 * most, 1.1 * most);
  panel.rules = {{.at = 0.0, .vertical = false}};
  panel.series.push_back(std::move(bars));
  return {.title = title, .panels = {std::move(panel)}};
}

Item changes_item(const ComparedSubject& first, const ComparedSubject& subject) {
  const ident::PlantChange& change = *subject.change;
  Item item{.heading = fmt::format("From {} to {}", first.label, subject.label)};
  if (subject.unfit) {
    item.html = paragraph(unfit_sentence(first, subject)) + paragraph(first_model_sentence(first, subject));
    item.remark.to_do = on_its_rig(subject, to_do_of(subject));
    return item;
  }
  item.html = changes_table(first, subject);
  if (std::any_of(change.parameters.begin(), change.parameters.end(),
                  [](const auto& p) { return p.role == ident::ParameterRole::dead_band; })) {
    item.html += paragraph(std::string(ident::kDeadBandIs) + ".");
  }
  if (change.parameters.empty()) return item;
  item.figure = changes_figure(change, "Changes of the parameters, " + item.heading);
  const auto changed = std::count_if(change.parameters.begin(), change.parameters.end(),
                                     [](const ident::ParameterChange& p) { return p.changed; });
  item.remark.seen =
      subject.cannot_tell.empty()
          ? fmt::format("{} of {} parameters changed.", changed, change.parameters.size())
          : fmt::format("{} of {} parameters differ, which is not shown to be a change of the plant: {}.", changed,
                        change.parameters.size(), subject.cannot_tell);
  const bool is_beyond = std::any_of(change.parameters.begin(), change.parameters.end(), [](const auto& p) {
    return p.half_width > 0.0 && std::abs(p.after - p.before) > kMostShown * p.half_width;
  });
  item.remark.seen +=
      " The axis counts in half joint intervals: a parameter at 3 differs three times as much as the least change that "
      "shows, at which the bar just leaves 0.";
  if (is_beyond)
    item.remark.seen += fmt::format(" A value beyond {:g} is an arrow with its number, without a bar.", kMostShown);
  item.remark.good = "Every bar reaches the dashed line at 0, as on an unchanged rig; one that does not is a change.";
  if (leaves_other(subject)) item.remark.seen += " " + left_over_sentence(first, subject);
  item.remark.to_do = on_its_rig(subject, to_do_of(subject));
  if (subject.first_model_error > 0.0) item.remark.seen += " " + first_model_sentence(first, subject);
  std::vector<std::string> not_shown;
  for (const ident::ParameterChange& p : change.parameters) {
    std::string hidden = ident::hidden_sentence(p, subject.model);
    if (hidden.empty()) continue;
    hidden.front() = 'A';
    not_shown.push_back(hidden + ".");
  }
  for (const std::string& name : change.other_unit) not_shown.push_back(ident::other_unit_sentence(name) + ".");
  for (const std::string& name : change.undetermined) {
    not_shown.push_back(name + " is not determined by both records.");
  }
  if (!not_shown.empty()) item.html += paragraph("What these records cannot show:") + list(not_shown);
  return item;
}

constexpr const char* kOnlyTheMap =
    "Nothing: only the valve's map is shown to have changed. The dynamics behind it, with their gain, are drawn as "
    "each fit has them, and their difference is within what the records can show.";

/// Whether no parameter but those of the valve's map is shown to have changed, of any of the records.
bool is_only_map_changed(const std::vector<ComparedSubject>& subjects) {
  bool has_changed = false;
  for (const ComparedSubject& subject : subjects) {
    if (subject.unfit || !subject.cannot_tell.empty()) return false;
    if (!subject.change) continue;
    // Something changed that no parameter shows.
    if (!subject.change->changed && !subject.first_model_holds) return false;
    for (const ident::ParameterChange& p : subject.change->parameters) {
      if (p.may_have_changed()) return false;
      if (!p.changed) continue;
      has_changed = true;
      if (!ident::is_of_map(p.role)) return false;
    }
  }
  return has_changed;
}

plot::Series curve_of(const Eigen::VectorXd& time_s, const Eigen::VectorXd& values, const std::string& label,
                      int style) {
  const auto all = [](const Eigen::VectorXd& v) { return std::span(v.data(), static_cast<std::size_t>(v.size())); };
  plot::Points points = plot::envelope(all(time_s), all(values));
  return {.label = label, .x = std::move(points.x), .y = std::move(points.y), .mark = plot::Mark::line, .style = style};
}

double rms(const Eigen::VectorXd& values) {
  return std::sqrt(values.squaredNorm() / static_cast<double>(std::max<Eigen::Index>(1, values.size())));
}

/// The record, each model's output over it, and its error.
Item models_on_record_item(const std::vector<ComparedSubject>& subjects) {
  const ComparedSubject& first = subjects.front();
  if (first.time_s.size() == 0) return {};
  const std::string& unit = first.model.output_unit;
  Item item{.heading = "Measured output, the models on it, and their errors"};
  plot::Panel output{.x_label = "", .y_label = axis_label({"output", unit})};
  plot::Panel error{.x_label = "time [s]", .y_label = axis_label({"error, measured - model", unit})};
  output.series.push_back(curve_of(first.time_s, first.measured, "measured", 0));
  int style = 1;
  for (const ComparedSubject& subject : subjects) {
    const Eigen::VectorXd left = subject.measured - subject.simulated;
    output.series.push_back(curve_of(subject.time_s, subject.simulated, subject.label, style));
    error.series.push_back(curve_of(subject.time_s, left, "error of " + subject.label, style));
    item.remark.seen +=
        fmt::format("RMS error of {}: {}, at most {}. ", subject.label, ident::error_text(rms(left), unit),
                    ident::error_text(left.cwiseAbs().maxCoeff(), unit));
    ++style;
  }
  item.figure = plot::Figure{.title = item.heading, .panels = {std::move(output), std::move(error)}};
  item.remark.good = "Lines that cover the measured one, and an error without slope or the input's oscillation.";
  item.remark.to_do = "An error that begins at one time has its cause there; one that grows all along is the model's.";
  return item;
}

Item records_item(const std::vector<ComparedSubject>& subjects) {
  const std::string& unit = subjects.front().model.output_unit;
  plot::Panel output{.x_label = "", .y_label = axis_label({"measured", unit})};
  plot::Panel error{.x_label = "time [s]", .y_label = axis_label({"error, measured - model", unit})};
  Item item{.heading = "Measured output, and the error of each model on its record"};
  int style = 1;
  for (const ComparedSubject& subject : subjects) {
    if (subject.time_s.size() == 0) continue;
    output.series.push_back(curve_of(subject.time_s, subject.measured, subject.label, style));
    error.series.push_back(curve_of(subject.time_s, subject.measured - subject.simulated, "", style));
    item.remark.seen += fmt::format("RMS error on {}: {:.3g}{}. ", subject.label,
                                    rms(subject.measured - subject.simulated), ident::after_number(unit));
    ++style;
  }
  if (style == 1) return {};
  plot::Panel of_first{.x_label = "time [s]", .y_label = axis_label({"error of the first model", unit})};
  style = 1;
  for (const ComparedSubject& subject : subjects) {
    const ident::OutputOfModel& other = subject.of_first_model;
    if (other.time_s.size() > 0) {
      of_first.series.push_back(curve_of(other.time_s, other.measured - other.simulated, "", style));
    }
    ++style;
  }
  item.figure = plot::Figure{.title = item.heading, .panels = {std::move(output), std::move(error)}};
  if (!of_first.series.empty()) {
    item.figure->panels[1].x_label = "";
    item.figure->panels.push_back(std::move(of_first));
    item.remark.seen +=
        fmt::format("Below: the model of {} on each other record, in that record's line.", subjects.front().label);
  }
  item.remark.good =
      "Errors of equal size: the models describe their records equally well, and the first one the others', too.";
  item.remark.to_do =
      "If one error is much larger, the cause may lie outside the model: friction, air, a loose sensor.";
  return item;
}

constexpr const char* kModelsDiffer = "Where they differ, the models differ, not the rig: all are of one plant";

/// Says which model leaves so much more than noise over that its curves lack a part of the plant; empty where none
/// does.
std::string lacks_a_part(const std::vector<ComparedSubject>& subjects) {
  constexpr double kMostLeft_percent = 1.0;  // of the output's standard deviation
  for (const ComparedSubject& subject : subjects) {
    const auto& fitted = subject.model.estimation;
    if (!fitted || !fitted->noise || 100.0 - fitted->score.fit_percent < kMostLeft_percent ||
        ident::leaves_plain_noise(subject.model)) {
      continue;
    }
    return fmt::format(
        "The model of {} leaves {} rms over, which is more than noise: a part of that plant, as a resonance, may be "
        "missing from its curve, and the bounds do not count it. `eha fit` of the record finds the structure.",
        subject.label, ident::error_text(std::sqrt(fitted->score.mse), subject.model.output_unit));
  }
  return {};
}

Item bode_item(const std::vector<ComparedSubject>& subjects, bool is_one_plant) {
  std::vector<ReportedModel> models;
  for (const ComparedSubject& subject : subjects) {
    models.push_back({subject.model, subject.label});
    models.back().model.name = subject.label;
  }
  std::vector<const ReportedModel*> shown;
  for (const ReportedModel& model : models) shown.push_back(&model);
  Item item{.heading = "Gain and phase with 95 % bounds"};
  item.figure = bode_figure(shown, nullptr, "Bode plots of what is compared");
  const auto band = shown.front()->usable_band();
  const bool has_band = band.has_value();
  item.remark.seen =
      has_band ? fmt::format("Grey: the usable band of {}, {}.", subjects.front().label, ident::frequencies_text(*band))
               : fmt::format("The usable band of {} is not known.", subjects.front().label);
  item.remark.good = "Curves that lie within one another's bounds.";
  const std::string lacks = is_one_plant ? std::string() : lacks_a_part(subjects);
  item.remark.to_do =
      !lacks.empty() ? lacks
      : is_only_map_changed(subjects)
          ? std::string(kOnlyTheMap)
          : fmt::format("{}{}.",
                        is_one_plant ? kModelsDiffer : "Where they differ, the plants differ at that frequency",
                        has_band ? "; outside the usable band trust neither" : "");
  return item;
}

/// Least and greatest input of all records.
std::optional<std::pair<double, double>> input_range(const std::vector<ComparedSubject>& subjects) {
  std::optional<std::pair<double, double>> range;
  for (const ComparedSubject& subject : subjects) {
    if (!subject.input_range) continue;
    if (!range) range = subject.input_range;
    range->first = std::min(range->first, subject.input_range->first);
    range->second = std::max(range->second, subject.input_range->second);
  }
  return range;
}

/// Those whose model describes its record.
std::vector<ComparedSubject> fitting(const std::vector<ComparedSubject>& subjects) {
  const bool first_fits = std::none_of(subjects.begin(), subjects.end(),
                                       [](const auto& subject) { return subject.unfit && subject.unfit->is_first; });
  std::vector<ComparedSubject> kept;
  for (const ComparedSubject& subject : subjects) {
    const bool fits = &subject == &subjects.front() ? first_fits : !subject.unfit || subject.unfit->is_first;
    if (fits) kept.push_back(subject);
  }
  return kept;
}

std::vector<ident::Model> labelled(const std::vector<ComparedSubject>& subjects) {
  std::vector<ident::Model> models;
  for (const ComparedSubject& subject : subjects) {
    models.push_back(subject.model);
    models.back().name = subject.label;
  }
  return models;
}

/// Draws the valves over one another about their nulls; none if no model has one.
/// @param range  least and greatest input of the records; none without a record
std::optional<Item> valve_item(const std::vector<ident::Model>& models,
                               const std::optional<std::pair<double, double>>& range) {
  constexpr double kShownDeadBands = 2.0;  // on each side of the null, in which a change of the dead band is seen
  constexpr double kMuchWider = 3.0;
  std::vector<const ident::Model*> valves;
  double low = 0.0;
  double high = 0.0;
  Item item{.heading = "Static map of each valve; dead band and null of the last one are marked"};
  for (const ident::Model& model : models) {
    if (!model.input_map) continue;
    const ident::ValveMap& map = *model.input_map;
    const double reach = kShownDeadBands * map.dead_band + 0.05;
    low = valves.empty() ? map.null - reach : std::min(low, map.null - reach);
    high = valves.empty() ? map.null + reach : std::max(high, map.null + reach);
    valves.push_back(&model);
    item.remark.seen += fmt::format("{} passes nothing from {:.3g} to {:.3g} {}. ", model.name,
                                    map.null - map.dead_band, map.null + map.dead_band, model.input_unit);
  }
  if (valves.empty()) return std::nullopt;
  plot::Panel about_null = valve_panel(valves, low, high);
  item.figure = plot::Figure{.title = item.heading, .panels = {}};
  // Over the volts of a record a dead band is a few hundredths of the picture.
  if (range && range->second - range->first > kMuchWider * (high - low)) {
    item.figure->panels.push_back(valve_panel(valves, range->first, range->second));
    for (plot::Series& series : about_null.series) series.label.clear();
    for (plot::Shade& shade : about_null.shades) shade.label.clear();
    for (plot::Rule& rule : about_null.rules) rule.label.clear();
    about_null.x_label += ", about the null";
    // Panels without ranges of their own share one.
    item.figure->panels.front().x_range = *range;
    about_null.x_range = std::pair(low, high);
    item.remark.seen += "The lower picture shows the same about the null. ";
  }
  item.figure->panels.push_back(std::move(about_null));
  item.remark.good = "Lines that cover one another.";
  item.remark.to_do = "A wider flat part is a wider dead band; a shifted one is a null that moved.";
  return item;
}

std::optional<Item> step_item(const std::vector<ident::Model>& models) {
  std::vector<const ident::Model*> shown;
  Item item{.heading = "Output and speed after " + step_text(models.front())};
  try {
    for (const ident::Model& model : models) {
      shown.push_back(&model);
      item.remark.seen += step_sentence(model) + " ";
    }
    item.figure = step_figure(shown, item.heading);
  } catch (const ConfigError&) {
    return std::nullopt;  // no step: more zeros than poles
  }
  item.remark.good = fmt::format("Lines that cover one another{}.",
                                 item.figure->panels.front().shades.empty()
                                     ? ""
                                     : " outside the hatched part, which is faster than the usable band");
  item.remark.to_do = "A lower speed is a lower gain: pressure, leak or valve.";
  return item;
}

}  // namespace

Page comparison_page(const ComparisonFindings& findings, const std::vector<ComparedSubject>& subjects) {
  Section parameters{.title = "Parameters"};
  std::vector<std::string> to_do;
  for (const ComparedSubject& subject : subjects) {
    if (!subject.change) continue;
    parameters.items.push_back(changes_item(subjects.front(), subject));
    const std::string& text = parameters.items.back().remark.to_do;
    if (!text.empty() && std::find(to_do.begin(), to_do.end(), text) == to_do.end()) to_do.push_back(text);
  }
  if (!findings.to_do.empty()) to_do.push_back(findings.to_do);
  // The same advice for several runs is given once, in the box.
  const std::string advice = to_do.size() == 1 ? paragraph("To do: " + to_do.front()) : std::string();
  for (Item& item : parameters.items) {
    if (!advice.empty() && item.remark.to_do == to_do.front()) item.remark.to_do = "As the box above says.";
  }
  const std::string lead =
      fmt::format("<section class=\"verdict {}\"><h2>{}</h2>\n{}{}</section>\n", findings.is_alike ? "all" : "some",
                  escaped(findings.heading), list(findings.sentences), advice);
  Section models{.title = "Models"};
  const std::vector<ComparedSubject> drawn = fitting(subjects);
  for (const ComparedSubject& subject : drawn) {
    models.items.push_back({.heading = subject.label, .html = equation(subject.model)});
  }
  Section time{.title = "Over time"};
  if (Item item = findings.is_one_record ? models_on_record_item(subjects) : records_item(subjects); item.figure)
    time.items.push_back(std::move(item));
  Section frequency{.title = "Frequency response"};
  if (!drawn.empty()) frequency.items.push_back(bode_item(drawn, findings.is_one_plant));
  const std::vector<ident::Model> named = labelled(drawn);
  Section valve{.title = "Valve"};
  if (auto item = valve_item(named, input_range(subjects))) {
    if (findings.is_one_plant) item->remark.to_do = std::string(kModelsDiffer) + ".";
    valve.items.push_back(std::move(*item));
  }
  Section step{.title = "Step response"};
  if (auto item = named.empty() ? std::nullopt : step_item(named)) {
    if (is_only_map_changed(subjects)) item->remark.to_do = kOnlyTheMap;
    if (findings.is_one_plant) item->remark.to_do = std::string(kModelsDiffer) + ".";
    step.items.push_back(std::move(*item));
  }
  Section provenance{.title = "Provenance"};
  if (!findings.sources.empty()) provenance.items.push_back({.heading = "", .html = list(findings.sources)});
  if (findings.is_one_record) {
    return assembled(findings.title, lead, {time, parameters, valve, step, frequency, models, provenance},
                     findings.rig);
  }
  return assembled(findings.title, lead, {parameters, valve, step, time, frequency, models, provenance}, findings.rig);
}

}  // namespace eha::report
