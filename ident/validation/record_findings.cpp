// SPDX-License-Identifier: GPL-3.0-or-later
#include "ident/validation/record_findings.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "core/time_text.hpp"
#include "ident/linear_algebra/least_squares_solvers.hpp"
#include "ident/model/parameter_text.hpp"
#include "ident/signal/most_moving_part.hpp"
#include "ident/signal/value_step.hpp"
#include "ident/statistics/robust.hpp"
#include "ident/validation/unanswered.hpp"

namespace eha::ident {
namespace {

using Eigen::Index;

constexpr Index kFewestRows = 60;
constexpr Index kShortestWindow = 5;
constexpr Index kWindows = 200;         // number of parts of a record
constexpr double kBandOfRange = 0.002;  // band of a rod on its end stop, of the range
constexpr double kBandOfNoise = 8.0;    // standard deviations, from least to greatest sample
constexpr double kWidestBand = 0.02;    // of the range
constexpr Index kFewestTouching = 3;    // rows at a known stop
constexpr double kAskedOverBand = 3.0;  // motion beyond the stop that the input demands
constexpr double kSameInput = 0.1;      // of the input's range
constexpr double kIntegrates = 0.6;     // R2 of the motion by the input
constexpr double kByPlace = 0.7;        // of what that leaves over, where the place tells of the motion, too
constexpr double kLeftShare = 0.3;      // of the rows, to the end of the record
constexpr double kInputGoesOn = 0.5;    // of the input's range, there
constexpr std::size_t kFewestWindows = 20;
constexpr std::size_t kFewestAlike = 3;
constexpr Index kJumpRows = 4;  // the filter of a decimation spreads a jump
constexpr Index kBesideJump = 25;
constexpr double kCutRows = 4.0;     // compared rows from a jump to where the record is cut
constexpr double kLeastPart = 0.05;  // of the record, to be fitted instead of it
constexpr double kCutOfTime = 0.01;  // of the time of a jump, where the rows' distance is not known
constexpr double kJumpOverUsual = 8.0;
constexpr double kLikeIt = 0.6;        // of the largest change
constexpr Index kMostJumps = 5;        // more are no loss here and there
constexpr double kJumpExplains = 0.8;  // of the error's variance beside it
constexpr double kTurnsBack = 0.005;   // of the range of the model's motion
constexpr Index kBesideTurn = 8;       // rows in which friction or play lets go behind a turn
constexpr std::size_t kFewestTurns = 3;
constexpr double kOverTurns = 2.0;  // times the greatest step at the other turns

/// Mean input, motion and first output of a few rows.
struct Window {
  double input = 0.0;
  double motion = 0.0;
  double place = 0.0;
};

/// Rows first .. last, at which the output stays at an extreme.
struct Stay {
  Index first = 0;
  Index last = 0;
  double side = 1.0;  ///< 1: the greatest value, -1: the least
};

double spread(const Eigen::Ref<const Eigen::VectorXd>& x) { return (x.array() - x.mean()).square().sum(); }

class Search {
 public:
  explicit Search(const ComparedRows& rows)
      : rows_(rows), window_(std::max(kShortestWindow, rows.measured.size() / kWindows)) {
    const Eigen::VectorXd& y = rows.measured;
    const double range = y.maxCoeff() - y.minCoeff();
    band_ = std::clamp(kBandOfNoise * noise(), kBandOfRange * range, kWidestBand * range);
    step_ = value_step({y.data(), static_cast<std::size_t>(y.size())});
    input_range_ = rows.input.maxCoeff() - rows.input.minCoeff();
    for (const double side : {1.0, -1.0}) {
      for (const Stay& stay : at_extreme(side, window_ + 1)) candidates_.push_back(stay);
    }
    for (Index k = 0; k + window_ < y.size(); k += window_) {
      const bool stands = std::any_of(candidates_.begin(), candidates_.end(),
                                      [&](const Stay& stay) { return k + window_ >= stay.first && k <= stay.last; });
      if (!stands) moving_.push_back(at(k));
    }
  }

