// SPDX-License-Identifier: GPL-3.0-or-later
#include "ident/validation/map_error.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "ident/fractional/stability.hpp"
#include "ident/linear_algebra/least_squares_solvers.hpp"
#include "ident/model/parameter_text.hpp"
#include "ident/signal/autoregression.hpp"
#include "ident/validation/verdict_phrases.hpp"

namespace eha::ident {
namespace {

using Index = Eigen::Index;

constexpr Index kFewestCompared = 60;
constexpr double kRankThreshold = 1e-13;
constexpr Index kParts = 4;  // of the input, beside the edges
constexpr int kWhitenings = 2;
constexpr double kFarthestShift = 0.5 * static_cast<double>(kParts);  // dead bands that the parts reach from the null
constexpr double kStandardErrors = 2.0;                               // by which a constant differs from 0 by chance

/// Least-squares coefficients of columns, and their standard errors.
struct Regression {
  Eigen::VectorXd values;
  Eigen::VectorXd stds;
};

/// None where the columns depend on one another.
std::optional<Regression> regression(const Eigen::MatrixXd& columns, const Eigen::VectorXd& y) {
  const Eigen::RowVectorXd sizes = columns.colwise().norm();
  if (!(sizes.minCoeff() > 0.0)) return std::nullopt;
  const Eigen::MatrixXd scaled = columns.array().rowwise() / sizes.array();
  Eigen::MatrixXd basis;
  Regression found{solve_ranked(scaled, y, kRankThreshold, &basis), {}};
  if (basis.cols() < columns.cols()) return std::nullopt;
  const double variance =
      (y - scaled * found.values).squaredNorm() / static_cast<double>(columns.rows() - columns.cols());
  const Eigen::MatrixXd normal = scaled.transpose() * scaled;
  found.stds.resize(columns.cols());
  for (Index k = 0; k < columns.cols(); ++k) {
    const double inverse = solve_symmetric(normal, Eigen::VectorXd::Unit(columns.cols(), k))[k];
    found.stds[k] = std::sqrt(std::max(0.0, variance * inverse)) / sizes[k];
  }
  found.values = found.values.cwiseQuotient(sizes.transpose());
  return found;
}

/// How far null and dead band may be off [input unit]; 0 where nothing is known.
double shift_of(const Model& model) {
  if (!model.input_map || !model.validation) return 0.0;
  // Farther from the null the rod moves with the input, as it would not behind an edge that lay there.
  return std::min(kShiftOverMapError * model.validation->map_error.value_or(0.0),
                  kFarthestShift * model.input_map->dead_band);
}

bool is_doubtful(const Model& model, double shift) {
  constexpr double kDoubtfulShare = 0.4;  // of the dead band
  return model.input_map && shift > kDoubtfulShare * model.input_map->dead_band;
}

}  // namespace

std::optional<double> map_error(const Model& model, OutputOnRecord& outputs, const Eigen::VectorXd& whole_residual) {
  if (!model.input_map || !(model.input_map->dead_band > 0.0) || grows(model.transfer_function)) return std::nullopt;
  const MeasuredRows& rows = outputs.measured_rows();
  const Eigen::VectorXd residual = rows.of(whole_residual);
  if (residual.size() < kFewestCompared) return std::nullopt;
  const ValveMap& map = *model.input_map;
  const Eigen::VectorXd& input = outputs.record().input;
  // The parts of the input count from two dead bands below the null; part -1 and kParts lie beyond.
  const Eigen::ArrayXd place = (input.array() - map.null) / map.dead_band + 0.5 * static_cast<double>(kParts);
  Eigen::MatrixXd columns(residual.size(), kParts + 5);
  Index next = 0;
  const auto add = [&](const Eigen::VectorXd& signal) {
    columns.col(next++) = rows.of(outputs.response(model.transfer_function, signal));
  };
  for (Index part = 0; part < kParts; ++part) {
    const auto from = static_cast<double>(part);
    add((place >= from && place < from + 1.0).cast<double>().matrix());
  }
  add((place < 0.0).cast<double>().matrix());
  add((place >= static_cast<double>(kParts)).cast<double>().matrix());
  add((input.array() - upper_edge(map)).cwiseMax(0.0).matrix());
  add((input.array() - lower_edge(map)).cwiseMin(0.0).matrix());
  columns.col(next) = Eigen::VectorXd::Ones(residual.size());
  std::optional<Regression> found = regression(columns, residual);
  // What wanders is judged by its changes: whitened as what these constants leave over.
  for (int round = 0; found && round < kWhitenings; ++round) {
    const Autoregression noise = autoregression(residual - columns * found->values);
    found = regression(whitened(columns, noise), whitened(residual, noise));
  }
  if (!found) return std::nullopt;
  double greatest = 0.0;
  for (Index part = 0; part < kParts; ++part) {
    greatest = std::max(greatest, std::abs(found->values[part]) - kStandardErrors * found->stds[part]);
  }
  return greatest;
}

bool is_one_way(const ValveMap& map) {
  constexpr double kShut = 0.05;  // of the other direction's gain
  const double ratio = std::abs(map.negative_gain_ratio);
  return ratio < kShut || ratio > 1.0 / kShut;
}

double reported_map_error(const Model& model) {
  if (model.input_map && is_one_way(*model.input_map)) return std::numeric_limits<double>::infinity();
  return model.validation ? model.validation->map_error.value_or(0.0) : 0.0;
}

std::optional<double> map_shift(const Model& model) {
  const double shift = shift_of(model);
  return is_doubtful(model, shift) ? std::optional(shift) : std::nullopt;
}

std::optional<double> noted_shift(const Model& model) {
  const double shift = shift_of(model);
  const bool is_noted = is_doubtful(model, shift) || (model.input_unit == "V" && shift > kNotedShift_V);
  return is_noted ? std::optional(shift) : std::nullopt;
}

const ParameterEstimate* unfound_dead_band(const Model& model) {
  if (!model.input_map) return nullptr;
  for (const ParameterEstimate& p : model.parameters) {
    if (p.role == ParameterRole::dead_band) return p.fixed || p.lower95 > 0.0 ? nullptr : &p;
  }
  return nullptr;
}

std::string map_note(const Model& model, SheetSays sheet) {
  if (const ParameterEstimate* p = unfound_dead_band(model)) {
    return fmt::format(
        "the record shows no dead band: the 95 % interval of half of it is {}; a controller takes null and dead band "
        "from the valve sheet (`eha characterise`)",
        interval_text(*p) + after_number(model.input_unit));
  }
  if (model.input_map && is_one_way(*model.input_map)) {
    const bool is_up = std::abs(model.input_map->negative_gain_ratio) < 1.0;
    return fmt::format(
        "the record moved the output in one direction only: of the dead band it shows the edge at {:.3g}{}, and null "
        "and half dead band of the fit are not the valve's",
        is_up ? upper_edge(*model.input_map) : lower_edge(*model.input_map), after_number(model.input_unit));
  }
  const std::optional<double> shift = noted_shift(model);
  if (!shift) return {};
  const std::string shift_text = fmt::format(
      "null and half dead band of the fit may be up to {:.2g}{} off the valve's, beside dry friction more, whatever "
      "their intervals say",
      *shift, after_number(model.input_unit));
  if (sheet == SheetSays::is_tight) {
    return "dry friction bends the edges of that dead band, as the rod moves within it and by the valve sheet nothing "
           "leaks: " +
           shift_text;
  }
  if (model.validation->jump) {
    return "the error jumps, which bends the edges of that dead band as a leak would: " + shift_text;
  }
  const auto box = model.provenance.find(kGreyBoxHolds);
  const bool integrates = model.stability && model.stability->integrator_order > 0.0;  // else it is of another kind
  if (box != model.provenance.end() && integrates) {
    return fmt::format("dry friction bends the edges of that dead band (`eha fit --model friction` {}): {}",
                       box->second, shift_text);
  }
  return "the rod moves within that dead band, as where oil leaks past the piston or friction bends the edges: " +
         shift_text;
}

}  // namespace eha::ident
