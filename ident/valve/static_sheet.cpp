// SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "core/error.hpp"
#include "ident/model/parameter_text.hpp"
#include "ident/valve/sheet_parts.hpp"

namespace eha::ident {
namespace {

constexpr double kBlock_s = 0.2;
/// Least difference of the means of a block's halves over its range; below it the command turns within the block. A
/// ramp has a half.
constexpr double kRampShare = 0.4;
constexpr double kFirstShare = 0.3;     // of the greatest speed; blocks beyond it give the first line
constexpr double kBeyondEdge_V = 0.05;  // beyond the edge and half a block's range: the line is straight there
/// Of the greatest opening. Below it an opening valve has not yet moved the cylinder's pressures from those of the
/// other direction, and the rod lags.
constexpr double kOpeningShare = 0.5;
constexpr double kLateOpeningShare = 0.8;
constexpr double kBeyondPlay = 1.3;
constexpr int kRounds = 8;
constexpr std::size_t kFewestBlocks = 8;
/// Creep: share of the dead band that is surely inside it, and requirements on a crossing.
constexpr double kInsideShare = 0.75;
constexpr double kShortestCrossing_s = 0.05;
constexpr double kFewestCrossings = 2.0;
constexpr int kCreepRounds = 3;
constexpr double kLeastNoise_in = 1e-6;
/// Standard deviations of the method's error with the present friction, leakage and pressures; pinned by
/// characterise_campaign_test.cpp on simulated rigs. The share of the edge's shift by creep grows with that shift: the
/// more a cylinder leaks, the faster its pressures in the dead band depart from those of the moving rod.
constexpr double kMethod_V = 0.0015;
constexpr double kMethodShareOfCreep_per_V = 3.0;
constexpr double kMostShareOfCreep = 0.4;
constexpr double kMethodGainShare = 0.004;
constexpr double kMethodHysteresis_V = 0.002;
constexpr double kLeastHysteresis_V = 0.01;

struct Block {
  double command_V = 0.0;
  double velocity_in_per_s = 0.0;
  double rise_V = 0.0;        ///< between the means of its halves
  double range_V = 0.0;       ///< highest less lowest command
  double since_turn_V = 0.0;  ///< travel of the command since its last turn
};

std::vector<Block> blocks_of(const Record& record, const SheetPlan& plan, double lag_s) {
  const auto rows = static_cast<Eigen::Index>(std::llround(kBlock_s / record.step_s));
  const auto lag = static_cast<Eigen::Index>(std::llround(lag_s / record.step_s));
  const Eigen::VectorXd time_s =
      record.step_s * (Eigen::VectorXd::LinSpaced(rows, 0.0, static_cast<double>(rows - 1)).array() -
                       0.5 * static_cast<double>(rows - 1))
                          .matrix();
  const Eigen::VectorXd weights = time_s / time_s.squaredNorm();
  std::vector<Block> blocks;
  double turn_V = 0.0;
  bool rises = true;
  const Eigen::Index end = std::min(plan.sweep_first + plan.sweep_rows, record.output.size());
  for (Eigen::Index k = std::max(plan.sweep_first, lag); k + rows <= end; k += rows) {
    const auto command = record.input.segment(k - lag, rows);
    Block block{.command_V = command.mean(),
                .velocity_in_per_s = weights.dot(record.output.segment(k, rows)),
                .rise_V = command.tail(rows / 2).mean() - command.head(rows / 2).mean(),
                .range_V = command.maxCoeff() - command.minCoeff()};
    if (blocks.empty() || (block.rise_V >= 0.0) != rises) {
      rises = block.rise_V >= 0.0;
      turn_V = rises ? command.minCoeff() : command.maxCoeff();
    }
    block.since_turn_V = std::abs(block.command_V - turn_V);
    if (std::abs(block.rise_V) >= kRampShare * block.range_V) blocks.push_back(block);
  }
  return blocks;
}

/// v = gain (x - edge - half_width s) of one direction, x and v turned so that they are positive.
struct Line {
  double gain = 0.0;
  double edge_V = 0.0;
  double half_width_V = 0.0;
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();  ///< of gain, edge, half width
  double highest_V = 0.0;
};

double opening_sign(const Block& block, double direction) { return direction * block.rise_V >= 0.0 ? 1.0 : -1.0; }

Line line_through(const std::vector<Block>& blocks, double direction) {
  Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
  Eigen::Vector3d right = Eigen::Vector3d::Zero();
  for (const Block& block : blocks) {
    const Eigen::Vector3d row(direction * block.command_V, -1.0, -opening_sign(block, direction));
    normal += row * row.transpose();
    right += row * direction * block.velocity_in_per_s;
  }
  const Eigen::Matrix3d inverse = normal.inverse();
  const Eigen::Vector3d solution = inverse * right;
  Line line{.gain = solution[0], .edge_V = solution[1] / solution[0], .half_width_V = solution[2] / solution[0]};
  double squares = 0.0;
  for (const Block& block : blocks) {
    const Eigen::Vector3d row(direction * block.command_V, -1.0, -opening_sign(block, direction));
    const double residual = direction * block.velocity_in_per_s - row.dot(solution);
    squares += residual * residual;
  }
  const double freedom = std::max(1.0, static_cast<double>(blocks.size()) - 3.0);
  Eigen::Matrix3d to_line;
  to_line << 1.0, 0.0, 0.0, -line.edge_V / line.gain, 1.0 / line.gain, 0.0, -line.half_width_V / line.gain, 0.0,
      1.0 / line.gain;
  line.covariance = to_line * (squares / freedom * inverse) * to_line.transpose();
  return line;
}

/// Both sweeps are needed to separate the hysteresis from the edge.
bool has_both_sweeps(const std::vector<Block>& blocks, double direction) {
  std::size_t opening = 0;
  for (const Block& block : blocks) opening += opening_sign(block, direction) > 0.0 ? 1 : 0;
  return blocks.size() >= kFewestBlocks && opening >= 2 && blocks.size() - opening >= 2;
}

[[noreturn]] void refuse(double direction, const std::string& why) {
  throw DataError(
      fmt::format("the record does not determine the valve: {} {}; check pressure, sign and range of the valve, and "
                  "give its dead band in [following] of the rig file, so that the measurement goes beyond it",
                  direction > 0.0 ? "extending" : "retracting", why));
}

Line measured_line(const std::vector<Block>& blocks, double direction, double opening_share) {
  double fastest = 0.0;
  double highest_V = -1e9;
  for (const Block& block : blocks) {
    fastest = std::max(fastest, direction * block.velocity_in_per_s);
    highest_V = std::max(highest_V, direction * block.command_V);
  }
  std::vector<Block> chosen;
  for (const Block& block : blocks) {
    if (direction * block.velocity_in_per_s > kFirstShare * fastest) chosen.push_back(block);
  }
  if (!has_both_sweeps(chosen, direction)) refuse(direction, "the rod hardly moved");
  Line line = line_through(chosen, direction);
  for (int round = 0; round < kRounds; ++round) {
    if (!(line.gain > 0.0) || line.edge_V >= highest_V) refuse(direction, "the motion does not follow the command");
    chosen.clear();
    for (const Block& block : blocks) {
      const double opening_V = direction * block.command_V - line.edge_V;
      const double least_V = kBeyondEdge_V + 0.5 * block.range_V;
      const bool settled =
          opening_sign(block, direction) < 0.0 || opening_V > opening_share * (highest_V - line.edge_V);
      // After each turn a valve with play does not move until the command has crossed the play.
      const bool follows =
          block.since_turn_V - 0.5 * block.range_V > kBeyondPlay * 2.0 * std::max(0.0, line.half_width_V);
      if (opening_V > least_V && settled && follows) chosen.push_back(block);
    }
    if (!has_both_sweeps(chosen, direction)) refuse(direction, "the rod hardly moved beyond the dead band");
    line = line_through(chosen, direction);
  }
  line.highest_V = highest_V;
  return line;
}

/// With what the edge moves by where less of the opening valve's way counts, as variance: of soft oil, or of oil with
/// air, the pressures follow so late that the rod lags beyond kOpeningShare, too.
Line settled_line(const std::vector<Block>& blocks, double direction) {
  Line line = measured_line(blocks, direction, kOpeningShare);
  try {
    const double moved_V = measured_line(blocks, direction, kLateOpeningShare).edge_V - line.edge_V;
    line.covariance(1, 1) += moved_V * moved_V;
  } catch (const DataError&) {  // too little is left: nothing more is known
  }
  return line;
}

double half_width_of(double variance, double method) { return kInterval95 * std::sqrt(variance + method * method); }

/// Speed inside the dead band after the rod has moved in a direction: the leakage at the pressures of that direction.
struct Creep {
  double weight = 0.0;  ///< 1 / variance, without the scatter
  double sum = 0.0;
  double squares = 0.0;
  double crossings = 0.0;

