// SPDX-License-Identifier: GPL-3.0-or-later
#include "ident/design/improvement.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>

#include "core/error.hpp"
#include "ident/design/known_model.hpp"
#include "ident/design/tone_powers.hpp"
#include "ident/excitation/portable_draw.hpp"
#include "ident/excitation/tone.hpp"
#include "ident/uncertainty/covariance.hpp"
#include "ident/uncertainty/output_derivatives.hpp"

namespace eha::ident {
namespace {

constexpr std::size_t kGridTones = 40;
constexpr double kPassband = 0.45;  // of the compared samples' Nyquist frequency; the filter is flat below half of it
constexpr double kVoltageMargin = 0.97;  // of the limits, for rounding
constexpr double kSlewMargin = 0.95;
constexpr double kTravelMargin = 0.05;  // of the travel, kept free at either end
constexpr double kLeastShare = 0.01;    // of a limit; a smaller tone is left out
constexpr std::size_t kMostTones = 10;
constexpr int kDraws = 200;  // of phases
constexpr int kCrestRounds = 2;
constexpr double kFirstCrest = 2.0;
constexpr std::size_t kPointsInAPeriod = 32;   // of the highest tone, to find peaks
constexpr std::array kDrives{0.0, 0.25, 0.5};  // shares of the power moved to the lowest tone
constexpr double kTravelStep_s = 0.005;
constexpr int kHalvings = 14;
constexpr double kDecimals = 1e4;

bool is_of_g(ParameterRole role) { return is_coefficient(role) || is_order(role) || role == ParameterRole::delay; }

/// Tones as harmonics of 1/period.
struct Multitone {
  std::vector<double> frequency_Hz;
  Eigen::VectorXd amplitude;
  Eigen::VectorXd phase;

  [[nodiscard]] Eigen::VectorXd volts(double step_s, Eigen::Index samples) const {
    Eigen::VectorXd u = Eigen::VectorXd::Zero(samples);
    for (std::size_t k = 0; k < frequency_Hz.size(); ++k) {
      const auto i = static_cast<Eigen::Index>(k);
      add_tone({frequency_Hz[k], amplitude[i], phase[i]}, step_s, u);
    }
    return u;
  }
};

/// Voltage, slew and travel of an excitation, each over its limit, and the offset that prevents a drift.
struct Use {
  std::array<double, 3> share{};  ///< by BindingLimit
  double offset_V = 0.0;
  double peak_V = 0.0;
  double peak_slew_V_per_s = 0.0;
  double lowest_output = 0.0;
  double highest_output = 0.0;
  [[nodiscard]] double greatest() const { return *std::max_element(share.begin(), share.end()); }
};

/// Noise that the powers of the tones are optimised for. The residual that friction and dead band cause may be coloured
/// differently in another experiment.
enum class NoiseShape { stored, white };

class Designer {
 public:
  Designer(const Model& model, const std::string& parameter, const ImprovementTask& task)
      : known_(known_model(model, parameter, task)), task_(task) {
    const ParameterKey& target = known_.covariance.parameters[known_.target];
    for (std::size_t i = 0; i < known_.covariance.parameters.size(); ++i) {
      if (is_of_g(known_.covariance.parameters[i].role)) of_g_.push_back(i);
    }
    if (!is_of_g(target.role)) {
      std::vector<std::string> names;
      for (const std::size_t i : of_g_) names.push_back(known_.covariance.parameters[i].name);
      throw ConfigError(fmt::format("model {}: tones improve the parameters of its transfer function ({}), not {}",
                                    model.name, fmt::join(names, ", "), target.name));
    }
    samples_ = static_cast<Eigen::Index>(std::llround(task.duration_s / task.limits.step_s));
    add_grid();
  }

  /// The smallest predicted standard error first.
  std::vector<Improvement> run() {
    std::vector<Improvement> found;
    for (const NoiseShape shape : {NoiseShape::stored, NoiseShape::white}) {
      for (const double drive : kDrives) {
        if (auto one = designed(shape, drive)) found.push_back(*std::move(one));
      }
    }
    if (found.empty()) {
      throw ConfigError("the rig's limits leave no room for an excitation around the model's initial output");
    }
    std::sort(found.begin(), found.end(), [](const Improvement& a, const Improvement& b) { return a.std < b.std; });
    return found;
  }

