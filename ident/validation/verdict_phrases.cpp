// SPDX-License-Identifier: GPL-3.0-or-later
#include "ident/validation/verdict_phrases.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/time_text.hpp"
#include "ident/model/parameter_text.hpp"
#include "ident/model/record_start.hpp"
#include "ident/validation/map_error.hpp"
#include "ident/validation/record_findings.hpp"
#include "ident/validation/verdict.hpp"

namespace eha::ident {

std::string half_width_sign(const Model& model, std::string_view sign) {
  return std::string(sign) + (model.verdict && may_miss_a_part(*model.verdict) ? " at least" : "");
}

namespace {

std::string_view effect_of_one(const NonlinearityTest& test) {
  switch (test.kind) {
    case NonlinearKind::level:
      if (test.gain == GainTrend::falls)
        return "level of the input: the gain falls as the input grows, as with the edges of a dead band, friction or a "
               "saturation";
      if (test.gain == GainTrend::grows)
        return "level of the input: the gain grows with it, as beyond a valve's dead band or overlap, or where "
               "the gain itself is curved";
      return "level of the input, as where the gain changes with it";
    case NonlinearKind::direction:
      return "direction of the input, for instance with play, hysteresis or a limited rate";
    case NonlinearKind::motion:
      return "direction of motion, for instance with dry friction or play";
    case NonlinearKind::time:
      return "time, as where the gain drifts while the oil warms up or the supply sags";
    case NonlinearKind::position:
      break;
  }
  return "position, for instance where the gain of plant or sensor, or friction, changes with it";
}

}  // namespace

std::string effect_of(const NonlinearityTest& test) {
  std::string effect(effect_of_one(test));
  if (!test.or_kind) return effect;
  return fmt::format("{}, or on the {}, which this record does not tell apart", effect,
                     effect_of_one({.test = {}, .kind = *test.or_kind}));
}

std::string effect_of(const Model& model) {
  const NonlinearityTest& test = *model.validation->tests->nonlinearity;
  if (!is_of_bent_edges(model, test)) return effect_of(test);
  return "level of the input, as where a leak, friction, play or a gain that grows with the opening, which move the "
         "rod within the dead band of the model's map, bend its edges";
}

bool is_of_bent_edges(const Model& model, const NonlinearityTest& test) {
  // A jump of the error bends them, too.
  return test.kind == NonlinearKind::level && noted_shift(model) && !model.validation->jump;
}

std::string levels_text(const InputLevels& levels, const std::string& unit) {
  const double range = levels.upper - levels.lower;
  if (!(range > 0.0)) return fmt::format("{:.4g} {}", levels.upper, unit);
  if (std::abs(levels.lower + levels.upper) <= 1e-3 * range) return fmt::format("+-{:.4g} {}", 0.5 * range, unit);
  return fmt::format("{:.4g} and {:.4g} {}", levels.lower, levels.upper, unit);
}

std::string interval_text(const ParameterEstimate& p) {
  const bool has_lower = std::isfinite(p.lower95);
  const bool has_upper = std::isfinite(p.upper95);
  if (has_lower && has_upper) {
    const double width = p.upper95 - p.lower95;
    const double largest = std::max(std::abs(p.lower95), std::abs(p.upper95));
    // two digits of the width, so that its ends differ
    const double digits = width > 0.0 ? std::ceil(std::log10(largest / width)) + 2.0 : 3.0;
    return fmt::format("{0:.{2}g} to {1:.{2}g}", p.lower95, p.upper95, static_cast<int>(std::clamp(digits, 3.0, 8.0)));
  }
  if (has_lower) return fmt::format("unbounded above {:.3g}", p.lower95);
  if (has_upper) return fmt::format("unbounded below {:.3g}", p.upper95);
  return "unbounded";
}

bool is_level_out_of_sight(const Model& model, const ParameterEstimate& p) {
  constexpr double kFar = 4000.0;  // of the output's standard deviation, some thousand times its range
  if (p.role != ParameterRole::grey_box || !model.grey_box || !model.estimation) return false;
  const auto& known = model.grey_box->kind->parameters;
  const bool is_level = std::any_of(known.begin(), known.end(), [&](const GreyBoxParameter& one) {
    return one.name == p.name && one.unit == GreyBoxUnit::output;
  });
  const Score& score = model.estimation->score;
  const double left = 1.0 - 0.01 * score.r2_percent;
  if (!is_level || !(left > 0.0)) return false;
  return !std::isfinite(p.upper95) || std::abs(p.value) > kFar * std::sqrt(score.mse / left);
}

std::string frozen_in_record(const Model& model) {
  const auto frozen = model.provenance.find(kFrozenOfRecord);
  if (frozen == model.provenance.end()) return {};
  const auto cut = model.provenance.find(kWithoutFrozen);
  return fmt::format(
      "The sensor froze {}: the output kept one value to the last digit while the input moved, and no model follows "
      "that; {}.",
      frozen->second, cut == model.provenance.end() ? "record again" : "cut with " + cut->second);
}

std::string loop_in_record_of(const Model& model) {
  const auto loop = model.provenance.find(kLoopOfRecord);
  if (loop == model.provenance.end()) return {};
  return fmt::format(
      "A controller closes the loop: the input answers within its row to what moves the output beside it (correlation "
      "{}), so that gains and time constants may be biased, and bends may show that the plant has not; record with the "
      "loop open.",
      loop->second);
}

std::string gaps_in_record(const Model& model) {
  const auto gaps = model.provenance.find(kGapsOfRecord);
  if (gaps == model.provenance.end()) return {};
  const auto cut = model.provenance.find(kWithoutGaps);
  return fmt::format("Rows are missing {}, and what the input did there is not known, so that {}{}.", gaps->second,
                     comes_to_rest(model) ? "the output moves otherwise for some time afterwards"
                                          : "an integrating rod stands elsewhere afterwards",
                     cut == model.provenance.end() ? std::string() : "; cut with " + cut->second);
}

namespace {

/// "54.933 mm", without a sign of its own at 0.
std::string level_text(double level, const std::string& unit) {
  constexpr double kShown = 0.0005;
  return fmt::format("{:.3f}{}", std::abs(level) < kShown ? 0.0 : level, unit);
}

/// That the plant does not answer, when, and the cut.
std::string silence_text(const EndStop& silence, const std::string& unit, const std::string& cut) {
  const std::string when = silence.to_s
                               ? fmt::format("from {} to {} s", time_text(silence.from_s), time_text(*silence.to_s))
                               : fmt::format("from {} s on", time_text(silence.from_s));
  return fmt::format(
      "The output does not answer {}: it stands at {} while the input goes on; in all that is {:.3g} % of the samples. "
      "A pump or supply that is off, a closed valve or a signal that is lost does that; {}.",
      when, level_text(silence.level, unit), silence.percent, cut);
}

}  // namespace

std::vector<std::string> causes_in_record(const Model& model) {
  std::vector<std::string> found;
  if (!model.validation) return found;
  const std::string unit = after_number(model.output_unit);
  const auto of_record = model.provenance.find(kCutOfRecord);
  const bool is_given = of_record != model.provenance.end();
  if (const auto& stop = model.validation->end_stop) {
    const std::string where = fmt::format("at {} from {} s on", level_text(stop->level, unit), time_text(stop->from_s));
    const std::string options = is_given ? of_record->second : cut_options(*stop);
    const std::string cut = options.empty() ? "no part without moves, so record again" : "cut with " + options;
    if (stop->does_not_answer) {
      found.push_back(silence_text(*stop, unit, cut));
      return found;
    }
    const std::string both = stop->other
                                 ? fmt::format("{}, and at {} from {} s on; together", where,
                                               level_text(stop->other->level, unit), time_text(stop->other->from_s))
                                 : where + ",";
    found.push_back(fmt::format(
        "The output stands at {} {}, {} {:.3g} % of the samples, and no model follows it there; {}{} nearer to the "
        "middle of the range.",
        stop->other ? "two ends" : "an end",
        stop->other ? "(a rod on its end stops, or the sensor at its ends)"
                    : "(a rod on its end stop, or the sensor at its end)",
        both, stop->percent, cut, options.empty() ? "," : ", or record"));
  }
  if (const auto& noise = model.validation->input_noise) {
    const bool is_coarse = noise->step > 0.0;
    const std::string fault =
        is_coarse
            ? fmt::format("The recorded input is coarse: of its steps of {}", error_text(noise->step, model.input_unit))
            : fmt::format("The measured input is noisy: {} (rms) of it did not reach the plant, and of it",
                          error_text(noise->rms, model.input_unit));
    found.push_back(fmt::format(
        "{} the model makes {} (rms) of error, which hides whatever else it lacks. A gain comes out too small by that, "
        "here by about {}, and time constants are off by as much or more; record the command itself as the input, or "
        "{}.",
        fault, error_text(noise->in_output, model.output_unit),
        noise->attenuation < 0.001 ? "0.1 % or less" : fmt::format("{:.1g} %", 100.0 * noise->attenuation),
        is_coarse ? "in a smaller range of the instrument or with more bits"
                  : "filter and shield the wiring of the measured one"));
  }
  if (const auto& sensor = model.validation->sensor_step) {
    found.push_back(fmt::format(
        "The sensor's step of {} limits the answer: rounding to it makes {} of what the model leaves over, and a "
        "motion within a step does not show; amplify the sensor's signal or take a finer one, or record larger "
        "motions.",
        error_text(sensor->step, model.output_unit), rounding_makes_most(model) ? "most" : "much"));
  }
  if (const auto change = model.provenance.find(kGainChanged); change != model.provenance.end()) {
    const auto cut = model.provenance.find(kBesideGainChange);
    found.push_back(fmt::format(
        "The gain changes {}: from there on the output is another multiple of the model's, as with another supply "
        "pressure, load or range of the sensor{}.",
        change->second, cut == model.provenance.end() ? std::string() : "; fit the parts apart: " + cut->second));
  }
  if (const auto& jump = model.validation->jump) {
    const CutBeside cut =
        cut_beside(*jump, model.estimation ? model.estimation->compared_step_s : std::optional<double>());
    found.push_back(fmt::format("The {}: {}; cut with {}.", jump_text(*jump, model.output_unit),
                                jump->until_s ? kMakesABurst : kMakesAJump,
                                is_given ? of_record->second : cut_options(cut)));
  }
  return found;
}

bool rounding_makes_most(const Model& model) {
  constexpr double kMost = 0.7;              // of the residual's power
  constexpr double kPowerOfStep = 1 / 12.0;  // of rounding to a step of 1
  if (!model.validation || !model.validation->sensor_step) return false;
  const double step = model.validation->sensor_step->step;
  return kPowerOfStep * step * step >= kMost * model.validation->score.mse;
}

std::string statement_of(const std::string& reason) {
  std::string statement = reason.substr(0, reason.find(';'));
  if (statement.ends_with('.')) statement.pop_back();
  return statement;
}

std::string in_few_words(const std::string& reason) {
  std::string words = statement_of(reason);
  const std::size_t begin = words.find(" (p = ");
  const std::size_t end = words.find(')', begin == std::string::npos ? words.size() : begin);
  if (end != std::string::npos) words.erase(begin, end + 1 - begin);
  return words + ".";
}

}  // namespace eha::ident
