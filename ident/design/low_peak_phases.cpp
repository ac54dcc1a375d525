// SPDX-License-Identifier: GPL-3.0-or-later
#include "ident/design/low_peak_phases.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <complex>
#include <limits>
#include <nlopt.hpp>

#include "ident/excitation/portable_draw.hpp"
#include "ident/excitation/tone.hpp"
#include "ident/signal/fft.hpp"

namespace eha::ident {
namespace {

using Complex = std::complex<double>;

constexpr std::array<double, 5> kNorms{4.0, 8.0, 16.0, 32.0, 64.0};
constexpr std::size_t kPointsWhileSearching = 8;  ///< in the shortest period
constexpr std::size_t kPointsAtTheEnd = 32;
constexpr int kMostEvaluations = 150;  ///< of one norm

/// The signals over one period, and their peaks.
class Peaks {
 public:
  Peaks(const std::vector<std::size_t>& harmonics, const std::vector<Eigen::VectorXcd>& signals, std::size_t points)
      : harmonics_(harmonics),
        points_(std::bit_ceil(points * harmonics.back())),
        fft_(points_),
        spectrum_(fft_.bins()),
        signal_(points_) {
    // Scaled to an RMS of 1.
    for (const Eigen::VectorXcd& signal : signals) scaled_.push_back(signal * (std::sqrt(2.0) / signal.norm()));
  }

  /// log(sum_j mean_t x_j^p) / p, and its gradient.
  double norm(const Eigen::VectorXd& phase_rad, double p, std::vector<double>& gradient) {
    const auto n = static_cast<double>(points_);
    std::fill(gradient.begin(), gradient.end(), 0.0);
    double sum = 0.0;
    for (const Eigen::VectorXcd& amplitudes : scaled_) {
      simulate(amplitudes, phase_rad);
      for (double& x : signal_) {
        const double power = std::pow(std::abs(x), p - 1.0);
        sum += power * std::abs(x) / n;
        x = std::copysign(power, x);
      }
      if (gradient.empty()) continue;
      fft_.forward(signal_, spectrum_);
      for (std::size_t k = 0; k < harmonics_.size(); ++k) {
        const auto i = static_cast<Eigen::Index>(k);
        const Complex rotated = amplitudes[i] * std::polar(1.0, phase_rad[i]);
        gradient[k] -= std::imag(rotated * std::conj(spectrum_[harmonics_[k]])) / n;
      }
    }
    for (double& slope : gradient) slope /= sum;
    return std::log(sum) / p;
  }

  /// The greatest of the crest factors.
  double crest(const Eigen::VectorXd& phase_rad) {
    double greatest = 0.0;
    for (const Eigen::VectorXcd& amplitudes : scaled_) {
      simulate(amplitudes, phase_rad);
      for (const double x : signal_) greatest = std::max(greatest, std::abs(x));
    }
    return greatest;
  }

 private:
  void simulate(const Eigen::VectorXcd& amplitudes, const Eigen::VectorXd& phase_rad) {
    std::fill(spectrum_.begin(), spectrum_.end(), Complex());
    for (std::size_t k = 0; k < harmonics_.size(); ++k) {
      const auto i = static_cast<Eigen::Index>(k);
      // The inverse transform adds each bin's mirror image.
      spectrum_[harmonics_[k]] = 0.5 * amplitudes[i] * std::polar(1.0, phase_rad[i]);
    }
    fft_.inverse(spectrum_, signal_);
  }

  const std::vector<std::size_t>& harmonics_;
  std::size_t points_;
  RealFft fft_;
  std::vector<Complex> spectrum_;
  std::vector<double> signal_;
  std::vector<Eigen::VectorXcd> scaled_;
};

struct Task {
  Peaks& peaks;
  double p;
};

double evaluate(const std::vector<double>& phase, std::vector<double>& gradient, void* data) {
  Task& task = *static_cast<Task*>(data);
  const auto size = static_cast<Eigen::Index>(phase.size());
  return task.peaks.norm(Eigen::Map<const Eigen::VectorXd>(phase.data(), size), task.p, gradient);
}

/// Minimises from one start through all norms.
void minimise(Peaks& peaks, std::vector<double>& phase) {
  for (const double p : kNorms) {
    Task task{peaks, p};
    nlopt::opt search(nlopt::LD_LBFGS, static_cast<unsigned>(phase.size()));
    search.set_min_objective(evaluate, &task);
    search.set_maxeval(kMostEvaluations);
    search.set_ftol_abs(1e-6);
    double least = 0.0;
    try {
      search.optimize(phase, least);
    } catch (const std::exception&) {
      // A line search that finds no lower point leaves the best point in `phase`.
    }
  }
}

}  // namespace

Eigen::VectorXd low_peak_phases(const std::vector<std::size_t>& harmonics, const std::vector<Eigen::VectorXcd>& signals,
                                int starts, std::uint64_t seed) {
  Peaks coarse(harmonics, signals, kPointsWhileSearching);
  Peaks fine(harmonics, signals, kPointsAtTheEnd);
  PortableDraw draw(seed);
  const auto count = static_cast<Eigen::Index>(harmonics.size());
  Eigen::VectorXd best = Eigen::VectorXd::Zero(count);
  double lowest = std::numeric_limits<double>::infinity();
  std::vector<double> phase(harmonics.size());
  for (int start = 0; start < starts; ++start) {
    for (double& p : phase) p = kTwoPi * draw.uniform();
    minimise(coarse, phase);
    const Eigen::VectorXd found = Eigen::Map<const Eigen::VectorXd>(phase.data(), count);
    if (const double crest = fine.crest(found); crest < lowest) {
      lowest = crest;
      best = found;
    }
  }
  return best.unaryExpr([](double p) { return p - kTwoPi * std::floor(p / kTwoPi); });
}

double crest_factor_of(const std::vector<std::size_t>& harmonics, const Eigen::VectorXcd& signal,
                       const Eigen::VectorXd& phase_rad) {
  return Peaks(harmonics, {signal}, kPointsAtTheEnd).crest(phase_rad);
}

}  // namespace eha::ident
