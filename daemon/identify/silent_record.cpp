// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/identify/silent_record.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "ident/model/parameter_text.hpp"

namespace eha::identify {
namespace {

constexpr double kAnswers_percent = 50.0;  // of R2
constexpr double kHardly = 0.05;           // of the range or the motion that it is compared with

double rms_about_mean(const Eigen::VectorXd& values) {
  if (values.size() == 0) return 0.0;
  return std::sqrt((values.array() - values.mean()).square().mean());
}

/// Why an input moves nothing; empty where it does.
std::string why_input_is_silent(const ident::Model& model, const Eigen::VectorXd& input) {
  const double lowest = input.minCoeff();
  const double highest = input.maxCoeff();
  const std::string unit = ident::after_number(model.input_unit);
  const std::string goes = fmt::format("the input goes from {:.3g} to {:.3g}{} only", lowest, highest, unit);
  if (const auto& map = model.input_map) {
    const double from = map->null - map->dead_band;
    const double to = map->null + map->dead_band;
    if (lowest >= from && highest <= to) {
      return fmt::format("{}, within the dead band of the model, from {:.3g} to {:.3g}{}", goes, from, to, unit);
    }
  }
  if (!model.estimation || !model.estimation->input_range) return {};
  const auto [least, greatest] = *model.estimation->input_range;
  if (highest - lowest >= kHardly * (greatest - least)) return {};
  return fmt::format("{}, and that which estimated the model from {:.3g} to {:.3g}{}", goes, least, greatest, unit);
}

/// Whether a gain is shown to have the other sign.
bool moves_the_other_way(const ScoredModel& scored) {
  // Of a structure that does not fit the record the sign is chance.
  const bool refit_follows = scored.refit && scored.refit->model.estimation &&
                             scored.refit->model.estimation->score.r2_percent > kAnswers_percent;
  if (!scored.change || !refit_follows) return false;
  const auto& all = scored.change->parameters;
  return std::any_of(all.begin(), all.end(), [](const ident::ParameterChange& p) {
    return p.role == ident::ParameterRole::numerator_coefficient && p.changed && p.before * p.after < 0.0 &&
           std::abs(p.after) > kHardly * std::abs(p.before);
  });
}

}  // namespace

std::string why_silent(const ident::Model& model, const ident::Record& record, const ScoredModel& scored, double factor,
                       const std::string& unit) {
  const ident::Score& score = scored.validation.offset_reestimated.value_or(scored.validation.score);
  if (score.r2_percent > kAnswers_percent || record.input.size() == 0) return {};
  if (const std::string why = why_input_is_silent(model, record.input); !why.empty()) {
    return fmt::format(
        "The record cannot judge the model: {}; record an input of the model's size, and look whether the column is "
        "that of the input",
        why);
  }
  const double moves = rms_about_mean(scored.output.measured);
  const double due = rms_about_mean(scored.output.simulated);
  if (moves < kHardly * due) {
    return fmt::format(
        "The output stands ({:.2g}{} rms) where the model moves by {:.2g}{} rms: look at the sensor, the supply and "
        "the valve's plug, and whether the columns are the right ones; of the plant's parameters this record says "
        "nothing",
        factor * moves, unit, factor * due, unit);
  }
  if (moves_the_other_way(scored)) {
    return "The output moves the other way than the model's: input or output is connected the other way round, or "
           "recorded with the other sign; turn the sign of one of them and validate again";
  }
  return {};
}

}  // namespace eha::identify