 private:
  void add_grid() {
    const double highest = kPassband * 0.5 / known_.compared_step_s * task_.period_s;
    double last = 0.0;
    for (std::size_t i = 0; i < kGridTones; ++i) {
      const double share = static_cast<double>(i) / static_cast<double>(kGridTones - 1);
      const double harmonic = std::round(std::pow(std::max(highest, 1.0), share));
      if (harmonic > last) grid_Hz_.push_back(harmonic / task_.period_s);
      last = std::max(last, harmonic);
    }
  }

  /// Returns the offset without a drift: the map's output has no mean.
  [[nodiscard]] double steady_offset(const Eigen::VectorXd& shape) const {
    if (!known_.model.input_map) return -known_.model.input_bias;
    const ValveMap& map = *known_.model.input_map;
    // A signal within the dead band does not drift at any offset there.
    if (shape.cwiseAbs().maxCoeff() <= map.dead_band) return map.null;
    double low = map.null - map.dead_band - shape.cwiseAbs().maxCoeff();
    double high = map.null + map.dead_band + shape.cwiseAbs().maxCoeff();
    for (int i = 0; i < 50; ++i) {
      const double middle = 0.5 * (low + high);
      (mapped(map, (shape.array() + middle).matrix()).mean() > 0.0 ? high : low) = middle;
    }
    return 0.5 * (low + high);
  }

  [[nodiscard]] double travel_room() const {
    const double margin = kTravelMargin * (task_.limits.highest_output - task_.limits.lowest_output);
    return std::min(task_.limits.highest_output - margin - known_.model.initial_output,
                    known_.model.initial_output - task_.limits.lowest_output - margin);
  }

  /// Returns the powers at the grid within the limits, given the crest factors.
  [[nodiscard]] Eigen::VectorXd powers(NoiseShape shape, const std::array<double, 3>& crest) const {
    const auto tones = static_cast<Eigen::Index>(grid_Hz_.size());
    ToneProblem problem;
    problem.response.resize(tones, static_cast<Eigen::Index>(of_g_.size()));
    problem.noise.resize(tones);
    problem.cost.resize(3, tones);
    std::vector<ParameterKey> parameters;
    for (const std::size_t i : of_g_) {
      if (i == known_.target) problem.target = static_cast<Eigen::Index>(parameters.size());
      parameters.push_back(known_.covariance.parameters[i]);
    }
    const double offset = steady_offset(Eigen::VectorXd::Zero(1));
    const double volts = kVoltageMargin * std::min(task_.limits.highest_V - offset, offset - task_.limits.lowest_V);
    const std::array<double, 3> limit{volts, kSlewMargin * task_.limits.slew_V_per_s, travel_room()};
    for (Eigen::Index k = 0; k < tones; ++k) {
      const double f = grid_Hz_[static_cast<std::size_t>(k)];
      const GainSlope at = gain_slope(known_.model, parameters, f);
      problem.response.row(k) = (at.gain * at.slope).transpose();
      problem.noise[k] =
          shape == NoiseShape::white ? known_.noise.power : noise_power(known_.noise, known_.compared_step_s, f);
      const std::array<double, 3> per_volt{1.0, kTwoPi * f, std::abs(at.gain)};
      for (std::size_t j = 0; j < 3; ++j) {
        problem.cost(static_cast<Eigen::Index>(j), k) = std::pow(crest[j] * per_volt[j] / limit[j], 2);
      }
    }
    return tone_powers(problem);
  }