  [[nodiscard]] std::optional<EndStop> found() const {
    if (!(band_ > 0.0) || !(input_range_ > 0.0)) return std::nullopt;
    std::vector<Stay> stays;
    for (const StandingRows& rows : unanswered(rows_, band_, window_)) stays.push_back({rows.first, rows.last, 0.0});
    const bool is_silent = !stays.empty();
    if (!is_silent && integrates()) {
      std::copy_if(candidates_.begin(), candidates_.end(), std::back_inserter(stays),
                   [&](const Stay& stay) { return is_held(stay); });
    }
    for (const double side : {1.0, -1.0}) {
      if (const auto stay = left_at(side); stays.empty() && stay) stays.push_back(*stay);
    }
    if (stays.empty()) return std::nullopt;
    if (!is_silent) add_touches(stays);
    std::sort(stays.begin(), stays.end(), [](const Stay& a, const Stay& b) { return a.first < b.first; });
    Index count = 0;
    for (const Stay& stay : stays) count += stay.last - stay.first + 1;
    const Stay& first = stays.front();
    const auto level = [&](const Stay& stay) {
      return rows_.measured.segment(stay.first, stay.last - stay.first + 1).mean();
    };
    EndStop stop;
    stop.level = level(first);
    stop.from_s = time(first.first);
    stop.does_not_answer = is_silent;
    if (is_silent && first.last + 1 < rows_.measured.size()) stop.to_s = time(first.last);
    stop.percent = 100.0 * static_cast<double>(count) / static_cast<double>(rows_.measured.size());
    const auto other =
        std::find_if(stays.begin(), stays.end(), [&](const Stay& s) { return s.side * first.side < 0.0; });
    if (other != stays.end()) stop.other = {level(*other), time(other->first)};
    // Without a stay, and without the way to it where nothing answers any more.
    std::vector<std::pair<std::size_t, std::size_t>> left_out;
    for (const Stay& stay : stays) {
      const Index from = is_silent ? answered_before(stay) : stay.first;
      left_out.emplace_back(static_cast<std::size_t>(from), static_cast<std::size_t>(stay.last));
    }
    const Eigen::VectorXd& y = rows_.measured;
    if (const auto part = most_moving_part({y.data(), static_cast<std::size_t>(y.size())}, left_out)) {
      const auto [begin, end] = *part;
      const bool is_long = static_cast<double>(end - begin) >= kLeastPart * static_cast<double>(y.size());
      if (is_long && begin > 0) stop.clean_from_s = time(static_cast<Index>(begin));
      if (is_long && end < static_cast<std::size_t>(y.size())) stop.clean_to_s = time(static_cast<Index>(end) - 1);
    }
    return stop;
  }

 private:
  /// The row before a stay from which on the output only goes on to its level, as it does by itself where the drive
  /// is gone; at most a tenth of the record before.
  [[nodiscard]] Index answered_before(const Stay& stay) const {
    const double level = rows_.measured.segment(stay.first, stay.last - stay.first + 1).mean();
    const auto distance = [&](Index k) { return std::abs(rows_.measured[k] - level); };
    const Index earliest = std::max<Index>(0, stay.first - rows_.measured.size() / 10);
    Index turn = stay.first;
    for (Index k = stay.first - 1; k >= earliest && distance(k) > distance(turn) - band_; --k) {
      if (distance(k) > distance(turn)) turn = k;
    }
    return std::max(earliest, turn - kShortestWindow);
  }

  /// Adds the shorter stays on a side whose stop is known.
  void add_touches(std::vector<Stay>& stays) const {
    const std::vector<Stay> known = stays;
    for (const double side : {1.0, -1.0}) {
      if (std::none_of(known.begin(), known.end(), [&](const Stay& stay) { return stay.side == side; })) continue;
      for (const Stay& touch : at_extreme(side, kFewestTouching)) {
        const bool is_known = std::any_of(known.begin(), known.end(), [&](const Stay& stay) {
          return stay.side == side && stay.first <= touch.last && touch.first <= stay.last;
        });
        if (!is_known) stays.push_back(touch);
      }
    }
  }

  [[nodiscard]] double time(Index k) const { return rows_.time_s[k]; }

  [[nodiscard]] Window at(Index k) const {
    return {rows_.input.segment(k, window_).mean(), rows_.measured[k + window_] - rows_.measured[k], rows_.measured[k]};
  }

