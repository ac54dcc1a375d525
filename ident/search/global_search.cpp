// SPDX-License-Identifier: GPL-3.0-or-later
#include "ident/search/global_search.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <iterator>
#include <limits>
#include <nlopt.hpp>
#include <numbers>
#include <optional>
#include <random>

#include "ident/signal/fft.hpp"

namespace eha::ident {
namespace {

constexpr double kCoarseRows = 1000.0;      // enough to find the basin of an optimum
constexpr double kMostCoarseRows = 4000.0;  // for a fast output
// Share of the output's power, above a fifth of the coarse Nyquist frequency, that a coarse record may lose.
constexpr double kLostPower = 1e-4;
constexpr double kPassedByFilter = 0.25;  // cycles a row that the filter of a sparse record passes
constexpr std::size_t kNoiseBands = 8;
constexpr std::size_t kPopulations = 4;       // run in parallel
constexpr int kEvaluationsPerDimension = 15;  // each
constexpr unsigned kMembersPerDimension = 5;
constexpr std::size_t kPolished = 8;
constexpr std::ptrdiff_t kMostCoveredWeights = 2;
constexpr std::size_t kGuessesPolished = 6;
constexpr double kDistinctGuess = 0.01;  // guesses may lie close: the basin of a lightly damped optimum is narrow
constexpr double kDistinct = 0.12;       // of the search box, root mean square
constexpr double kSameBasin = 1e-3;      // searches that have come closer than this end in one optimum
constexpr double kInfeasible = 1e3;      // logarithm of a cost that no model reaches
constexpr double kLeastCost = 1e-300;    // its logarithm is finite
constexpr double kLeastWidth = 1e-12;    // of a side of the search box
constexpr std::array<double, 7> kScan = {0.1, 1.0, 2.5, 4.0, 5.5, 7.0, 9.0};  // weight coordinates, 1e-3 to 30
constexpr double kAtItsEnd = 0.1;                                             // share of the range of an order
constexpr double kSameCost = 1e-4;  // relative; two optima closer than this are one
constexpr double kNearBest = 1.01;  // costs so near the least one are predicted well

/// Rows begin..last of a record in blocks of `factor`, compared from row `first` of the record on.
CoarseRecord blocks(const Record& record, std::size_t begin, std::size_t last, std::size_t first, std::size_t factor) {
  CoarseRecord coarse{.record = {}, .first = (first - begin + factor - 1) / factor};
  coarse.record.start_s = record.start_s;
  coarse.record.input_channel = record.input_channel;
  coarse.record.output_channel = record.output_channel;
  const auto width = static_cast<Eigen::Index>(factor);
  const auto start = static_cast<Eigen::Index>(begin);
  const Eigen::Index count = (static_cast<Eigen::Index>(last) + 1 - start) / width;
  coarse.fine_input = record.input.segment(start, count * width);
  coarse.block = width;
  coarse.record.step_s = record.step_s * static_cast<double>(factor);
  coarse.record.input.resize(count);
  coarse.record.output.resize(count);
  for (Eigen::Index k = 0; k < count; ++k) {
    coarse.record.input[k] = record.input.segment(start + k * width, width).mean();
    coarse.record.output[k] = record.output[start + k * width];
  }
  const auto compared = static_cast<std::size_t>(count);
  coarse.rows = compared - std::min(compared, coarse.first);
  return coarse;
}

/// The best of a start and of the same orders with other coefficient weights.
Eigen::VectorXd with_scanned_coefficients(const OutputError& problem, const Eigen::VectorXd& start) {
  const auto& coordinates = problem.parametrisation().coordinates();
  std::vector<Eigen::Index> weights;
  for (std::size_t l = 0; l < coordinates.size(); ++l) {
    if (coordinates[l].role == CoordinateRole::weighted_denominator) weights.push_back(static_cast<Eigen::Index>(l));
  }
  Eigen::VectorXd best = start;
  if (weights.empty() || weights.size() > 2) return best;
  const auto cost = [&](const Eigen::VectorXd& theta) {
    const auto point = problem.evaluate(theta);
    return point ? point->cost : std::numeric_limits<double>::infinity();
  };
  double least = cost(start);
  const std::size_t trials = weights.size() == 1 ? kScan.size() : kScan.size() * kScan.size();
  for (std::size_t k = 0; k < trials; ++k) {
    Eigen::VectorXd theta = start;
    for (std::size_t w = 0; w < weights.size(); ++w) {
      const auto l = static_cast<std::size_t>(weights[w]);
      const double wanted = kScan[w == 0 ? k % kScan.size() : k / kScan.size()];
      theta[weights[w]] = std::clamp(wanted, coordinates[l].lower, coordinates[l].upper);
    }
    const double value = cost(theta);
    if (value < least) {
      least = value;
      best = theta;
    }
  }
  return best;
}

/// The search box and the start inside it.
struct SearchBox {
  std::vector<double> lower;
  std::vector<double> upper;
  std::vector<double> start;