  /// Returns the strongest tones of the grid, with phases 0.
  [[nodiscard]] Multitone chosen(Eigen::VectorXd power, double drive) const {
    // A drive at the lowest frequency carries the others over a dead band.
    const double moved = drive * power.sum();
    power *= 1.0 - drive;
    power[0] += moved;
    std::vector<Eigen::Index> order(grid_Hz_.size());
    for (std::size_t k = 0; k < order.size(); ++k) order[k] = static_cast<Eigen::Index>(k);
    std::sort(order.begin(), order.end(), [&](Eigen::Index a, Eigen::Index b) { return power[a] > power[b]; });
    std::size_t kept = 1;
    while (kept < std::min(kMostTones, order.size()) && power[order[kept]] > kLeastShare * kLeastShare * power.sum()) {
      ++kept;
    }
    order.resize(kept);
    std::sort(order.begin(), order.end());
    Multitone tones{{}, Eigen::VectorXd(order.size()), Eigen::VectorXd::Zero(static_cast<Eigen::Index>(order.size()))};
    for (std::size_t k = 0; k < order.size(); ++k) {
      tones.frequency_Hz.push_back(grid_Hz_[static_cast<std::size_t>(order[k])]);
      tones.amplitude[static_cast<Eigen::Index>(k)] = std::sqrt(2.0 * power[order[k]]);
    }
    return tones;
  }

  /// Draws phases, keeps those of the lowest peak over the three limits, and stores their crest factors.
  void draw_phases(Multitone& tones, std::array<double, 3>& crest) const {
    const std::array<double, 3> limit{task_.limits.highest_V, task_.limits.slew_V_per_s, travel_room()};
    const auto count = static_cast<Eigen::Index>(tones.frequency_Hz.size());
    const auto points = static_cast<Eigen::Index>(
        kPointsInAPeriod * static_cast<std::size_t>(std::ceil(tones.frequency_Hz.back() * task_.period_s)));
    std::array<Eigen::MatrixXcd, 3> waves;
    for (auto& wave : waves) wave.resize(points, count);
    for (Eigen::Index k = 0; k < count; ++k) {
      const double f = tones.frequency_Hz[static_cast<std::size_t>(k)];
      const std::complex<double> gain = gain_slope(known_.model, {}, f).gain;
      const std::array<std::complex<double>, 3> factor{1.0, std::complex<double>(0.0, kTwoPi * f), gain};
      for (Eigen::Index n = 0; n < points; ++n) {
        const double turn = kTwoPi * f * task_.period_s * static_cast<double>(n) / static_cast<double>(points);
        for (std::size_t j = 0; j < 3; ++j) waves[j](n, k) = tones.amplitude[k] * factor[j] * std::polar(1.0, turn);
      }
    }
    PortableDraw draw(task_.seed);
    double least = std::numeric_limits<double>::infinity();
    for (int trial = 0; trial < kDraws; ++trial) {
      Eigen::VectorXd phase(count);
      for (double& p : phase) p = kTwoPi * draw.uniform();
      const Eigen::VectorXcd rotation = phase.unaryExpr([](double p) { return std::polar(1.0, p); });
      std::array<double, 3> peak{};
      std::array<double, 3> rms{};
      for (std::size_t j = 0; j < 3; ++j) {
        const Eigen::VectorXd signal = (waves[j] * rotation).real();
        peak[j] = signal.cwiseAbs().maxCoeff();
        rms[j] = std::sqrt(signal.squaredNorm() / static_cast<double>(points));
      }
      const double worst = std::max({peak[0] / limit[0], peak[1] / limit[1], peak[2] / limit[2]});
      if (!(worst < least)) continue;
      least = worst;
      tones.phase = phase;
      for (std::size_t j = 0; j < 3; ++j) crest[j] = peak[j] / rms[j];
    }
  }

