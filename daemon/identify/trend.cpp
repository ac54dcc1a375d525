// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/identify/trend.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <limits>
#include <utility>

#include "core/display_unit.hpp"
#include "core/error.hpp"
#include "daemon/identify/thread_executor.hpp"
#include "ident/estimation/fit.hpp"
#include "ident/fractional/poles.hpp"
#include "ident/model/parameter_text.hpp"
#include "ident/signal/autoregression.hpp"
#include "ident/structure/structures.hpp"
#include "ident/uncertainty/covariance.hpp"
#include "ident/validation/error_cause.hpp"
#include "ident/validation/recommendation.hpp"
#include "ident/validation/slow_pair.hpp"
#include "ident/validation/verdict.hpp"
#include "ident/validation/verdict_phrases.hpp"

namespace eha::identify {
namespace {

constexpr int kMostRounds = 6;
constexpr double kStays = 0.02;          // of the interval's half width
constexpr double kLessThanModel = 0.7;   // of the error on unseen data, beside a model that is recommended
constexpr double kLessThanJump = 0.42;   // of the error: a line takes half of a jump away
constexpr double kShownOverWidth = 2.0;  // the line over that half width

/// Takes a line out of an output; it is 0 in the middle of the record.
void take_out(double per_s, ident::Record& record) {
  const double middle = 0.5 * static_cast<double>(record.output.size() - 1);
  for (Eigen::Index k = 0; k < record.output.size(); ++k) {
    record.output[k] -= per_s * record.step_s * (static_cast<double>(k) - middle);
  }
}

/// The slope of what is left over, beside a constant.
Trend slope_of(const Eigen::VectorXd& time_s, const Eigen::VectorXd& rest) {
  Eigen::MatrixXd columns(rest.size(), 2);
  columns.col(0).setOnes();
  columns.col(1) = time_s.array() - time_s.mean();
  Trend slope{columns.col(1).dot(rest) / columns.col(1).squaredNorm()};
  if (rest.size() <= 3 * ident::kHighestAutoregression) return slope;
  const Eigen::VectorXd left = rest.array() - rest.mean() - slope.per_s * columns.col(1).array();
  const ident::Autoregression noise = ident::autoregression(left);
  const Eigen::MatrixXd seen = ident::whitened(columns, noise);
  const Eigen::Matrix2d normal = seen.transpose() * seen;
  const double determinant = normal(0, 0) * normal(1, 1) - normal(0, 1) * normal(1, 0);
  if (determinant > 0.0) slope.half_width = ident::kInterval95 * std::sqrt(noise.variance * normal(0, 0) / determinant);
  return slope;
}

/// A plant of two poles, by all rows of a record. @param near  of a record that differs little; none: searched
ident::FitResult plant_of(const ident::Record& record, ident::FitOptions options,
                          const std::vector<ident::Model>& near) {
  ident::StructureOptions plant;
  plant.name = "io";
  plant.structure = ident::structures::io();
  options.split = 1.0;
  options.intervals = ident::IntervalMethod::straight;
  if (!near.empty()) options.search = ident::Search::known;
  return ident::fit(record, plant, options, thread_executor(), near);
}

bool is_drift(const IdentifiedModel& one) {
  const ident::Model& model = one.result.model;
  if (!model.verdict) return false;
  return ident::takes_in_a_drift(model) || (ident::wanders(model, *model.verdict) &&
                                            ident::error_cause(model, *model.verdict) == ident::ErrorCause::drift);
}

/// The time constant of the slowest pole of a model, infinite of an integrator [s].
double slowest_pole_s(const ident::Model& model) {
  const ident::Poles poles = ident::with_rounded_at_zero(ident::poles(model.transfer_function));
  if (poles.order_at_zero > 0.0) return std::numeric_limits<double>::infinity();
  double slowest_s = 0.0;
  for (const std::complex<double>& pole : poles.values) {
    slowest_s = std::max(slowest_s, std::pow(std::abs(pole), -1.0 / poles.base_order));
  }
  return slowest_s;
}

}  // namespace

std::optional<Trend> trend_of(const IdentificationTask& task) {
  ident::Record record = task.record;
  // Beside all of the drift the plant's slower pole would take it in, and no line would be left.
  Trend found = slope_of(Eigen::VectorXd::LinSpaced(record.output.size(), 0.0,
                                                    record.step_s * static_cast<double>(record.output.size() - 1)),
                         record.output);
  take_out(found.per_s, record);
  std::vector<ident::Model> near;
  try {
    for (int round = 0; round < kMostRounds; ++round) {
      const ident::FitResult fit = plant_of(record, task.options, near);
      near = {fit.model};
      const Trend more = slope_of(fit.time_s, fit.measured - fit.simulated);
      found = {found.per_s + more.per_s, more.half_width};
      take_out(more.per_s, record);
      if (std::abs(more.per_s) <= kStays * more.half_width) break;
    }
  } catch (const Error&) {
    return std::nullopt;
  }
  const bool is_shown = found.half_width > 0.0 && std::abs(found.per_s) > kShownOverWidth * found.half_width;
  return is_shown ? std::optional(found) : std::nullopt;
}

namespace {

/// The line as the model's file keeps it and as a user reads it.
struct TrendText {
  std::string line;   ///< in the record's unit
  std::string drift;  ///< "the output drifts by 3 mm over the record: a straight line of ... was taken out of it"
};

TrendText text_of(const Trend& trend, const ident::Record& record, const std::string& units) {
  const std::string& own_unit = record.output_channel.unit;
  const auto line = [&](double factor, const std::string& unit) {
    return fmt::format("{} +- {:.2g}{}/s", ident::rounded_to(factor * trend.per_s, factor * trend.half_width),
                       factor * trend.half_width, ident::after_number(unit));
  };
  const DisplayUnit shown(units);
  const double factor = shown.factor(own_unit);
  const double length_s = record.step_s * static_cast<double>(record.output.size() - 1);
  return {line(1.0, own_unit),
          fmt::format("the output drifts by {:.3g}{} over the record: a straight line of {} was taken out of it",
                      factor * trend.per_s * length_s, ident::after_number(shown.of(own_unit)),
                      line(factor, shown.of(own_unit)))};
}

constexpr const char* kCheckSensor = "the sensor, the supply or the temperature may have drifted: check them";

}  // namespace

std::string take_trend_out(Source& source) {
  const IdentificationTask task = task_of(source);
  const std::optional<Trend> trend = trend_of(task);
  if (!trend) return {};
  ident::Record straight = source.record;
  take_out(trend->per_s, straight);
  try {
    const ident::Model with = plant_of(source.record, task.options, {}).model;
    const ident::Model without = plant_of(straight, task.options, {with}).model;
    const double length_s = straight.step_s * static_cast<double>(straight.output.size() - 1);
    if (slowest_pole_s(without) > length_s || !with.estimation || !without.estimation ||
        !(without.estimation->score.mse < kLessThanJump * kLessThanJump * with.estimation->score.mse)) {
      return {};
    }
  } catch (const Error&) {
    return {};
  }
  source.record = std::move(straight);
  return fmt::format("{}; {}", text_of(*trend, source.record, source.units).drift, kCheckSensor);
}

std::optional<WithoutTrend> without_trend(const IdentificationTask& task, const Identification& identification,
                                          const FitTask& fit) {
  if (task.options.procedure == ident::Procedure::paper) return std::nullopt;
  const IdentifiedModel* best = recommended_model(identification);
  const bool may_drift = best != nullptr && best->result.model.verdict &&
                         ident::fails_any(*best->result.model.verdict, {ident::CriterionKind::residual_drift,
                                                                        ident::CriterionKind::error_over_estimating});
  // What a changed gain leaves over is no line.
  const auto has_changed = [](const IdentifiedModel& one) {
    return one.result.model.provenance.contains(ident::kGainChanged);
  };
  const std::vector<IdentifiedModel>& models = identification.models;
  if (best != nullptr ? has_changed(*best) : std::any_of(models.begin(), models.end(), has_changed)) {
    return std::nullopt;
  }
  if (best != nullptr && !may_drift && !ident::takes_in_a_drift(best->result.model)) return std::nullopt;
  if (!may_drift && std::none_of(identification.models.begin(), identification.models.end(), is_drift)) {
    return std::nullopt;
  }
  const std::optional<Trend> trend = trend_of(task);
  if (!trend) return std::nullopt;
  WithoutTrend found{.record = task.record, .trend = {}, .sentence = {}, .identification = {}};
  take_out(trend->per_s, found.record);
  const TrendText text = text_of(*trend, task.record, task.units);
  found.trend = text.line;
  found.sentence = fmt::format("{}, and the models describe the plant beside it; {}", text.drift, kCheckSensor);
  const double length_s = task.record.step_s * static_cast<double>(task.record.output.size() - 1);
  IdentificationTask straight = with_record(task, found.record);
  straight.trend = found.trend;
  straight.remarks.push_back(found.sentence);
  found.identification = fit(straight);
  const IdentifiedModel* anew = recommended_model(found.identification);
  if (anew == nullptr || ident::takes_in_a_drift(anew->result.model)) return std::nullopt;
  // A plant that integrates makes such a line of a constant input, and taking it out moves its null or bias.
  if (slowest_pole_s(anew->result.model) > length_s) return std::nullopt;
  // Beside a model that is accepted a line has to show clearly.
  const std::optional<double> error = may_drift ? ident::error_over(anew->result.model, best->result.model) : 0.0;
  if (!error || *error > kLessThanModel) return std::nullopt;
  return found;
}

}  // namespace eha::identify
