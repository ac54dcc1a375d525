// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/identify/shaped_record_trial.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/error.hpp"
#include "core/time_text.hpp"
#include "ident/estimation/fit.hpp"
#include "ident/estimation/prepared_record.hpp"
#include "ident/model/parameter_text.hpp"
#include "ident/record.hpp"
#include "ident/validation/recommendation.hpp"

namespace eha::identify {
namespace {

constexpr double kClosest = 0.02;                          // of a gap between levels of the input
constexpr std::array kClipped{0.03, 0.1, 0.2, 0.35, 0.5};  // shares of the rows whose input lies beyond a limit
constexpr std::array kPowers{0.4, 0.5, 0.65, 0.8, 1.25, 1.5, 2.0, 2.5};
constexpr std::array kPowerSteps{1.12, 1.06, 1.03, 1.015};
constexpr double kLeastBend = 0.1;  // of the logarithm of a power: below, the gain is hardly curved

/// The input between limits of one size about its mid-range.
Eigen::VectorXd clipped(const Eigen::VectorXd& input, double middle, double limit) {
  return (input.array() - middle).cwiseMax(-limit).cwiseMin(limit) + middle;
}

/// "--from 12.5 --to 48.2": the longest part of a record whose input stays between limits of one size about its
/// mid-range, if that is a fifth of the record and long enough for a fit; empty otherwise.
/// @param parts  rows of the record for one of the file's
std::string part_within(const ident::Record& record, double middle, double limit, Eigen::Index parts) {
  constexpr double kLongEnough = 0.2;
  constexpr Eigen::Index kFewestRows = 300;
  Eigen::Index first = 0;
  Eigen::Index longest = 0;
  for (Eigen::Index k = 0, begun = 0; k < record.input.size(); ++k) {
    if (!(std::abs(record.input[k] - middle) <= limit)) begun = k + 1;
    if (k + 1 - begun > longest) {
      longest = k + 1 - begun;
      first = begun;
    }
  }
  const Eigen::Index rows = record.input.size();
  if (longest < kFewestRows * parts || static_cast<double>(longest) < kLongEnough * static_cast<double>(rows))
    return {};
  const auto time_of = [&](Eigen::Index row) {
    return time_text(record.start_s + static_cast<double>(row) * record.step_s);
  };
  std::string options = first > 0 ? "--from " + time_of(first) : "";
  if (first + longest < rows) options += (options.empty() ? "--to " : " --to ") + time_of(first + longest - 1);
  return options;
}

/// The sizes of an input nearest to a limit.
struct InputGap {
  double lower = 0.0;
  double upper = 0.0;
  bool is_wide = false;  ///< the input has few levels: it has nothing near the limit
};

/// @param sizes  rising
InputGap gap_around(const std::vector<double>& sizes, double limit) {
  constexpr double kSame = 1e-3;  // of the greatest: noise of a measured level
  constexpr double kWide = 0.1;   // of it
  const double same = kSame * sizes.back();
  const auto below = std::lower_bound(sizes.begin(), sizes.end(), limit - same);
  const auto above = std::upper_bound(sizes.begin(), sizes.end(), limit + same);
  InputGap gap{below == sizes.begin() ? 0.0 : *(below - 1), above == sizes.end() ? sizes.back() : *above};
  gap.is_wide = gap.upper - gap.lower > kWide * sizes.back();
  return gap;
}

/// The structures that may describe a plant behind another input: that of an accepted first model, and the same behind
/// a valve, else the simple ones of the table.
std::vector<const IdentifiedModel*> simple_structures(const Identification& identification, const ident::Model& first) {
  constexpr std::array<std::string_view, 3> kSimple{"integrator_lag", "io1", "io"};
  std::vector<const IdentifiedModel*> found;
  for (const IdentifiedModel& one : identification.models) {
    const bool is_first = &one.result.model == &first;
    const bool is_simple = std::find(kSimple.begin(), kSimple.end(), one.structure.name) != kSimple.end();
    const bool is_behind_valve = one.structure.name == first.name + "_valve";
    if (first.verdict->accepted ? is_first || is_behind_valve : is_simple) found.push_back(&one);
  }
  return found;
}

/// Fits structures to one shape of a record after another, and keeps what errs least.
class ShapedRecord {
 public:
  ShapedRecord(const IdentificationTask& task, std::vector<const IdentifiedModel*> bases)
      : task_(task), bases_(std::move(bases)) {}

  /// Whether it errs less than each shape before.
  bool take_input(Eigen::VectorXd input) {
    ident::Record record = task_.record;
    record.input = std::move(input);
    return take(record);
  }