  /// Standard deviation of the output about a line, in the quietest tenth of the windows.
  [[nodiscard]] double noise() const {
    const Eigen::VectorXd line = Eigen::VectorXd::LinSpaced(window_, -0.5, 0.5);
    std::vector<double> all;
    for (Index k = 0; k + window_ <= rows_.measured.size(); k += window_) {
      Eigen::VectorXd y = rows_.measured.segment(k, window_);
      y.array() -= y.mean();
      y -= line * (line.dot(y) / line.squaredNorm());
      all.push_back(std::sqrt(y.squaredNorm() / static_cast<double>(window_ - 2)));
    }
    const auto tenth = all.begin() + static_cast<std::ptrdiff_t>(all.size() / 10);
    std::nth_element(all.begin(), tenth, all.end());
    return *tenth;
  }

  /// Returns the stretches of at least so many rows at the greatest (side 1) or the least value.
  [[nodiscard]] std::vector<Stay> at_extreme(double side, Index fewest) const {
    std::vector<Stay> found;
    const Eigen::VectorXd y = side * rows_.measured;
    const double lowest = y.maxCoeff() - band_;
    for (Index k = 0; k < y.size();) {
      Index end = k;
      while (end < y.size() && y[end] >= lowest) ++end;
      if (end - k >= fewest) found.push_back({k, end - 1, side});
      k = std::max(end, k + 1);
    }
    return found;
  }

  /// Whether the motion follows the input in the rows that move, and not the place as well: a tank that runs empty does
  /// not integrate, and its bottom is no end stop.
  [[nodiscard]] bool integrates() const {
    if (moving_.size() < kFewestWindows) return false;
    const auto n = static_cast<Index>(moving_.size());
    Eigen::MatrixXd columns(n, 3);
    Eigen::VectorXd motion(n);
    for (Index i = 0; i < n; ++i) {
      const Window& w = moving_[static_cast<std::size_t>(i)];
      columns.row(i) << 1.0, w.input, w.place;
      motion[i] = w.motion;
    }
    const auto left_by = [&](Index count) -> double {
      const Eigen::MatrixXd used = columns.leftCols(count);
      return (motion - used * solve_pivoted(used, motion)).squaredNorm();
    };
    const double all = spread(motion);
    const double by_input = left_by(2);
    return all > 0.0 && by_input < (1.0 - kIntegrates) * all && left_by(3) >= kByPlace * by_input;
  }

  /// Returns the motion of other rows with this input; none if there are too few.
  [[nodiscard]] std::optional<double> usual_motion(double input) const {
    std::vector<double> motions;
    for (const Window& w : moving_) {
      if (std::abs(w.input - input) <= kSameInput * input_range_) motions.push_back(w.motion);
    }
    if (motions.size() < kFewestAlike) return std::nullopt;
    return median_of(std::move(motions));
  }

  /// Whether input and model demand a motion beyond the stop.
  [[nodiscard]] bool is_held(const Stay& stay) const {
    double asked = 0.0;
    double most = 0.0;
    for (Index k = stay.first; k + window_ <= stay.last; k += window_) {
      const auto motion = usual_motion(at(k).input);
      if (!motion) continue;
      asked = std::max(0.0, asked + stay.side * *motion);
      most = std::max(most, asked);
    }
    const Eigen::VectorXd model = stay.side * rows_.simulated.segment(stay.first, stay.last - stay.first + 1);
    double lowest = model[0];
    double beyond = 0.0;
    for (const double y : model) {
      lowest = std::min(lowest, y);
      beyond = std::max(beyond, y - lowest);
    }
    const double least = kAskedOverBand * std::max(band_, step_);
    return most > least && beyond > least;
  }

  /// Returns the last rows at the greatest (side 1) or the least value, where the output came there and stays, whatever
  /// the input does: a rod that moves for so short a part of the record that it does not show how it moves.
  [[nodiscard]] std::optional<Stay> left_at(double side) const {
    const Eigen::VectorXd y = side * rows_.measured;
    const double lowest = y.maxCoeff() - kWidestBand * (y.maxCoeff() - y.minCoeff());
    Index first = y.size();
    while (first > 0 && y[first - 1] >= lowest) --first;
    const Index count = y.size() - first;
    if (first < kShortestWindow || static_cast<double>(count) < kLeftShare * static_cast<double>(y.size())) {
      return std::nullopt;
    }
    // The input of the way there is the one that moved it.
    const auto u = rows_.input.tail(count - count / 4);
    if (u.maxCoeff() - u.minCoeff() < kInputGoesOn * input_range_) return std::nullopt;
    return Stay{first, y.size() - 1, side};
  }