  [[nodiscard]] bool is_known() const { return crossings >= kFewestCrossings; }
  [[nodiscard]] double mean() const { return sum / weight; }
  [[nodiscard]] double variance() const {
    const double scatter = std::max(0.0, squares / weight - mean() * mean()) / (crossings - 1.0);
    return std::max(1.0 / weight, scatter);
  }
};

/// Speed over rows by least squares, and its variance due to the sensor's noise.
void add_crossing(const Record& record, Eigen::Index first, Eigen::Index rows, double noise, Creep& creep) {
  const Eigen::ArrayXd time_s = record.step_s * (Eigen::ArrayXd::LinSpaced(rows, 0.0, static_cast<double>(rows - 1)) -
                                                 0.5 * static_cast<double>(rows - 1));
  const double spread = time_s.square().sum();
  const double speed = (time_s * record.output.segment(first, rows).array()).sum() / spread;
  const double weight = spread / (noise * noise);
  creep.weight += weight;
  creep.sum += weight * speed;
  creep.squares += weight * speed * speed;
  creep.crossings += 1.0;
}

/// Returns the creep after extending and after retracting, from the crossings of the dead band that begin and end
/// outside it.
std::array<Creep, 2> creeps_in(const Record& record, const SheetPlan& plan, double lag_s, const ValveSheet& sheet) {
  std::array<Creep, 2> creeps;
  const double noise = std::max(sheet.noise_in, kLeastNoise_in);
  const double inside_V = kInsideShare * sheet.dead_band_V.value;
  const auto lag = static_cast<Eigen::Index>(std::llround(lag_s / record.step_s));
  const auto fewest = static_cast<Eigen::Index>(std::llround(kShortestCrossing_s / record.step_s));
  const Eigen::Index end = plan.sweep_first + plan.sweep_rows;
  double side = 0.0;  // last side of the dead band of the command
  Eigen::Index first = 0;
  bool is_inside = false;
  for (Eigen::Index k = std::max(plan.sweep_first, lag); k < end; ++k) {
    const double off_V = record.input[k - lag] - sheet.null_V.value;
    if (std::abs(off_V) < inside_V) {
      if (!is_inside) first = k;
      is_inside = true;
      continue;
    }
    if (is_inside && side != 0.0 && off_V * side < 0.0 && k - first >= fewest) {
      add_crossing(record, first, k - first, noise, creeps[side > 0.0 ? 0 : 1]);
    }
    is_inside = false;
    if (std::abs(off_V) > sheet.dead_band_V.value) side = off_V > 0.0 ? 1.0 : -1.0;
  }
  return creeps;
}

/// A measured edge with its variance, corrected for creep, which adds to the valve's flow.
struct Edge {
  double at_V = 0.0;
  double variance = 0.0;
};

Edge edge_of(const Line& line, double direction, const Creep& creep) {
  Edge edge{.at_V = direction * line.edge_V, .variance = line.covariance(1, 1)};
  if (!creep.is_known()) return edge;
  const double moved_V = creep.mean() / line.gain;
  const double method_V = std::min(kMostShareOfCreep, kMethodShareOfCreep_per_V * std::abs(moved_V)) * moved_V;
  edge.at_V += moved_V;
  edge.variance += creep.variance() / (line.gain * line.gain) + method_V * method_V;
  return edge;
}

void set_edges(const Edge& upper, const Edge& lower, ValveSheet& sheet) {
  const double half_width_V = half_width_of(0.25 * (upper.variance + lower.variance), kMethod_V);
  sheet.null_V = {0.5 * (upper.at_V + lower.at_V), half_width_V};
  sheet.dead_band_V = {0.5 * (upper.at_V - lower.at_V), half_width_V};
}

}  // namespace

void measure_static_part(const Record& record, const SheetPlan& plan, double lag_s, ValveSheet& sheet) {
  const std::vector<Block> blocks = blocks_of(record, plan, lag_s);
  const Line up = settled_line(blocks, 1.0);
  const Line down = settled_line(blocks, -1.0);
  set_edges(edge_of(up, 1.0, {}), edge_of(down, -1.0, {}), sheet);
  std::array<Creep, 2> creeps;
  for (int round = 0; round < kCreepRounds; ++round) {
    creeps = creeps_in(record, plan, lag_s, sheet);
    set_edges(edge_of(up, 1.0, creeps[0]), edge_of(down, -1.0, creeps[1]), sheet);
  }
  sheet.gain_positive_in_per_V_s = {up.gain, half_width_of(up.covariance(0, 0), kMethodGainShare * up.gain)};
  sheet.gain_negative_in_per_V_s = {down.gain, half_width_of(down.covariance(0, 0), kMethodGainShare * down.gain)};
  sheet.hysteresis_V = {up.half_width_V + down.half_width_V,
                        half_width_of(up.covariance(2, 2) + down.covariance(2, 2), kMethodHysteresis_V)};
  sheet.has_hysteresis = sheet.hysteresis_V.value > std::max(kLeastHysteresis_V, sheet.hysteresis_V.half_width);

  sheet.creep_in_per_s.reset();
  if (creeps[0].is_known() && creeps[1].is_known()) {
    sheet.creep_in_per_s = Measured{0.5 * (creeps[0].mean() + creeps[1].mean()),
                                    kInterval95 * 0.5 * std::sqrt(creeps[0].variance() + creeps[1].variance())};
  }
  sheet.block_V.resize(static_cast<Eigen::Index>(blocks.size()));
  sheet.block_in_per_s.resize(sheet.block_V.size());
  for (Eigen::Index i = 0; i < sheet.block_V.size(); ++i) {
    sheet.block_V[i] = blocks[static_cast<std::size_t>(i)].command_V;
    sheet.block_in_per_s[i] = blocks[static_cast<std::size_t>(i)].velocity_in_per_s;
  }
}

double noise_at_rest(const Record& record, const SheetPlan& plan) {
  const Eigen::Index first = plan.rest_rows / 4;  // the ramp to the null has ended
  const Eigen::Index rows = std::min(plan.rest_rows, record.output.size()) - first;
  if (rows < 10) return 0.0;
  const Eigen::ArrayXd t = Eigen::ArrayXd::LinSpaced(rows, -1.0, 1.0);
  Eigen::MatrixX3d basis(rows, 3);
  basis << Eigen::VectorXd::Ones(rows), t.matrix(), t.square().matrix();
  const Eigen::VectorXd y = record.output.segment(first, rows);
  const Eigen::Vector3d parabola = (basis.transpose() * basis).inverse() * (basis.transpose() * y);
  return std::sqrt((y - basis * parabola).squaredNorm() / static_cast<double>(rows - 3));
}

ValveSheet valve_sheet(const Record& record, const SheetPlan& plan) {
  if (record.output.size() < plan.sweep_first + plan.sweep_rows || record.input.size() != record.output.size()) {
    throw DataError(fmt::format("the record has {} rows, the valve sheet needs {}; repeat it", record.output.size(),
                                plan.table_V.size()));
  }
  constexpr double kUsualLag_s = 0.01;
  ValveSheet sheet;
  sheet.lag_s = kUsualLag_s;
  sheet.noise_in = noise_at_rest(record, plan);
  measure_static_part(record, plan, sheet.lag_s, sheet);
  measure_dynamic_part(record, plan, sheet);
  // An error of the lag times half the triangle's slope would appear as hysteresis.
  if (std::abs(sheet.lag_s - kUsualLag_s) > 0.5 * record.step_s) measure_static_part(record, plan, sheet.lag_s, sheet);
  return sheet;
}

}  // namespace eha::ident
