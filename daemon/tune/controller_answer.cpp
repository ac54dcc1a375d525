// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/tune/controller_answer.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <optional>
#include <vector>

#include "config/bound_text.hpp"
#include "core/shell_word.hpp"
#include "daemon/report/html.hpp"
#include "daemon/tune/expected_trip.hpp"
#include "ident/model/parameter_text.hpp"
#include "ident/valve/leak.hpp"

namespace eha::tune {
namespace {

std::vector<std::string> lines_of(const std::string& text) {
  std::vector<std::string> lines;
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t end = std::min(text.find('\n', at), text.size());
    lines.push_back(text.substr(at, end - at));
    at = end + 1;
  }
  return lines;
}

/// Time of the trial's step from a tenth to nine tenths of its way; none without a trial on the twin.
std::optional<double> rise_s(const ControllerSubject& subject) {
  if (!subject.trace) return std::nullopt;
  const ident::AxisSettings& settings = subject.controller.settings;
  const ident::TrialPlan plan = ident::trial_plan(settings);
  const ident::TrialMotion motion(settings, plan, settings.reference.lowest);
  const TrialTrace& trace = *subject.trace;
  std::vector<std::size_t> rows;  // of the step
  for (std::size_t row = 0; row < trace.time_s.size(); ++row) {
    const auto part = motion.part(row);
    if (part == ident::TrialMotion::Part::step) rows.push_back(row);
    if (part != ident::TrialMotion::Part::step && part != ident::TrialMotion::Part::rest) break;
  }
  if (rows.empty()) return std::nullopt;
  const double start = trace.rod_in[rows.front()];
  const double way = trace.reference_in[rows.back()] - start;  // to either side
  std::optional<double> low_s;
  for (const std::size_t row : rows) {
    const double share = (trace.rod_in[row] - start) / way;
    if (!low_s && share >= 0.1) low_s = trace.time_s[row];
    if (low_s && share >= 0.9) return trace.time_s[row] - *low_s;
  }
  return std::nullopt;
}

std::string at_most(double bound) { return config::upper_bound_text(bound); }
std::string at_least(double bound) { return config::lower_bound_text(bound); }

std::string margins(const config::ControllerPromise& p) {
  return fmt::format(
      "Margins: phase {:.3g} degrees and at least {} for 95 % of what the model may be, gain {:.3g} times and at "
      "least {}, {:.3g} s of further delay and at least {}.",
      p.phase_margin_deg.value, at_least(p.phase_margin_deg.lower), p.gain_margin.value, at_least(p.gain_margin.lower),
      p.delay_margin_s.value, at_least(p.delay_margin_s.lower));
}

/// "0.0123 in, promised at most 0.01": one figure of a trial.
std::string beside_limit(const MeasuredFigure& figure, const DisplayUnit& unit) {
  const double factor = unit.factor(figure.unit);
  return fmt::format("{:.3g}{}, promised at {} {}", factor * figure.value, ident::after_number(unit.of(figure.unit)),
                     figure.is_least ? "least" : "most", config::bound_text(factor * figure.limit, !figure.is_least));
}

/// What the headline says: the errors as measured on the rig, else as the trials reached them; then what is promised.
std::string errors_text(const ControllerSubject& subject) {
  const double factor = subject.unit.factor("in");
  const std::string in = subject.unit.of("in");
  const config::ControllerPromise& p = subject.controller.promise;
  if (!subject.measured) {
    return fmt::format(
        "error within {:.3g} {} while it moves, {:.3g} {} at rest, in the median of {} simulated trials; promised: {} "
        "and "
        "{}",
        factor * p.following_worst_in.value, in, factor * p.rest_error_in.value, in, p.twins,
        at_most(factor * p.following_worst_in.upper), at_most(factor * p.rest_error_in.upper));
  }
  std::string text;
  const auto add = [&](std::string_view name, std::string_view when) {
    for (const MeasuredFigure& figure : subject.measured->figures) {
      if (figure.name == name)
        text += fmt::format("{} {:.3g} {}, ", when, subject.unit.factor(figure.unit) * figure.value, in);
    }
  };
  // With a step the trial has parts, of which the trapezoids have this figure.
  const bool has_parts = std::any_of(subject.measured->figures.begin(), subject.measured->figures.end(),
                                     [](const auto& f) { return f.name == kOvershoot; });
  add("following error, worst", has_parts ? "greatest error in the trapezoids" : "greatest measured error");
  add("error at rest, worst", "error at rest");
  // What noise hides is neither kept nor broken.
  const auto& figures = subject.measured->figures;
  const auto count = [&](std::string_view kept) {
    return std::count_if(figures.begin(), figures.end(), [&](const MeasuredFigure& f) { return f.kept == kept; });
  };
  const auto kept = count("yes");
  const auto all = static_cast<std::ptrdiff_t>(figures.size());
  if (count("no") > 0) return text + "the promise is not kept";
  return text + (kept == all ? std::string("promise kept")
                             : fmt::format("{} of {} figures kept, {} hidden by noise", kept, all, all - kept));
}

std::string upper_case(std::string text) {
  for (char& c : text) c = static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
  return text;
}

std::string named(const config::ControllerConfig& c) {
  return fmt::format("{} controller \"{}\"", upper_case(std::string(ident::text(c.settings.kind))), c.name);
}

}  // namespace