  /// Computes the shares of the limits that an excitation uses. @param shape  volts at every tick without offset
  [[nodiscard]] Use use_of(const Eigen::VectorXd& shape) const {
    const ExcitationLimits& limits = task_.limits;
    Use use;
    use.offset_V = std::round(kDecimals * steady_offset(shape)) / kDecimals;
    const double highest = shape.maxCoeff() + use.offset_V;
    const double lowest = shape.minCoeff() + use.offset_V;
    use.peak_V = std::max(std::abs(highest), std::abs(lowest));
    const Eigen::Index rest = shape.size() - 1;
    use.peak_slew_V_per_s = (shape.tail(rest) - shape.head(rest)).cwiseAbs().maxCoeff() / limits.step_s;
    const auto every = std::max<Eigen::Index>(1, std::lround(kTravelStep_s / limits.step_s));
    const Eigen::VectorXd coarse = shape(Eigen::seq(0, Eigen::last, every)).array() + use.offset_V;
    const Eigen::VectorXd y = simulate(known_.model, coarse, limits.step_s * static_cast<double>(every));
    use.lowest_output = y.minCoeff();
    use.highest_output = y.maxCoeff();
    const double room = travel_room();
    const double excursion =
        std::max(use.highest_output - known_.model.initial_output, known_.model.initial_output - use.lowest_output);
    const double middle_V = 0.5 * (limits.highest_V + limits.lowest_V);
    const double half_V = kVoltageMargin * 0.5 * (limits.highest_V - limits.lowest_V);
    use.share = {std::max(highest - middle_V, middle_V - lowest) / half_V,
                 use.peak_slew_V_per_s / (kSlewMargin * limits.slew_V_per_s),
                 room > 0.0 ? excursion / room : std::numeric_limits<double>::infinity()};
    if (!y.allFinite()) use.share[2] = std::numeric_limits<double>::infinity();
    return use;
  }

  [[nodiscard]] std::optional<Improvement> designed(NoiseShape noise, double drive) const {
    if (!(travel_room() > 0.0)) return {};
    std::array<double, 3> crest{kFirstCrest, kFirstCrest, kFirstCrest};
    Multitone tones;
    for (int round = 0; round < kCrestRounds; ++round) {
      tones = chosen(powers(noise, crest), drive);
      draw_phases(tones, crest);
    }
    const Eigen::VectorXd shape = tones.volts(task_.limits.step_s, samples_);
    double low = 0.0;
    double high = 1.0;
    while (use_of(high * shape).greatest() < 1.0 && high < 64.0) {
      low = high;
      high *= 2.0;
    }
    for (int i = 0; i < kHalvings; ++i) {
      const double middle = 0.5 * (low + high);
      (use_of(middle * shape).greatest() > 1.0 ? high : low) = middle;
    }
    Improvement result;
    for (std::size_t k = 0; k < tones.frequency_Hz.size(); ++k) {
      const auto i = static_cast<Eigen::Index>(k);
      tones.amplitude[i] = std::floor(kDecimals * low * tones.amplitude[i]) / kDecimals;
      tones.phase[i] = std::round(kDecimals * tones.phase[i]) / kDecimals;
      if (tones.amplitude[i] > 0.0) result.tones.push_back({tones.frequency_Hz[k], tones.amplitude[i], tones.phase[i]});
    }
    if (result.tones.empty()) return {};
    const Eigen::VectorXd played = tones.volts(task_.limits.step_s, samples_);
    const Use use = use_of(played);
    result.offset_V = use.offset_V;
    result.binding =
        static_cast<BindingLimit>(std::max_element(use.share.begin(), use.share.end()) - use.share.begin());
    result.peak_V = use.peak_V;
    result.peak_slew_V_per_s = use.peak_slew_V_per_s;
    result.lowest_output = use.lowest_output;
    result.highest_output = use.highest_output;
    result.std = std_by(known_, (played.array() + use.offset_V).matrix(), task_);
    return result;
  }

  KnownModel known_;
  const ImprovementTask& task_;
  std::vector<std::size_t> of_g_;  ///< parameters of G, as the covariance counts them
  Eigen::Index samples_ = 0;
  std::vector<double> grid_Hz_;
};

}  // namespace

std::string_view text(BindingLimit limit) {
  switch (limit) {
    case BindingLimit::voltage:
      return "voltage";
    case BindingLimit::slew:
      return "slew";
    case BindingLimit::travel:
      break;
  }
  return "travel";
}

double predicted_std(const Model& model, const std::string& parameter, const Eigen::Ref<const Eigen::VectorXd>& input,
                     const ImprovementTask& task) {
  return std_by(known_model(model, parameter, task), input, task);
}

std::vector<Improvement> improvements(const Model& model, const std::string& parameter, const ImprovementTask& task) {
  return Designer(model, parameter, task).run();
}

Improvement improve(const Model& model, const std::string& parameter, const ImprovementTask& task) {
  return improvements(model, parameter, task).front();
}

}  // namespace eha::ident