  const ComparedRows& rows_;
  Index window_;
  double band_ = 0.0;
  double step_ = 0.0;  ///< of a coarse sensor, in which a motion does not show
  double input_range_ = 0.0;
  std::vector<Stay> candidates_;
  std::vector<Window> moving_;
};

/// The changes of an error over kJumpRows rows. Across rows that were not measured a slow error changes more: there it
/// is the change in the time of so many rows.
Eigen::VectorXd changes_of(const Eigen::VectorXd& e, const Eigen::VectorXd& time_s) {
  const Index count = e.size() - kJumpRows;
  const Eigen::VectorXd took_s = time_s.tail(count) - time_s.head(count);
  const double usual_s = median_of({took_s.begin(), took_s.end()});
  return (e.tail(count) - e.head(count)).array() * (usual_s / took_s.array().max(usual_s));
}

struct LastingStep {
  Index middle = 0;  ///< first row behind it
  double change = 0.0;
};

/// The step of an error whose change over kJumpRows is greatest from row `at`, if a level on each side of it explains
/// the error there.
std::optional<LastingStep> lasting_step(const Eigen::VectorXd& e, Index at) {
  const Index first = std::max<Index>(0, at + kJumpRows / 2 - kBesideJump);
  const Index last = std::min(e.size(), at + kJumpRows / 2 + kBesideJump);
  if (at + 1 - first < kShortestWindow || last - at - kJumpRows <= kShortestWindow) return std::nullopt;
  const auto left_over = [&](Index middle) {
    return spread(e.segment(first, middle - first)) + spread(e.segment(middle, last - middle));
  };
  // The change is as large from any of these rows on; one of them parts the error best.
  Index middle = at + 1;
  for (Index k = at + 2; k <= at + kJumpRows; ++k) {
    if (left_over(k) < left_over(middle)) middle = k;
  }
  if (!(left_over(middle) < (1.0 - kJumpExplains) * spread(e.segment(first, last - first)))) return std::nullopt;
  return LastingStep{middle, e.segment(middle, last - middle).mean() - e.segment(first, middle - first).mean()};
}

/// Rows first .. last, in which a motion turns back.
struct Turn {
  Index first = 0;
  Index last = 0;
};

std::vector<Turn> turns_of(const Eigen::VectorXd& motion) {
  const double least = kTurnsBack * (motion.maxCoeff() - motion.minCoeff());
  std::vector<Turn> turns;
  Index highest = 0;
  Index lowest = 0;
  double direction = 0.0;
  const auto note = [&](Index extreme, double to) {
    const auto is_there = [&](Index k) { return std::abs(motion[k] - motion[extreme]) <= least; };
    Turn turn{extreme, extreme};
    while (turn.first > 0 && is_there(turn.first - 1)) --turn.first;
    while (turn.last + 1 < motion.size() && is_there(turn.last + 1)) ++turn.last;
    if (direction != 0.0) turns.push_back(turn);
    direction = to;
  };
  for (Index k = 0; k < motion.size(); ++k) {
    if (motion[k] > motion[highest]) highest = k;
    if (motion[k] < motion[lowest]) lowest = k;
    if (direction >= 0.0 && motion[k] < motion[highest] - least) {
      note(highest, -1.0);
      lowest = k;
    } else if (direction <= 0.0 && motion[k] > motion[lowest] + least) {
      note(lowest, 1.0);
      highest = k;
    }
  }
  return turns;
}

/// The greatest step of the error at a turn, between the means of the rows on both sides.
double step_at(const Eigen::VectorXd& e, const Turn& turn) {
  double greatest = 0.0;
  const Index last = std::min(e.size() - kShortestWindow, turn.last + kBesideTurn);
  for (Index k = std::max(kShortestWindow, turn.first - kBesideTurn); k <= last; ++k) {
    const Index first = std::max<Index>(0, k - kBesideJump);
    const double before = e.segment(first, k - first).mean();
    greatest = std::max(greatest, std::abs(e.segment(k, std::min(kBesideJump, e.size() - k)).mean() - before));
  }
  return greatest;
}

/// Whether dry friction or play may make a step: the model's motion turns back there, and the step is not clearly
/// greater than those at the other turns.
bool is_of_a_turn(const LastingStep& step, const Eigen::VectorXd& e, const std::vector<Turn>& turns) {
  const auto lies_within = [&](const Turn& turn, Index margin) {
    return step.middle >= turn.first - margin && step.middle <= turn.last + margin;
  };
  if (std::none_of(turns.begin(), turns.end(), [&](const Turn& turn) { return lies_within(turn, kBesideTurn); })) {
    return false;
  }
  std::vector<double> others;
  for (const Turn& turn : turns) {
    if (!lies_within(turn, kBesideTurn + kBesideJump)) others.push_back(step_at(e, turn));
  }
  return others.size() >= kFewestTurns &&
         std::abs(step.change) <= kOverTurns * *std::max_element(others.begin(), others.end());
}

bool is_usable(const ComparedRows& rows) {
  const Index n = rows.measured.size();
  return n >= kFewestRows && rows.simulated.size() == n && rows.input.size() == n && rows.time_s.size() == n &&
         rows.measured.allFinite() && rows.simulated.allFinite();
}

}  // namespace

std::optional<EndStop> end_stop(const ComparedRows& rows) {
  return is_usable(rows) ? Search(rows).found() : std::nullopt;
}

std::optional<ErrorJump> error_jump(const ComparedRows& rows) {
  if (!is_usable(rows)) return std::nullopt;
  const Eigen::VectorXd e = rows.measured - rows.simulated;
  const Eigen::VectorXd change = changes_of(e, rows.time_s);
  const double usual = robust_std({change.begin(), change.end()});
  const double largest = change.cwiseAbs().maxCoeff();
  if (!(largest > kJumpOverUsual * usual)) return std::nullopt;
  const std::vector<Turn> turns = turns_of(rows.simulated);
  std::optional<LastingStep> jump;
  Index count = 0;
  for (Index k = 0; k < change.size(); ++k) {
    if (!(std::abs(change[k]) > kLikeIt * largest)) continue;
    Index at = k;
    for (const Index end = std::min(change.size(), k + 3 * kJumpRows + 1); k < end; ++k) {
      if (std::abs(change[k]) > std::abs(change[at])) at = k;
    }
    k = std::max(k - 1, at + 3 * kJumpRows);
    const std::optional<LastingStep> step = lasting_step(e, at);
    if (!step || ++count > kMostJumps) return std::nullopt;
    if (is_of_a_turn(*step, e, turns)) continue;
    if (!jump || std::abs(step->change) > std::abs(jump->change)) jump = step;
  }
  return jump ? std::optional(ErrorJump{rows.time_s[jump->middle], jump->change, kJumpOverUsual * usual})
              : std::nullopt;
}

std::string cut_options(const EndStop& stop) {
  std::string options;
  if (stop.clean_from_s) options = "--from " + time_text(*stop.clean_from_s);
  if (stop.clean_to_s) options += (options.empty() ? "--to " : " --to ") + time_text(*stop.clean_to_s);
  return options;
}

CutBeside cut_beside(const ErrorJump& jump, std::optional<double> compared_step_s) {
  const double margin_s = compared_step_s && *compared_step_s > 0.0 ? kCutRows * *compared_step_s
                                                                    : kCutOfTime * std::max(1.0, std::abs(jump.time_s));
  // Few digits, rounded away from the jump.
  const double digit = std::pow(10.0, std::floor(std::log10(margin_s)));
  const auto in_digits = [&](double count) { return digit < 1.0 ? count / std::round(1.0 / digit) : count * digit; };
  constexpr double kRounding = 1e-6;
  return {in_digits(std::floor((jump.time_s - margin_s) / digit + kRounding)),
          in_digits(std::ceil((jump.until_s.value_or(jump.time_s) + margin_s) / digit - kRounding))};
}

std::string cut_options(const CutBeside& cut) {
  return fmt::format("--to {} or --from {}", time_text(cut.to_s), time_text(cut.from_s));
}

std::string jump_text(const ErrorJump& jump, const std::string& unit) {
  if (jump.until_s) {
    return fmt::format("error is up to {:.3g}{} from about {} to {} s, and far less elsewhere", std::abs(jump.change),
                       after_number(unit), time_text(jump.time_s), time_text(*jump.until_s));
  }
  return fmt::format("error jumps by {:.3g}{} at about {} s", jump.change, after_number(unit), time_text(jump.time_s));
}

}  // namespace eha::ident
