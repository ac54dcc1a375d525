// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/identify/compared_records.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "ident/validation/verdict_phrases.hpp"

namespace eha::identify {
namespace {

constexpr double kSameStep = 1e-6;
constexpr double kEnough = 0.5;  // of the time that estimated a model without a valve map

}  // namespace

std::string too_short(double record_s, double model_s, const std::string& of) {
  if (!(record_s < kEnough * model_s)) return {};
  return fmt::format(
      "{:.3g} s are less than half of the {:.3g} s of {}, and without a valve map each stretch of a motion has a model "
      "of its own; record {:.3g} s or more with the same experiment",
      record_s, model_s, of, std::ceil(model_s));
}

ident::FitOptions whole(ident::FitOptions options) {
  options.procedure = ident::Procedure::standard;
  options.intervals = ident::IntervalMethod::straight;
  options.split = 1.0;
  return options;
}

ident::FitOptions options_of(const Source& source) {
  ident::FitOptions options = whole(source.experiment ? source.experiment->fit : ident::FitOptions{});
  options.decimation *= source.record.parts;
  return options;
}

ident::FitProgress part_of(const Progress& progress, std::size_t nth, std::size_t count, const std::string& of) {
  if (!progress) return {};
  return [progress, nth, count, of](double share, const std::string& structure) {
    progress((static_cast<double>(nth) + share) / static_cast<double>(count),
             fmt::format("fitting {} to {}", structure, of));
  };
}

int times(double step_s, double of_s) {
  const double ratio = step_s / of_s;
  const double whole = std::round(ratio);
  return whole >= 1.0 && std::abs(ratio - whole) <= kSameStep * ratio ? static_cast<int>(whole) : 0;
}

bool has_other_input(const ident::Record& a, const ident::Record& b) {
  const double step_s = std::max(a.step_s, b.step_s);
  const Eigen::Index every_a = times(step_s, a.step_s);
  const Eigen::Index every_b = times(step_s, b.step_s);
  if (every_a == 0 || every_b == 0) return false;
  const Eigen::Index shared = std::min(a.input.size() / every_a, b.input.size() / every_b);
  double moved = 0.0;
  for (Eigen::Index i = 0; i < shared; ++i) {
    moved = std::max(moved, std::abs(a.input[i * every_a] - b.input[i * every_b]));
  }
  return moved > 0.05 * a.input.cwiseAbs().maxCoeff();
}

bool holds_for_other_inputs(const ident::Model& before, const ident::Model& after, const ident::PlantChange& change) {
  if (!ident::leaves_plain_noise(before) || !ident::leaves_plain_noise(after)) return false;
  return !change.changed || std::any_of(change.parameters.begin(), change.parameters.end(), [](const auto& p) {
    return p.changed && std::abs(p.after - p.before) > kShiftByExperiment * p.half_width;
  });
}

bool explains_valve(double shift, const ident::PlantChange& change) {
  double greatest = 0.0;
  for (const ident::ParameterChange& p : change.parameters) {
    if (p.changed && ident::is_of_dead_zone(p.role)) greatest = std::max(greatest, std::abs(p.after - p.before));
  }
  return greatest > 0.0 && greatest <= shift;
}

}  // namespace eha::identify
