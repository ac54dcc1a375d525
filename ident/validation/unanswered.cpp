// SPDX-License-Identifier: GPL-3.0-or-later
#include "ident/validation/unanswered.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>

namespace eha::ident {
namespace {

using Eigen::Index;

constexpr Index kSilentWindows = 6;
constexpr double kSilentInput = 0.5;    // of the input's standard deviation
constexpr double kSilentReach = 0.6;    // of what a tenth of the input's rows reach
constexpr double kSilentAlike = 0.1;    // of the input's range
constexpr double kSilentMotion = 0.15;  // of the motion elsewhere with the same input
constexpr double kSilentModel = 0.2;    // of it
constexpr double kSilentWidths = 5.0;
constexpr double kSilentFollows = 0.7;  // correlation of the motions elsewhere
constexpr double kSilentBack = 0.1;     // of the output's range
constexpr std::size_t kSilentFewest = 3;

/// Mean input and motions over a window.
struct SilentPiece {
  double input = 0.0;
  double measured = 0.0;
  double simulated = 0.0;
};

class Silence {
 public:
  Silence(const ComparedRows& rows, double width, Index window)
      : rows_(rows), width_(width), window_(window), standing_(standing()) {
    for (Index k = 0; k + window < rows.measured.size(); k += window) pieces_.push_back(at(k));
    same_input_ = kSilentAlike * range(rows.input);
  }

  [[nodiscard]] std::vector<StandingRows> found() const {
    std::vector<StandingRows> all;
    std::copy_if(standing_.begin(), standing_.end(), std::back_inserter(all),
                 [&](const StandingRows& s) { return is_unanswered(s); });
    return all;
  }

 private:
  static double range(const Eigen::Ref<const Eigen::VectorXd>& x) { return x.maxCoeff() - x.minCoeff(); }

  static double deviation(const Eigen::Ref<const Eigen::VectorXd>& x) {
    return std::sqrt((x.array() - x.mean()).square().mean());
  }

  /// How far an input goes from the record's mean in a tenth of its rows.
  [[nodiscard]] double reach(const Eigen::Ref<const Eigen::VectorXd>& x) const {
    Eigen::VectorXd far = (x.array() - rows_.input.mean()).abs();
    double* const tenth = far.data() + (far.size() * 9) / 10;
    std::nth_element(far.data(), tenth, far.data() + far.size());
    return *tenth;
  }

  [[nodiscard]] SilentPiece at(Index k) const {
    return {rows_.input.segment(k, window_).mean(), rows_.measured[k + window_] - rows_.measured[k],
            rows_.simulated[k + window_] - rows_.simulated[k]};
  }

  /// Stretches whose samples all lie within the width; those that a few rows part are one.
  [[nodiscard]] std::vector<StandingRows> standing() const {
    const Eigen::VectorXd& y = rows_.measured;
    std::vector<StandingRows> all;
    for (Index k = 0; k < y.size();) {
      Index end = k + 1;
      double least = y[k];
      double greatest = y[k];
      while (end < y.size() && std::max(greatest, y[end]) - std::min(least, y[end]) <= width_) {
        least = std::min(least, y[end]);
        greatest = std::max(greatest, y[end]);
        ++end;
      }
      const bool is_long = end - k >= window_;
      const bool goes_on = is_long && !all.empty() && k - all.back().last <= window_ &&
                           std::abs(y.segment(k, end - k).mean() - level(all.back())) <= width_;
      if (goes_on) {
        all.back().last = end - 1;
      } else if (is_long) {
        all.push_back({k, end - 1});
      }
      k = end;
    }
    std::erase_if(all, [&](const StandingRows& s) { return s.last - s.first + 1 < kSilentWindows * window_; });
    return all;
  }

  [[nodiscard]] double level(const StandingRows& s) const {
    return rows_.measured.segment(s.first, s.last - s.first + 1).mean();
  }