  explicit SearchBox(const std::vector<Coordinate>& coordinates) {
    for (const Coordinate& c : coordinates) {
      lower.push_back(c.search_lower);
      upper.push_back(c.search_upper);
      start.push_back(std::clamp(c.start, c.search_lower, c.search_upper));
    }
  }

  /// Root mean square over the coordinates, each as a share of the box.
  [[nodiscard]] double distance(const Eigen::VectorXd& a, const Eigen::VectorXd& b) const {
    double sum = 0.0;
    for (Eigen::Index l = 0; l < a.size(); ++l) {
      const auto k = static_cast<std::size_t>(l);
      const double width = std::max(upper[k] - lower[k], kLeastWidth);
      sum += std::pow((a[l] - b[l]) / width, 2);
    }
    return std::sqrt(sum / static_cast<double>(std::max<Eigen::Index>(a.size(), 1)));
  }
};

struct Seen {
  double log_cost;
  Eigen::VectorXd theta;
};

/// Stable points, and how many points were tried to find them.
struct Explored {
  std::vector<Seen> stable;
  std::size_t tried = 0;
};

/// One population of a controlled random search: every stable point it tried. Deterministic for a seed: NLopt's
/// generator is the calling thread's own.
Explored look_around(const OutputError& problem, const SearchBox& box, std::uint32_t seed) {
  const auto n = static_cast<Eigen::Index>(box.start.size());
  Explored seen;
  nlopt::srand(seed);
  nlopt::opt crs(nlopt::GN_CRS2_LM, static_cast<unsigned>(n));
  crs.set_lower_bounds(box.lower);
  crs.set_upper_bounds(box.upper);
  crs.set_maxeval(kEvaluationsPerDimension * static_cast<int>(n + 1));
  crs.set_population(kMembersPerDimension * static_cast<unsigned>(n + 1));
  const auto objective = [&](const std::vector<double>& x) {
    const Eigen::VectorXd theta = Eigen::Map<const Eigen::VectorXd>(x.data(), n);
    const auto point = problem.evaluate(theta);
    const double value = point ? std::log(std::max(point->cost, kLeastCost)) : kInfeasible;
    ++seen.tried;
    if (point) seen.stable.push_back({value, theta});
    return value;
  };
  using Objective = decltype(objective);
  crs.set_min_objective([](const std::vector<double>& x, std::vector<double>&,
                           void* data) { return (*static_cast<const Objective*>(data))(x); },
                        const_cast<void*>(static_cast<const void*>(&objective)));
  std::vector<double> x = box.start;
  double least = 0.0;
  try {
    crs.optimize(x, least);
  } catch (const nlopt::roundoff_limited&) {
    // The population has collapsed onto one point; the points tried so far count.
  }
  return seen;
}

/// The stable points that all populations tried, population by population.
Explored explore(const OutputError& problem, const SearchBox& box, std::uint64_t seed, const Executor& executor) {
  std::vector<Explored> populations(kPopulations);
  // NLopt takes 32 bits of a seed.
  std::seed_seq mixed{static_cast<std::uint32_t>(seed), static_cast<std::uint32_t>(seed >> 32U)};
  std::array<std::uint32_t, kPopulations> seeds{};
  mixed.generate(seeds.begin(), seeds.end());
  executor(kPopulations, [&](std::size_t k) { populations[k] = look_around(problem, box, seeds[k]); });
  Explored seen;
  for (Explored& population : populations) {
    std::move(population.stable.begin(), population.stable.end(), std::back_inserter(seen.stable));
    seen.tried += population.tried;
  }
  return seen;
}

/// The stable guesses.
std::vector<Seen> evaluated(const OutputError& problem, const std::vector<Eigen::VectorXd>& guesses) {
  std::vector<Seen> seen;
  for (const Eigen::VectorXd& theta : guesses) {
    const auto point = problem.evaluate(theta);
    if (point) seen.push_back({std::log(std::max(point->cost, kLeastCost)), theta});
  }
  return seen;
}

/// The points of least cost. @param distinct  least distance of two
std::vector<Eigen::VectorXd> best_of(std::vector<Seen>& points, std::size_t most, const SearchBox& box,
                                     double distinct) {
  std::stable_sort(points.begin(), points.end(), [](const Seen& a, const Seen& b) { return a.log_cost < b.log_cost; });
  std::vector<Eigen::VectorXd> best;
  for (const Seen& point : points) {
    if (best.size() == most) break;
    const bool repeats = std::any_of(best.begin(), best.end(), [&](const Eigen::VectorXd& other) {
      return box.distance(point.theta, other) < distinct;
    });
    if (!repeats) best.push_back(point.theta);
  }
  return best;
}

/// A round of a race between searches from many starts: those that cost far more than the best one drop out. In a
/// sparsely covered box none does.
struct Heat {
  std::size_t simulations;                                     ///< of each search in this round
  std::size_t least;                                           ///< that go on, however much they cost
  double behind;                                               ///< times the least cost; what costs more drops out
  std::size_t most = std::numeric_limits<std::size_t>::max();  ///< that go on, however little they cost
};
// The cost of a start says little; that of ten steps nearly all. Where all costs are alike all go on.
constexpr std::array<Heat, 4> kHeats = {{{5, 10, 10.0}, {5, 5, 4.0}, {10, 2, 1.5}, {20, 2, 1.5}}};
// Of poles the cost of a start says more, of poles and a delay somewhat. Where all costs are near, 6 and 8 go on: of
// the 43 records of tests/answers none changed; with 4 and 6 one did.
constexpr Heat kOfPoles = {0, 3, 30.0, 6};
constexpr Heat kOfPolesAndDelay = {0, 4, 30.0, 8};
constexpr LeastSquaresOptions kRough{.max_evaluations = 80, .cost_tolerance = 1e-7, .step_tolerance = 1e-6};

/// Searches on from each, roughly.
void proceed_with_all(const OutputError& problem, std::vector<LeastSquaresResult>& searches, std::size_t simulations,
                      const Executor& executor) {
  LeastSquaresOptions rough = kRough;
  rough.max_evaluations = simulations;
  executor(searches.size(), [&](std::size_t k) {
    if (!has_converged(searches[k].termination)) proceed(problem, searches[k], rough);
  });
}

/// Keeps the feasible searches, of near ones that of least cost, and counts the work of the others.
/// @param distinct  least distance of two
void keep_distinct(std::vector<LeastSquaresResult>& searches, const SearchBox& box, double distinct, Work& left) {
  std::stable_sort(searches.begin(), searches.end(), has_less_cost);
  std::vector<LeastSquaresResult> kept;
  for (LeastSquaresResult& search : searches) {
    const bool repeats = std::any_of(kept.begin(), kept.end(), [&](const LeastSquaresResult& other) {
      return box.distance(search.theta, other.theta) < distinct;
    });
    if (repeats || search.termination == Termination::infeasible) {
      left += search.work;
    } else {
      kept.push_back(std::move(search));
    }
  }
  searches = std::move(kept);
}

/// What the costs of the starts let go on; nothing where orders or a map are searched.
std::optional<Heat> heat_of_starts(const Parametrisation& parametrisation) {
  Heat heat = kOfPoles;
  for (const Coordinate& c : parametrisation.coordinates()) {
    switch (c.role) {
      case CoordinateRole::weighted_denominator:
      case CoordinateRole::section_frequency:
      case CoordinateRole::section_damping:
      case CoordinateRole::input_bias:
        break;
      case CoordinateRole::delay:
        heat = kOfPolesAndDelay;
        break;
      default:
        return std::nullopt;
    }
  }
  return heat;
}

/// Leaves the searches that a heat lets go on. @param searches  the best first
void drop_beaten(std::vector<LeastSquaresResult>& searches, const Heat& heat, Work& left) {
  std::size_t go_on = std::min(searches.size(), heat.most);
  while (go_on > heat.least && searches[go_on - 1].point.cost > heat.behind * searches.front().point.cost) --go_on;
  for (std::size_t k = go_on; k < searches.size(); ++k) left += searches[k].work;
  searches.resize(go_on);
}

/// Leaves the best search and those that may still overtake it. @param searches  the best first
void drop_overtaken(std::vector<LeastSquaresResult>& searches, Work& left) {
  const double least = searches.empty() ? 0.0 : searches.front().point.cost;
  std::size_t index = 0;
  std::erase_if(searches, [&](const LeastSquaresResult& search) {
    const bool is_near = search.point.cost <= kNearBest * least;
    const bool drops = index++ > 0 && is_near && search.predicted_cost > (1.0 - kSameCost) * least;
    if (drops) left += search.work;
    return drops;
  });
}

/// Feasible optima, the best first, without repetitions.
std::vector<LeastSquaresResult> distinct_optima(std::vector<LeastSquaresResult> polished) {
  std::erase_if(polished, [](const LeastSquaresResult& p) { return p.termination == Termination::infeasible; });
  std::stable_sort(polished.begin(), polished.end(), [](const LeastSquaresResult& a, const LeastSquaresResult& b) {
    return a.point.cost < b.point.cost;
  });
  std::vector<LeastSquaresResult> optima;
  for (LeastSquaresResult& p : polished) {
    if (!optima.empty() && p.point.cost <= optima.back().point.cost * (1.0 + kSameCost)) continue;
    optima.push_back(std::move(p));
  }
  return optima;
}

}  // namespace

bool is_thinly_covered(const Parametrisation& parametrisation) {
  return parametrisation.weight_count() > kMostCoveredWeights;
}

double output_bandwidth(const Eigen::VectorXd& output) {
  const auto n = static_cast<std::size_t>(output.size()) - 1;
  const RealFft fft(fast_length(n));
  std::vector<double> signal(fft.length(), 0.0);
  for (std::size_t k = 0; k < n; ++k) {
    const double window =
        0.5 - 0.5 * std::cos(2.0 * std::numbers::pi * (static_cast<double>(k) + 0.5) / static_cast<double>(n));
    signal[k] = window * (output[static_cast<Eigen::Index>(k) + 1] - output[static_cast<Eigen::Index>(k)]);
  }
  std::vector<std::complex<double>> spectrum(fft.bins());
  fft.forward(signal, spectrum);
  // The increments are integrated back. The power of the quietest band counts as white sensor noise and is removed.
  std::vector<double> differenced(fft.bins(), 1.0);
  for (std::size_t j = 1; j < fft.bins(); ++j) {
    const double half = std::sin(std::numbers::pi * static_cast<double>(j) / static_cast<double>(fft.length()));
    differenced[j] = 4.0 * half * half;
  }
  double noise = std::numeric_limits<double>::infinity();
  const std::size_t width = fft.bins() / kNoiseBands;
  for (std::size_t band = 0; band < kNoiseBands && width > 0; ++band) {
    double sum = 0.0;
    for (std::size_t j = std::max<std::size_t>(1, band * width); j < (band + 1) * width; ++j) {
      sum += std::norm(spectrum[j]) / differenced[j];
    }
    noise = std::min(noise, sum / static_cast<double>(width));
  }
  if (width < kNoiseBands) noise = 0.0;  // too few bins a band to average
  std::vector<double> power(fft.bins(), 0.0);
  double total = 0.0;
  for (std::size_t j = 1; j < fft.bins(); ++j) {
    power[j] = (std::norm(spectrum[j]) - noise * differenced[j]) / static_cast<double>(j);
    total += power[j];
  }
  double above = 0.0;
  std::size_t j = fft.bins() - 1;
  while (j > 1 && above + power[j] < kLostPower * total) above += power[j--];
  return static_cast<double>(j) / static_cast<double>(fft.length());
}

std::size_t search_spacing(double bandwidth, std::size_t last) {
  const double by_length = static_cast<double>(last + 1) / kCoarseRows;
  const double by_bandwidth = kPassedByFilter / std::max(bandwidth, 1e-9);
  return static_cast<std::size_t>(std::max(1.0, std::floor(std::min(by_length, by_bandwidth))));
}

std::vector<CoarseRecord> coarsen(const Record& record, double bandwidth, std::size_t first, std::size_t last) {
  const auto rows = static_cast<double>(last + 1);
  const double by_length = rows / kCoarseRows;
  const double by_bandwidth = 0.1 / std::max(bandwidth, 1e-9);
  const auto wanted = static_cast<std::size_t>(std::max(1.0, std::floor(std::min(by_length, by_bandwidth))));
  const auto affordable = static_cast<std::size_t>(std::max(1.0, std::ceil(rows / kMostCoarseRows)));
  std::vector<CoarseRecord> all = {blocks(record, 0, last, first, std::max(wanted, affordable))};
  if (wanted >= affordable) return all;
  const auto length = static_cast<std::size_t>(kMostCoarseRows) * wanted;
  const double at_rest = record.input[0];
  std::size_t begin = 0;
  while (begin + length <= last && record.input[static_cast<Eigen::Index>(begin)] == at_rest) ++begin;
  const std::size_t compared = std::max(begin, first);
  all.push_back(blocks(record, begin, std::min(last, compared + length), compared, wanted));
  return all;
}

LeastSquaresResult minimise_from_afar(const OutputError& problem, const Eigen::VectorXd& start) {
  const auto& coordinates = problem.parametrisation().coordinates();
  LeastSquaresResult first = minimise(problem, with_scanned_coefficients(problem, start));
  if (first.termination == Termination::infeasible) return first;
  Eigen::VectorXd again = first.theta;
  bool ended = first.termination == Termination::evaluation_limit;
  for (std::size_t l = 0; l < coordinates.size(); ++l) {
    const Coordinate& c = coordinates[l];
    if (c.role != CoordinateRole::denominator_order) continue;
    const auto i = static_cast<Eigen::Index>(l);
    const double slack = kAtItsEnd * (c.upper - c.lower);
    ended = ended || again[i] < c.lower + slack || again[i] > c.upper - slack;
    again[i] = 0.5 * (c.search_lower + c.search_upper);
  }
  if (!ended) return first;
  LeastSquaresResult second = minimise(problem, with_scanned_coefficients(problem, again));
  Work work = first.work;
  work += second.work;
  const bool better = second.termination != Termination::infeasible && second.point.cost < first.point.cost;
  LeastSquaresResult& kept = better ? second : first;
  kept.work = work;
  return std::move(kept);
}

SearchResult polished(const OutputError& problem, const std::vector<Eigen::VectorXd>& starts, Wanted wanted,
                      const Executor& executor) {
  const SearchBox box(problem.parametrisation().coordinates());
  std::vector<LeastSquaresResult> searches(starts.size());
  executor(starts.size(), [&](std::size_t k) { searches[k] = begun(problem, starts[k]); });
  SearchResult result;
  keep_distinct(searches, box, kSameBasin, result.work);
  const bool is_thin = is_thinly_covered(problem.parametrisation());
  const std::optional<Heat> of_starts = heat_of_starts(problem.parametrisation());
  if (!is_thin && of_starts) drop_beaten(searches, *of_starts, result.work);
  for (const Heat& heat : kHeats) {
    proceed_with_all(problem, searches, heat.simulations, executor);
    keep_distinct(searches, box, kSameBasin, result.work);
    if (is_thin) continue;
    drop_beaten(searches, heat, result.work);
    if (wanted == Wanted::best) drop_overtaken(searches, result.work);
  }
  proceed_with_all(problem, searches, kRough.max_evaluations, executor);
  for (const LeastSquaresResult& search : searches) result.work += search.work;
  result.optima = distinct_optima(std::move(searches));
  return result;
}

SearchResult search(const OutputError& problem, const std::vector<Eigen::VectorXd>& guesses, std::uint64_t seed,
                    const Executor& executor) {
  SearchResult result;
  if (problem.parametrisation().coordinates().empty()) {
    result.optima.push_back(minimise(problem, Eigen::VectorXd()));
    result.work = result.optima.front().work;
    return result;
  }
  const SearchBox box(problem.parametrisation().coordinates());
  Explored seen = explore(problem, box, seed, executor);
  std::vector<Eigen::VectorXd> starts = best_of(seen.stable, kPolished, box, kDistinct);
  std::vector<Seen> guessed = evaluated(problem, guesses);
  for (Eigen::VectorXd& guess : best_of(guessed, kGuessesPolished, box, kDistinctGuess)) {
    starts.push_back(std::move(guess));
  }
  result = polished(problem, starts, Wanted::distinct, executor);
  result.work.global_searches = 1;
  result.work += problem.evaluation_work(seen.tried + guesses.size());
  return result;
}

}  // namespace eha::ident