  bool take(const ident::Record& record) {
    const IdentificationTask shaped = with_record(task_, record);
    const ident::PreparedRecord prepared(record, task_.options);
    bool is_better = false;
    for (const IdentifiedModel* base : bases_) {
      std::optional<ident::Model> model =
          fit_that_holds(shaped, prepared, base->structure, {ident::Search::nearest, {base->result.model}});
      if (!model || (best_ && !(ident::shown_mse(*model) < ident::shown_mse(*best_)))) continue;
      best_ = std::move(model);
      base_ = base;
      is_better = true;
    }
    return is_better;
  }

  /// Goes on with the structure that errs least; false where it does not err clearly less than without a shape.
  bool keep_best_structure() {
    const std::optional<double> over =
        best_ && base_ != nullptr ? ident::error_over(*best_, base_->result.model) : std::nullopt;
    if (!over || *over > kClearlyLess) return false;
    bases_ = {base_};
    return true;
  }

  [[nodiscard]] const ident::Model* best_so_far() const { return best_ ? &*best_ : nullptr; }
  ident::Model best() && { return std::move(*best_); }

 private:
  const IdentificationTask& task_;
  std::vector<const IdentifiedModel*> bases_;
  std::optional<ident::Model> best_ = {};
  const IdentifiedModel* base_ = nullptr;
};

/// sign(u) |u|^power, as large as the input at its greatest.
Eigen::VectorXd powered(const Eigen::VectorXd& input, double power) {
  const double greatest = input.cwiseAbs().maxCoeff();
  return input.unaryExpr(
      [&](double u) { return std::copysign(greatest * std::pow(std::abs(u) / greatest, power), u); });
}

/// What is behind a play of a width: it stands while its drive is within the gap.
Eigen::VectorXd behind_play(const Eigen::VectorXd& drive, double width) {
  Eigen::VectorXd moved = drive;
  for (Eigen::Index k = 1; k < drive.size(); ++k) {
    moved[k] = std::clamp(moved[k - 1], drive[k] - 0.5 * width, drive[k] + 0.5 * width);
  }
  return moved;
}

/// A record's output with the play taken out that its sensor has beside a model's output: to first order.
std::optional<ident::Record> without_play(const ident::Record& record, const ident::Model& model, double width,
                                          ident::FitOptions options) {
  options.decimation = 1;
  try {
    const ident::OutputOfModel output = ident::output_of(model, record, options);
    if (output.simulated.size() > record.output.size()) return std::nullopt;
    ident::Record corrected = record;
    // The rows before the first compared one are left as they are.
    corrected.output.tail(output.simulated.size()) += output.simulated - behind_play(output.simulated, width);
    return corrected;
  } catch (const Error&) {
    return std::nullopt;
  }
}

constexpr std::array kPlays{0.003, 0.006, 0.012, 0.025, 0.05, 0.1};  // of the range of what drives it
constexpr std::array kPlaySteps{1.5, 1.25, 1.12, 1.06};

constexpr double kMostWithPlay = 0.7;  // of the error on unseen data

double range_of(const Eigen::VectorXd& values) { return values.maxCoeff() - values.minCoeff(); }

/// The width of a play that errs least; 0 where none errs clearly less than none.
template <typename Take>
double play_that_errs_least(ShapedRecord& shaped, double range, const Take& take_width) {
  double best = 0.0;
  const auto take = [&](double width) {
    if (take_width(width)) best = width;
  };
  for (const double share : kPlays) take(share * range);
  if (!shaped.keep_best_structure()) return 0.0;
  for (const double factor : kPlaySteps) {
    const double found = best;
    take(found / factor);
    take(found * factor);
  }
  return best;
}

}  // namespace

std::optional<Trial> trial_of_play(const IdentificationTask& task, const Identification& identification,
                                   const ident::Model& first) {
  const std::vector<const IdentifiedModel*> bases = simple_structures(identification, first);
  const ident::Record& record = task.record;
  ShapedRecord at_input(task, bases);
  const double of_input = play_that_errs_least(at_input, range_of(record.input), [&](double width) {
    return at_input.take_input(behind_play(record.input, width));
  });
  ShapedRecord at_output(task, bases);
  const double of_output = play_that_errs_least(at_output, range_of(record.output), [&](double width) {
    const ident::Model& beside = at_output.best_so_far() != nullptr ? *at_output.best_so_far() : first;
    const auto corrected = without_play(record, beside, width, task.options);
    return corrected && at_output.take(*corrected);
  });
  if (!(of_input > 0.0) && !(of_output > 0.0)) return std::nullopt;
  const bool is_of_input = of_input > 0.0 && (!(of_output > 0.0) || ident::shown_mse(*at_input.best_so_far()) <
                                                                        ident::shown_mse(*at_output.best_so_far()));
  const std::optional<double> over = ident::error_over(*(is_of_input ? at_input : at_output).best_so_far(), first);
  if (!over || *over > kMostWithPlay) return std::nullopt;
  const ident::Channel& channel = is_of_input ? record.input_channel : record.output_channel;
  const std::string width =
      fmt::format("{:.2g}{}", is_of_input ? of_input : of_output, ident::after_number(channel.unit));
  return Trial{std::move(is_of_input ? at_input : at_output).best(),
               {.kind = ident::ExplanationKind::play,
                .has = width + (is_of_input ? " between the input and the plant" : " between the plant and its sensor"),
                .options = {}}};
}

std::optional<Trial> trial_of_saturation(const IdentificationTask& task, const Identification& identification,
                                         const ident::Model& first) {
  const Eigen::VectorXd& input = task.record.input;
  const bool is_two_sided = input.minCoeff() < 0.0 && input.maxCoeff() > 0.0;
  const double middle = is_two_sided ? 0.0 : 0.5 * (input.minCoeff() + input.maxCoeff());
  std::vector<double> sizes(static_cast<std::size_t>(input.size()));
  for (std::size_t k = 0; k < sizes.size(); ++k) sizes[k] = std::abs(input[static_cast<Eigen::Index>(k)] - middle);
  std::sort(sizes.begin(), sizes.end());
  const auto limit_at = [&](double share) {
    const auto at = static_cast<std::size_t>((1.0 - share) * static_cast<double>(sizes.size() - 1));
    return sizes[at];
  };
  ShapedRecord shaped(task, simple_structures(identification, first));
  double best_share = 0.0;
  double best_limit = 0.0;
  const auto take_limit = [&](double limit) {
    if (!shaped.take_input(clipped(input, middle, limit))) return false;
    best_limit = limit;
    return true;
  };
  const auto take = [&](double share) {
    if (take_limit(limit_at(share))) best_share = share;
  };
  for (const double share : kClipped) {
    if (limit_at(share) < sizes.back()) take(share);
  }
  if (!shaped.keep_best_structure()) return std::nullopt;
  for (const double factor : {1.7, 1.3, 1.1}) {
    const double found = best_share;
    take(found / factor);
    take(std::min(0.9, factor * found));
  }
  // Of an input of few levels the limit lies between two of them.
  const InputGap beside = gap_around(sizes, best_limit);
  if (beside.is_wide) {
    for (double step = 0.5; step > kClosest; step *= 0.5) {
      const double found = best_limit;
      take_limit(found - step * (found - beside.lower));
      take_limit(found + step * (beside.upper - found));
    }
  }
  const InputGap gap = gap_around(sizes, best_limit);
  const std::string unit = ident::after_number(task.record.input_channel.unit);
  const double limit = best_limit;
  const std::string between =
      beside.is_wide && is_two_sided
          ? fmt::format(" (between its levels of {:.3g} and {:.3g}{})", gap.lower, gap.upper, unit)
          : std::string();
  const std::string limits = is_two_sided ? fmt::format("+-{:.2g}{}{}", limit, unit, between)
                                          : fmt::format("{:.2g} and {:.2g}{}", middle - limit, middle + limit, unit);
  return Trial{std::move(shaped).best(),
               {.kind = ident::ExplanationKind::limit,
                .has = limits,
                .options = part_within(task.record, middle, limit, task.record.parts)}};
}

std::optional<Trial> trial_of_power(const IdentificationTask& task, const Identification& identification,
                                    const ident::Model& first) {
  const Eigen::VectorXd& input = task.record.input;
  if (!(input.cwiseAbs().maxCoeff() > 0.0)) return std::nullopt;
  ShapedRecord shaped(task, simple_structures(identification, first));
  double best_power = 1.0;
  const auto take = [&](double power) {
    if (shaped.take_input(powered(input, power))) best_power = power;
  };
  for (const double power : kPowers) take(power);
  if (!shaped.keep_best_structure()) return std::nullopt;
  for (const double factor : kPowerSteps) {
    const double found = best_power;
    take(found / factor);
    take(found * factor);
  }
  if (std::abs(std::log(best_power)) < kLeastBend) return std::nullopt;
  return Trial{std::move(shaped).best(),
               {.kind = ident::ExplanationKind::power, .has = fmt::format("{:.2g}", best_power), .options = {}}};
}

}  // namespace eha::identify