std::string headline(const ControllerSubject& subject) {
  const bool leaks = subject.measured && subject.measured->leaks;
  return fmt::format("{}: {}{}", named(subject.controller), leaks ? "the rig leaks; " : "", errors_text(subject));
}

std::string answer_box(const ControllerSubject& subject) {
  const config::ControllerConfig& c = subject.controller;
  const config::ControllerPromise& p = c.promise;
  const double factor = subject.unit.factor("in");
  const std::string in = subject.unit.of("in");
  std::vector<std::string> not_kept;
  if (subject.measured) {
    for (const MeasuredFigure& figure : subject.measured->figures) {
      if (figure.kept == "no") {
        not_kept.push_back(fmt::format("{} ({})", figure.name, beside_limit(figure, subject.unit)));
      }
    }
  }
  std::string promise = report::paragraph(fmt::format(
      "While the rod moves it is within {} {} of the reference (RMS {}), at rest within {} {}: so it is promised, by "
      "trials on {} drawn rigs.",
      at_most(factor * p.following_worst_in.upper), in, at_most(factor * p.following_rms_in.upper),
      at_most(factor * p.rest_error_in.upper), in, p.twins));
  const double step = factor * std::abs(ident::trial_plan(c.settings).step);
  const std::optional<double> rise = rise_s(subject);
  promise += report::paragraph(fmt::format(
      "A step of {:.3g} {}{}: the rod settles within 2 % of it at most {} s after the reference arrives, and "
      "overshoots by at most {} {}. The reference moves at up to {:.3g} {}/s and {:.3g} {}/s^2.",
      step, in, rise ? fmt::format(" takes {:.2g} s from 10 to 90 % on the twin", *rise) : std::string(),
      at_most(p.settling_s.upper), at_most(factor * p.overshoot_in.upper), in, factor * c.settings.reference.velocity,
      in, factor * c.settings.reference.acceleration, in));
  promise += report::paragraph(margins(p));
  std::vector<std::string> limits = lines_of(p.remarks);
  if (subject.measured && !subject.measured->advice.empty()) {  // a leak that tune has named, too
    std::erase_if(limits, [&](const std::string& line) { return line.starts_with(subject.measured->advice); });
  }
  if (!limits.empty()) {
    promise += report::paragraph("What limits it, and what the promise rests on:") + report::list(limits);
  }
  const bool leaks = subject.measured && subject.measured->leaks;
  const std::string name = named(c);
  std::vector<std::string> shows;
  if (subject.measured) {
    for (const std::string& change : subject.measured->changes)
      shows.push_back("The moving rod shows: " + change + ".");
    if (!subject.measured->advice.empty()) shows.push_back(subject.measured->advice);
  }
  if (!not_kept.empty()) {
    return fmt::format(
        "<section class=\"verdict none\"><h2>{}</h2>\n{}{}<details>\n<summary>What was promised</summary>\n{}"
        "</details>\n</section>\n",
        report::escaped(headline(subject)),
        report::paragraph(
            fmt::format("The rig did not keep: {}; the table below has what was measured.", fmt::join(not_kept, ", "))),
        report::list(shows), promise);
  }
  promise = report::list(shows) + promise;  // what was found on the rig first
  const bool trips = !subject.measured && p.remarks.find(kTrialTrips) != std::string::npos;
  if (trips) {
    const std::vector<std::string> remarks = lines_of(p.remarks);
    const auto reason =
        std::find_if(remarks.begin(), remarks.end(), [](const auto& line) { return line.starts_with(kTrialTrips); });
    return fmt::format(
        "<section class=\"verdict none\"><h2>{}</h2>\n{}<details>\n<summary>What is promised without the trip</summary>"
        "\n{}</details>\n</section>\n",
        report::escaped(name + ": its trial will trip on this rig"), report::paragraph(*reason), promise);
  }
  const bool is_named = subject.rig && !subject.rig->controller.empty();
  const std::string file = is_named ? subject.rig->controller : c.name + ".toml";
  const std::string to_plc = fmt::format("`{}` (or c, simulink) writes it for a PLC.", suggest::export_for_plc(file));
  std::string next;
  if (!subject.measured) {
    next = fmt::format("`{}` plays it on the rig and says whether the promise is kept; then {}",
                       suggest::track(subject.rig.value_or(suggest::RigAccess{}), file), to_plc);
  } else if (!subject.measured->advice.empty()) {
    next = "what is said above of the moving rod; a controller goes to a PLC after that.";
  } else {
    next = leaks ? fmt::format("{}.", ident::kRepairFirst) : to_plc;
  }
  promise += report::paragraph("Next: " + next);
  return fmt::format("<section class=\"verdict some\"><h2>{}</h2>\n{}</section>\n", report::escaped(headline(subject)),
                     promise);
}

}  // namespace eha::tune
