// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/tune/controller_page.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>

#include "config/bound_text.hpp"
#include "core/time_text.hpp"
#include "daemon/plot/envelope.hpp"
#include "daemon/report/figures.hpp"
#include "daemon/report/html.hpp"
#include "daemon/tune/controller_answer.hpp"
#include "daemon/tune/kind_table.hpp"

namespace eha::tune {
namespace {

using Complex = std::complex<double>;
using report::Column;

constexpr double kAtEnd = 1e-6;        // of the step, as TrialScore
constexpr double kBeyondBand = 0.025;  // of the draws, on each side
constexpr double kDegrees = 180.0 / std::numbers::pi;

/// Whether a row, or the mean that it is, has a share in the sweep, in which the rod follows tones and no reference.
bool is_of_sweep(const TrialTrace& trace, std::size_t row) {
  const double time_s = trace.time_s[row];
  const double reach_s = 0.5 * trace.mean_s.value_or(0.0);
  return trace.sweep_s && time_s >= trace.sweep_s->first - reach_s && time_s <= trace.sweep_s->second + reach_s;
}

/// Returns every n-th value, so that a plot stays small.
std::vector<double> thinned(const std::vector<double>& values, std::size_t every) {
  std::vector<double> result;
  for (std::size_t i = 0; i < values.size(); i += every) result.push_back(values[i]);
  return result;
}

report::Item motion(const ControllerSubject& subject) {
  report::Item item{.heading = "Step, trapezoids, sine and hold on the twin, without the sweep"};
  item.figure = motion_figure(*subject.trace, item.heading, subject.unit);
  const config::ControllerPromise& p = subject.controller.promise;
  const double factor = subject.unit.factor("in");
  item.remark.seen = fmt::format("The error in trapezoids is promised within {} {} RMS, {} {} at worst.",
                                 config::upper_bound_text(factor * p.following_rms_in.upper), subject.unit.of("in"),
                                 config::upper_bound_text(factor * p.following_worst_in.upper), subject.unit.of("in"));
  if (!(subject.controller.settings.feedback.ki > 0.0)) {
    item.remark.seen +=
        " In the hold the rod stands off the reference: without an integral that is where gain times "
        "offset makes up for what null, dead band and friction differ from the numbers used.";
  }
  item.remark.good = "The error is small while the rod moves and at rest, and the command does not swing at rest.";
  item.remark.to_do = "Compare the rig's own run with this; a larger error says that valve or load have changed.";
  return item;
}

struct Curves {
  std::vector<double> w;
  std::vector<Complex> nominal;
  std::vector<std::vector<Complex>> draws;
};

Curves curves(const ControllerSubject& subject) {
  const ident::AxisPlant& plant = subject.inputs->plant;
  const ident::AxisCoefficients c = ident::coefficients(subject.controller.settings);
  Curves result{.w = {}, .nominal = {}, .draws = {}};
  std::vector<std::size_t> used;
  for (std::size_t i = 0; i < plant.grid_rad_s.size(); ++i) {
    const double w = plant.grid_rad_s[i];
    const double size = std::abs(ident::sampled_feedback(c, w) * plant.response[i]);
    if (size < 100.0 && size > 1e-3) used.push_back(i);
  }
  const auto loop = [&](const std::vector<Complex>& response) {
    std::vector<Complex> l;
    for (const std::size_t i : used) l.push_back(ident::sampled_feedback(c, plant.grid_rad_s[i]) * response[i]);
    return l;
  };
  for (const std::size_t i : used) result.w.push_back(plant.grid_rad_s[i]);
  result.nominal = loop(plant.response);
  for (const auto& response : plant.drawn_responses) result.draws.push_back(loop(response));
  return result;
}

/// Draws a curve and the band that contains 95 % of the draws, over c.w.
/// @param of  maps a response to numbers
template <typename Numbers>
void add_band(plot::Panel& panel, const Curves& c, const Numbers& of) {
  plot::Series band{.label = "95 % of the draws", .mark = plot::Mark::band, .style = 2};
  plot::Series line{.label = "model", .mark = plot::Mark::line, .style = 1};
  line.y = of(c.nominal);
  std::vector<std::vector<double>> draws;
  for (const auto& draw : c.draws) draws.push_back(of(draw));
  for (std::size_t i = 0; i < c.w.size(); ++i) {
    std::vector<double> drawn;
    for (const auto& draw : draws) drawn.push_back(draw[i]);
    const ident::Interval range = ident::interval(line.y[i], std::move(drawn), kBeyondBand);
    const double f = c.w[i] / (2.0 * std::numbers::pi);
    band.x.push_back(f);
    band.lower.push_back(range.lower);
    band.upper.push_back(range.upper);
    line.x.push_back(f);
  }
  panel.series.push_back(std::move(band));
  panel.series.push_back(std::move(line));
}

/// A number for each value.
template <typename Number>
auto each(const Number& of) {
  return [of](const std::vector<Complex>& values) {
    std::vector<double> numbers;
    for (const Complex value : values) numbers.push_back(of(value));
    return numbers;
  };
}

double decibels(Complex value) { return 20.0 * std::log10(std::abs(value)); }

/// Returns phases without jumps, the first between 0 and -360.
std::vector<double> unwrapped_deg(const std::vector<Complex>& values) {
  std::vector<double> phases;
  for (const Complex value : values) {
    double phase = std::arg(value) * kDegrees;
    if (phases.empty()) {
      if (phase > 0.0) phase -= 360.0;
    } else {
      phase += 360.0 * std::round((phases.back() - phase) / 360.0);
    }
    phases.push_back(phase);
  }
  return phases;
}

report::Item bode(const ControllerSubject& subject, const Curves& c) {
  report::Item item{.heading = "Open loop, without the dead band"};
  plot::Panel gain{.x_label = "", .y_label = "gain [dB]", .log_x = true};
  add_band(gain, c, each(decibels));
  gain.rules.push_back({.at = 0.0, .vertical = false});
  plot::Panel phase{.x_label = "frequency [Hz]", .y_label = "phase [deg]", .log_x = true};
  add_band(phase, c, unwrapped_deg);
  phase.y_range = std::pair(-360.0, 0.0);  // beyond the second turn nothing is to be read
  phase.rules.push_back({.at = -180.0, .vertical = false});
  item.figure = plot::Figure{.title = item.heading, .panels = {std::move(gain), std::move(phase)}};
  const config::ControllerPromise& p = subject.controller.promise;
  item.remark.seen = fmt::format(
      "Phase margin {:.3g} degrees, at least {} for 95 % of the draws; gain margin {:.3g} times, at least {}.",
      p.phase_margin_deg.value, config::lower_bound_text(p.phase_margin_deg.lower), p.gain_margin.value,
      config::lower_bound_text(p.gain_margin.lower));
  item.remark.seen +=
      " Of the linear loop: model, filter and feedback about a moving rod. The dead band, which the inverse of the "
      "valve bridges, is not in it.";
  item.remark.seen += " The phase is drawn down to -360 degrees.";
  item.remark.good = "At least 45 degrees where the gain is 0 dB, over the whole band.";
  item.remark.to_do = "Where the band comes within 30 degrees of -180 at 0 dB: make a longer record, then tune again.";
  return item;
}

report::Item nyquist(const ControllerSubject& subject, const Curves& c) {
  report::Item item{.heading = "Nyquist plot of the open loop"};
  plot::Panel panel{
      .x_label = "real part", .y_label = "imaginary part", .x_range = {{-2.0, 1.0}}, .y_range = {{-2.0, 1.0}}};
  panel.has_equal_scales = true;
  const std::size_t every = std::max<std::size_t>(1, c.draws.size() / 20);
  for (std::size_t d = 0; d < c.draws.size(); d += every) {
    plot::Series series{.label = d == 0 ? "draws" : "", .style = plot::kGuideStyle};
    for (const Complex l : c.draws[d]) {
      series.x.push_back(l.real());
      series.y.push_back(l.imag());
    }
    panel.series.push_back(std::move(series));
  }
  plot::Series model{.label = "model", .style = 1};
  for (const Complex l : c.nominal) {
    model.x.push_back(l.real());
    model.y.push_back(l.imag());
  }
  panel.series.push_back(std::move(model));
  const double limit = subject.inputs->task.axis.sensitivity;
  plot::Series circle{.label = fmt::format("sensitivity {:g}", limit), .style = 2};
  for (int i = 0; i <= 90; ++i) {
    const double angle = 2.0 * std::numbers::pi * i / 90.0;
    circle.x.push_back(-1.0 + std::cos(angle) / limit);
    circle.y.push_back(std::sin(angle) / limit);
  }
  panel.series.push_back(std::move(circle));
  panel.captions.push_back({-1.0, 0.0, "-1"});
  item.figure = plot::Figure{.title = item.heading, .panels = {std::move(panel)}};
  item.remark.seen = fmt::format(
      "Ms {:.3f}; 95 % of the draws stay below {:.3f}, and the circle about -1 is the Ms of {:g} that was asked for.",
      subject.controller.promise.ms.value, subject.controller.promise.ms.upper, limit);
  item.remark.good = "The model and 95 % of the draws stay outside the circle.";
  item.remark.to_do = "Nothing, while they do.";
  return item;
}

report::Item sensitivity(const Curves& c) {
  report::Item item{.heading = "Sensitivity 1 / (1 + L)"};
  plot::Panel panel{.x_label = "frequency [Hz]", .y_label = "gain [dB]", .log_x = true};
  add_band(panel, c, each([](Complex value) { return decibels(1.0 / (1.0 + value)); }));
  panel.rules.push_back({.at = 0.0, .vertical = false});
  item.figure = plot::Figure{.title = item.heading, .panels = {std::move(panel)}};
  item.remark.seen = "Loads below the frequency where it crosses 0 dB are reduced, those above are not.";
  item.remark.good = "Low on the left, and a low top.";
  item.remark.to_do = "Feed-forward follows the reference; this shows what feedback does against loads.";
  return item;
}

}  // namespace

plot::Figure motion_figure(const TrialTrace& t, std::string title, const DisplayUnit& unit) {
  constexpr std::size_t kErrorBuckets = 2000;
  const std::size_t every = std::max<std::size_t>(1, t.time_s.size() / (2 * kErrorBuckets));
  const std::vector<double> time = thinned(t.time_s, every);
  const double factor = unit.factor("in");
  const auto shown = [&](const std::vector<double>& values) {
    std::vector<double> some = thinned(values, every);
    for (double& value : some) value *= factor;
    return some;
  };
  std::vector<double> error;
  for (std::size_t i = 0; i < t.time_s.size(); ++i) {
    // That of the sweep would set the axis.
    error.push_back(is_of_sweep(t, i) ? std::nan("") : factor * (t.rod_in[i] - t.reference_in[i]));
  }
  plot::Panel position{.x_label = "", .y_label = fmt::format("position [{}]", unit.of("in"))};
  position.series.push_back({.label = "rod", .x = time, .y = shown(t.rod_in), .style = 0});
  position.series.push_back({.label = "reference", .x = time, .y = shown(t.reference_in), .style = 1});
  plot::Panel following{.x_label = "", .y_label = fmt::format("error, rod - reference [{}]", unit.of("in"))};
  const std::string means = t.mean_s ? fmt::format("means over {:.0f} ms", 1e3 * *t.mean_s) : std::string();
  // Every row counts: the remark names the greatest.
  plot::Points errors = plot::envelope(t.time_s, error, kErrorBuckets);
  following.series.push_back({.label = means, .x = std::move(errors.x), .y = std::move(errors.y), .style = 1});
  plot::Panel command{.x_label = "time [s]", .y_label = "command [V]"};
  // A command is held until the next tick.
  const plot::Series volts{.label = "", .x = time, .y = thinned(t.command_V, every), .style = 1};
  command.series.push_back(every == 1 ? report::held(volts) : volts);
  if (t.sweep_s) {
    for (plot::Panel* panel : {&position, &following, &command}) {
      panel->shades.push_back({.from = t.sweep_s->first, .to = t.sweep_s->second});
    }
    position.shades.back().label = "sweep for the margins";
  }
  return {.title = std::move(title), .panels = {std::move(position), std::move(following), std::move(command)}};
}

plot::Figure step_figure(const TrialTrace& trace, const config::ControllerConfig& controller, const DisplayUnit& unit) {
  const ident::AxisSettings& settings = controller.settings;
  const ident::TrialMotion motion(settings, ident::trial_plan(settings), settings.reference.lowest);
  std::size_t rows = 0;
  while (rows < trace.time_s.size() &&
         (motion.part(rows) == ident::TrialMotion::Part::rest || motion.part(rows) == ident::TrialMotion::Part::step)) {
    ++rows;
  }
  const auto first = [&](const std::vector<double>& values) {
    return std::vector<double>(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(rows));
  };
  plot::Figure figure =
      motion_figure({first(trace.time_s), first(trace.reference_in), first(trace.rod_in), first(trace.command_V)},
                    fmt::format("{}: a step on the simulated rig", controller.name), unit);
  if (rows == 0) return figure;
  const double end = trace.reference_in[rows - 1];
  const double still = kAtEnd * std::abs(motion.way());
  const auto moves = [&](std::size_t row) { return std::abs(trace.reference_in[row] - end) > still; };
  std::size_t ended = rows;
  while (ended > 0 && !moves(ended - 1)) --ended;
  if (ended < rows) {
    for (plot::Panel& panel : figure.panels) panel.rules.push_back({.at = trace.time_s[ended], .vertical = true});
    figure.panels.front().rules.back().label = "settling counts from here";
  }
  return figure;
}

std::vector<std::vector<std::string>> promise_rows(const config::ControllerPromise& p, const DisplayUnit& display) {
  const auto row = [&](const char* what, const config::PromisedFigure& f, const std::string& unit) {
    const double factor = display.factor(unit);
    const auto number = [](double value) {
      return std::abs(value) > 1e8 ? std::string("no limit") : fmt::format("{:.3g}", value);
    };
    const auto bound = [&](double value, bool is_upper) {
      return std::abs(value) > 1e8 ? number(value) : config::bound_text(value, is_upper);
    };
    return std::vector<std::string>{what, number(factor * f.value), bound(factor * f.lower, false),
                                    bound(factor * f.upper, true), display.of(unit)};
  };
  return {row("following error, RMS", p.following_rms_in, "in"),
          row("following error, worst", p.following_worst_in, "in"),
          row("error on a sine, RMS", p.sine_rms_in, "in"),
          row(kOvershoot, p.overshoot_in, "in"),
          row("settling within 2 % of the step", p.settling_s, "s"),
          row("error at rest, worst", p.rest_error_in, "in"),
          row("motion at rest, peak to peak", p.standing_in, "in"),
          row("Ms", p.ms, ""),
          row("Mt", p.mt, ""),
          row("phase margin", p.phase_margin_deg, "deg"),
          row("gain margin", p.gain_margin, "times"),
          row("delay margin", p.delay_margin_s, "s")};
}

std::string promise_note(const ident::AxisSettings& settings, const DisplayUnit& display) {
  const double factor = display.factor("in");
  const std::string in = display.of("in");
  return fmt::format(
      "From, to: the range of the trials and a quarter of it more; of a margin 95 % of 200 draws of the model keep "
      "each bound. A step is a new position: the reference goes there at up to {:.3g} {}/s and {:.3g} {}/s^2, settling "
      "counts from its end, and overshoot is beyond its end. Ms and Mt: the greatest factor by which the loop passes "
      "on a disturbance of the place, and a reference.",
      factor * settings.reference.velocity, in, factor * settings.reference.acceleration, in);
}

std::vector<std::vector<std::string>> setting_rows(const config::ControllerConfig& c, const DisplayUnit& display) {
  const ident::AxisSettings& s = c.settings;
  const auto row = [&](const char* what, double value, const std::string& unit) {
    return std::vector<std::string>{what, fmt::format("{:.4g}", value * display.factor(unit)), display.of(unit)};
  };
  return {row("kp", s.feedback.kp, "1/s"),
          row("ki", s.feedback.ki, "1/s^2"),
          row("kd", s.feedback.kd, "no unit"),
          row("filter", s.feedback.filter_s, "s"),
          row("null", s.inverse.null, "V"),
          row("half dead band", s.inverse.dead_band, "V"),
          row("gain extending", s.inverse.gain_positive, "in/(V s)"),
          row("gain retracting", s.inverse.gain_negative, "in/(V s)"),
          row("smoothing", s.inverse.smoothing, "in/s"),
          row("acceleration feed-forward", s.feed_forward.acceleration_s, "s"),
          row("reference velocity", s.reference.velocity, "in/s"),
          row("reference acceleration", s.reference.acceleration, "in/s^2"),
          row("reference jerk", s.reference.jerk, "in/s^3"),
          row("tick", s.tick_s, "s")};
}

namespace {

/// The greatest error that the curve of a trial shows, in a sentence.
std::string greatest_error(const TrialTrace& trace, const DisplayUnit& unit) {
  double greatest = 0.0;
  double at_s = 0.0;
  for (std::size_t i = 0; i < trace.time_s.size(); ++i) {
    const double error = std::abs(trace.rod_in[i] - trace.reference_in[i]);
    if (is_of_sweep(trace, i) || !(error > greatest)) continue;
    greatest = error;
    at_s = trace.time_s[i];
  }
  return fmt::format("The greatest error of the curve is {:.3g} {} at {} s.", unit.factor("in") * greatest,
                     unit.of("in"), time_text(at_s));
}

/// Writes the measured and the promised figures.
report::Section measured(const MeasuredTrial& trial, const config::ControllerPromise& promise,
                         const DisplayUnit& unit) {
  std::vector<std::vector<std::string>> rows;
  for (const auto& row : promise_rows(promise, unit)) {
    for (const MeasuredFigure& figure : trial.figures) {
      if (figure.name == row[0])
        rows.push_back({row[0],
                        (figure.is_lower_bound ? "at least " : "") +
                            fmt::format("{:.3g}", unit.factor(figure.unit) * figure.value),
                        fmt::format("{:.2g}", unit.factor(figure.unit) * figure.noise),
                        fmt::format("{} {}", figure.is_least ? "at least" : "at most",
                                    config::bound_text(unit.factor(figure.unit) * figure.limit, !figure.is_least)),
                        row[4], figure.kept});
    }
  }
  report::Section section{.title = "On the rig"};
  section.items.push_back({.heading = "Measured beside promised, run " + trial.run,
                           .html = report::table({{"figure", Column::text},
                                                  {"measured", Column::number},
                                                  {"noise adds to", Column::number},
                                                  {"promised", Column::number},
                                                  {"unit", Column::text},
                                                  {"kept", Column::text}},
                                                 rows) +
                                   report::paragraph(trial.by_sweep)});
  report::Item item{.heading = "The trial on the rig"};
  item.figure = motion_figure(trial.trace, item.heading, unit);
  item.remark.seen = "Readings and errors are means over 50 ms, because a reading's noise is no error of the rod.";
  if (trial.trace.sweep_s) {
    item.remark.seen +=
        " Grey: the sweep that measures the margins by tones; what the rod does in it is no following error, and not "
        "drawn as one.";
  }
  const bool has_step = std::any_of(trial.figures.begin(), trial.figures.end(),
                                    [](const MeasuredFigure& figure) { return figure.name == kOvershoot; });
  if (has_step) {
    item.remark.seen += " " + greatest_error(trial.trace, unit);
    item.remark.good =
        "Each part of the trial has its own figures in the table: first a step its overshoot and settling, then fast "
        "moves the following error, a sine its RMS, and at last the rest its worst error and motion. In the step, the "
        "sine and between the parts the curve may reach further than the worst following error of the table.";
  } else {
    item.remark.good = "The error is as in the table.";
  }
  item.remark.to_do = trial.advice.empty() ? "Nothing." : "As the box above says.";
  section.items.push_back(std::move(item));
  return section;
}

}  // namespace

report::Page controller_page(const ControllerSubject& subject) {
  const config::ControllerConfig& c = subject.controller;
  std::string lead = subject.lead_html;
  lead += fmt::format(
      "<p class=\"subtitle\">{}</p>\n",
      report::escaped(fmt::format("{} controller \"{}\" for {}, to {}, tick {:g} s", ident::text(c.settings.kind),
                                  c.name, c.provenance.rig, c.purpose, c.settings.tick_s) +
                      subject.dated));
  lead += answer_box(subject);
  std::vector<report::Section> sections;
  if (subject.measured) sections.push_back(measured(*subject.measured, c.promise, subject.unit));
  report::Section promise{.title = "Promise"};
  promise.items.push_back(
      {.heading = fmt::format("On {} drawn rigs; margins over 200 draws of the model", c.promise.twins),
       .html = report::table({{"figure", Column::text},
                              {"value", Column::number},
                              {"from", Column::number},
                              {"to", Column::number},
                              {"unit", Column::text}},
                             promise_rows(c.promise, subject.unit)) +
               report::paragraph(promise_note(c.settings, subject.unit))});
  if (const auto rows = kind_rows(subject.kinds, subject.unit); !rows.empty()) {
    std::vector<report::TableColumn> columns;
    for (const std::string& title : kind_titles(subject.unit)) {
      columns.push_back({title, columns.empty() ? Column::text : Column::number});
    }
    promise.items.push_back(
        {.heading = "Kinds of feedback", .html = report::table(columns, rows) + report::paragraph(kKindNote)});
  }
  report::Section plots{.title = "On the twin"};
  if (subject.trace) plots.items.push_back(motion(subject));
  report::Section loop{.title = "Loop"};
  if (subject.inputs) {
    const Curves all = curves(subject);
    loop.items.push_back(bode(subject, all));
    loop.items.push_back(nyquist(subject, all));
    loop.items.push_back(sensitivity(all));
  } else {
    loop.items.push_back({.heading = "No plots", .html = report::paragraph(subject.why_without_plots)});
  }
  report::Section settings{.title = "Settings"};
  settings.items.push_back(
      {.heading = "Numbers of the file",
       .html = report::table({{"setting", Column::text}, {"value", Column::number}, {"unit", Column::text}},
                             setting_rows(c, subject.unit))});
  settings.items.push_back({.heading = "Made from",
                            .html = report::table({{"what", Column::text}, {"which", Column::wide_text}},
                                                  {{"model", c.provenance.model},
                                                   {"SHA-256", c.provenance.model_sha256},
                                                   {"rig file", c.provenance.rig_file},
                                                   {"SHA-256", c.provenance.rig_sha256},
                                                   {"run", c.provenance.run},
                                                   {"twin", c.provenance.twin},
                                                   {"made by", c.provenance.made_by}})});
  sections.insert(sections.end(), {promise, plots, loop, settings});
  sections.insert(sections.end(), subject.further.begin(), subject.further.end());
  const std::string title =
      subject.title.empty() ? fmt::format("{} \"{}\"", subject.measured ? "Trial of controller" : "Controller", c.name)
                            : subject.title;
  return report::assembled(title, lead, sections, subject.rig);
}

}  // namespace eha::tune