  [[nodiscard]] bool is_unanswered(const StandingRows& s) const {
    const Index count = s.last - s.first + 1;
    if (deviation(rows_.input.segment(s.first, count)) < kSilentInput * deviation(rows_.input)) return false;
    // Small inputs alone leave a rod at rest by friction or a dead band.
    if (reach(rows_.input.segment(s.first, count)) < kSilentReach * reach(rows_.input)) return false;
    if (range(rows_.simulated.segment(s.first, count)) < kSilentWidths * width_) return false;
    double expected = 0.0;
    double measured = 0.0;
    double simulated = 0.0;
    for (Index k = s.first; k + window_ <= s.last; k += window_) {
      const SilentPiece piece = at(k);
      expected += usual_motion(piece.input, s);
      measured += std::abs(piece.measured);
      simulated += std::abs(piece.simulated);
    }
    return expected > kSilentWidths * width_ && measured < kSilentMotion * expected &&
           simulated > kSilentModel * expected && follows_beside(s) && (!is_at_end(s) || is_asked_back(s));
  }

  [[nodiscard]] bool touches(std::size_t piece, const StandingRows& s) const {
    const Index first = static_cast<Index>(piece) * window_;
    return first + window_ >= s.first && first <= s.last;
  }

  /// Whether the model moves with the output outside the stretch.
  [[nodiscard]] bool follows_beside(const StandingRows& s) const {
    double mm = 0.0;
    double ss = 0.0;
    double ms = 0.0;
    for (std::size_t i = 0; i < pieces_.size(); ++i) {
      if (touches(i, s)) continue;
      mm += pieces_[i].measured * pieces_[i].measured;
      ss += pieces_[i].simulated * pieces_[i].simulated;
      ms += pieces_[i].measured * pieces_[i].simulated;
    }
    return ms > kSilentFollows * std::sqrt(mm * ss);
  }

  /// Mean size of the motions outside the stretch with this input; 0 if there are too few.
  [[nodiscard]] double usual_motion(double input, const StandingRows& s) const {
    double sum = 0.0;
    std::size_t count = 0;
    for (std::size_t i = 0; i < pieces_.size(); ++i) {
      const SilentPiece& piece = pieces_[i];
      if (touches(i, s) || std::abs(piece.input - input) > same_input_) continue;
      sum += std::abs(piece.measured);
      ++count;
    }
    return count < kSilentFewest ? 0.0 : sum / static_cast<double>(count);
  }

  [[nodiscard]] double side_of(const StandingRows& s) const {
    const double up = rows_.measured.maxCoeff() - level(s);
    const double down = level(s) - rows_.measured.minCoeff();
    return up < down ? 1.0 : -1.0;
  }

  [[nodiscard]] bool is_at_end(const StandingRows& s) const {
    const double side = side_of(s);
    return (side * rows_.measured).maxCoeff() - side * level(s) <= 2.0 * width_;
  }

  /// Whether the model goes far back from where it was as the output came to the end: of a sensor at its end, or a rod
  /// on its stop, it only comes back from beyond.
  [[nodiscard]] bool is_asked_back(const StandingRows& s) const {
    const double side = side_of(s);
    const Eigen::VectorXd model = side * rows_.simulated.segment(s.first, s.last - s.first + 1);
    const double back = model[0] - model.minCoeff();
    return back > std::max(kSilentBack * range(rows_.measured), kSilentWidths * width_);
  }

  const ComparedRows& rows_;
  double width_;
  Index window_;
  double same_input_ = 0.0;
  std::vector<StandingRows> standing_;
  std::vector<SilentPiece> pieces_;
};

}  // namespace

std::vector<StandingRows> unanswered(const ComparedRows& rows, double width, Index window) {
  if (!(width > 0.0) || window < 1 || rows.measured.size() <= kSilentWindows * window) return {};
  return Silence(rows, width, window).found();
}

}  // namespace eha::ident
