// SPDX-License-Identifier: GPL-3.0-or-later
#include "ident/fractional/held_response.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <mutex>
#include <numbers>
#include <optional>
#include <utility>

#include "ident/signal/low_band_spectrum.hpp"
#include "ident/vector_clones.hpp"

namespace eha::ident {
namespace {

using std::numbers::pi;
using Complex = std::complex<double>;

// The wrap-around is damped by rho^L; rounding errors are amplified by rho^-N.
constexpr double kWrapAround = 1e-10;
// A filter's stopband below this is left out of the sum; the response there has fallen by a similar factor.
constexpr double kStopband = 1e-6;
constexpr double kNegligible =
    1e-2;  // share of an alias's allowed error; smaller coefficients of its series are left out
constexpr double kAliasAccuracy = 0.03;  // of their sum, as a share of their allowed error
// A ladder simulates at the compared rows, at every row, and with a past of one length or another.
constexpr std::size_t kMostKept = 6;
constexpr std::size_t kMostKeptEffort = 1'000'000;  // points; 64 MB of tables
constexpr std::size_t kMostBinsOfFurther = 65'536;  // of each alias beyond the first; 25 MB of tables

/// Adds real and imaginary part of S at x by Clenshaw's recurrence in T_2(x), over all bins.
/// @param step  of x from bin to bin
EHA_VECTOR_CLONES
void add_series(const std::vector<double>& a, double step, double negligible, std::size_t bins, double* re,
                double* im) {
  std::size_t used = 0;
  for (std::size_t n = 0; n < a.size(); ++n) {
    if (std::abs(a[n]) > negligible) used = n + 1;
  }
  if (used == 0) return;
  const std::size_t pairs = (used + 1) / 2;
  constexpr std::size_t kBlock = 256;
  double y2[kBlock];
  double even1[kBlock];
  double even2[kBlock];
  double odd1[kBlock];
  double odd2[kBlock];
  for (std::size_t start = 0; start < bins; start += kBlock) {
    const std::size_t n = std::min(kBlock, bins - start);
    for (std::size_t i = 0; i < n; ++i) {
      const double x = step * static_cast<double>(start + i);
      y2[i] = 2.0 * (2.0 * x * x - 1.0);
      even1[i] = even2[i] = odd1[i] = odd2[i] = 0.0;
    }
    for (std::size_t m = pairs; m-- > 0;) {
      const double even = a[2 * m];
      const double odd = 2 * m + 1 < a.size() ? a[2 * m + 1] : 0.0;
      for (std::size_t i = 0; i < n; ++i) {
        const double next = even + y2[i] * even1[i] - even2[i];
        even2[i] = even1[i];
        even1[i] = next;
        const double next_odd = odd + y2[i] * odd1[i] - odd2[i];
        odd2[i] = odd1[i];
        odd1[i] = next_odd;
      }
    }
    // b_0 - y b_1 for the even series, x (b_0 - b_1) for the odd one.
    for (std::size_t i = 0; i < n; ++i) {
      const double x = step * static_cast<double>(start + i);
      re[start + i] += even1[i] - 0.5 * y2[i] * even2[i];
      im[start + i] += x * (odd1[i] - odd2[i]);
    }
  }
}

/// Returns the input's increment at each sample times decay(n) = rho^n as on the contour; zeros from `samples` up to
/// `length`.
template <typename Decay>
std::vector<double> increments(const Eigen::Ref<const Eigen::VectorXd>& input, std::size_t samples, std::size_t length,
                               const Decay& decay) {
  std::vector<double> damped(length, 0.0);
  double before = 0.0;
  for (std::size_t n = 0; n < samples; ++n) {
    const double now = input[static_cast<Eigen::Index>(n)];
    damped[n] = (now - before) * decay(n);
    before = now;
  }
  return damped;
}

/// Number of lowest bins of a transform of `length` above which a filter passes less than kStopband; all without one.
std::size_t passing_bins(const std::vector<double>& taps, std::size_t length) {
  if (taps.empty()) return length;
  constexpr std::size_t kOversampled = 16;  // the lobes of the stopband are a bin of the taps' own transform wide
  const std::size_t grid = fast_length(kOversampled * taps.size());
  std::vector<double> padded(taps);
  padded.resize(grid, 0.0);
  InputSpectrum passed(grid / 2 + 1);
  RealFft(grid).forward(padded, passed);
  std::size_t end = passed.size();
  while (end > 1 && std::abs(passed[end - 1]) < kStopband) --end;
  // The next point of the grid is in the stopband.
  return length * end / grid + 1;
}

/// Index of the last of some bins, at least 1: the band of their angles is not empty.
std::size_t last_bin(std::size_t bins) { return std::max<std::size_t>(bins - 1, 1); }

/// Transform of a symmetric filter that is delayed by half its length, damped as on the contour.
InputSpectrum filter_spectrum(const std::vector<double>& taps, std::size_t length, std::size_t bins, double sigma) {
  const std::size_t middle = taps.size() / 2;
  const auto half = static_cast<double>(middle);
  std::vector<double> damped(taps);
  for (std::size_t m = 0; m < taps.size(); ++m) damped[m] *= std::exp(-sigma * (static_cast<double>(m) - half));
  return LowBandSpectrum(length, taps.size(), bins)(std::move(damped));
}

}  // namespace

struct HeldResponse::Scratch {
  std::vector<double> re;  ///< columns by bins
  std::vector<double> im;
};

/// One column of F, and its direct part at a jump.
struct HeldResponse::Column {
  const double* re;
  const double* im;
  double direct;   ///< G(infinity)
  double jump_at;  ///< sample at which a jump of the direct part shows
};

struct HeldResponse::Aliases {
  struct Points {
    LaplacePoints points;
    std::vector<Complex> inverse;  ///< 1/p
  };
  std::once_flag nearest_made;
  std::once_flag further_made;
  std::array<Points, 2 * AliasSum::kExplicitAliases + 1> all;  ///< of k at k + kExplicitAliases, none of 0

  static Points at(int k, std::size_t bins, std::size_t length, double sigma, double step_s) {
    Points all;
    all.inverse.reserve(bins);
    for (std::size_t j = 0; j < bins; ++j) {
      const Complex p(sigma, 2.0 * pi * (static_cast<double>(j) / static_cast<double>(length) + k));
      all.points.add(p.real() / step_s, p.imag() / step_s);
      all.inverse.push_back(1.0 / p);
    }
    return all;
  }
};

struct HeldResponse::QuickTables {
  static constexpr std::size_t kBlock = 1024;
  static constexpr std::size_t kEdgeHalvings = 3;  // more make the windows that cross an edge dearer than the rest
  std::once_flag made;
  std::optional<LowBandSpectrum> low_band;
  LowBandSpectrum::FirstHalvings at_edges;
  std::vector<double> within;  ///< rho^i, i < kBlock: with `blocks` as good as a table of every rho^n
  std::vector<double> blocks;  ///< rho^(kBlock i)
};

HeldResponse::HeldResponse(const OutputSelection& selection, double guard)
    : selection_(selection),
      length_(
          fast_length(static_cast<std::size_t>(guard * static_cast<double>(selection.samples)) + 16, selection.every)),
      sigma_(-std::log(kWrapAround) / static_cast<double>(length_)),
      bins_(std::min(length_ / 2 + 1, passing_bins(selection_.filter_taps, length_))),
      aliases_(sigma_, selection.step_s, 2.0 * pi * static_cast<double>(last_bin(bins_)) / static_cast<double>(length_),
               kAliasAccuracy * selection.resolved),
      short_fft_(length_ / selection.every),
      nearest_(std::make_shared<Aliases>()),
      quick_(std::make_shared<QuickTables>()) {
  const auto length = static_cast<double>(length_);
  InputSpectrum factor;
  if (selection_.filter_taps.empty()) {
    factor.assign(bins_, 1.0);
  } else {
    factor = filter_spectrum(selection_.filter_taps, length_, bins_, sigma_);
  }
  inverse_re_.resize(bins_);
  inverse_im_.resize(bins_);
  for (std::size_t j = 0; j < bins_; ++j) {
    const double theta = 2.0 * pi * static_cast<double>(j) / length;
    points_.add(sigma_ / selection_.step_s, theta / selection_.step_s);
    const Complex inverse = 1.0 / Complex(sigma_, theta);
    inverse_re_[j] = inverse.real();
    inverse_im_[j] = inverse.imag();
    // The shift's angle is reduced in integers: the sine of a double is not accurate for large j * first. The filter is
    // symmetric about the output.
    const std::size_t shift = selection_.first + selection_.filter_taps.size() / 2;
    const double turn = static_cast<double>((j * shift) % length_) / length;
    factor[j] *= std::polar(1.0, 2.0 * pi * turn);
  }
  selection_factor_ = std::move(factor);
  growth_.resize(static_cast<Eigen::Index>(selection_.count));
  for (Eigen::Index m = 0; m < growth_.size(); ++m) {
    const auto n = static_cast<double>(selection_.first + static_cast<std::size_t>(m) * selection_.every);
    growth_[m] = std::exp(sigma_ * n) / length;
  }
}

std::shared_ptr<const HeldResponse> HeldResponse::of(const OutputSelection& selection) {
  static std::mutex looking;
  static std::vector<std::shared_ptr<const HeldResponse>> kept;
  if (effort_of(selection.samples, kDefaultGuard) > kMostKeptEffort) {
    return std::make_shared<const HeldResponse>(selection);
  }
  // Made under the lock, so that two callers at once make it once.
  const std::scoped_lock lock(looking);
  auto found = std::find_if(kept.begin(), kept.end(), [&](const auto& one) { return one->selection_ == selection; });
  if (found == kept.end()) {
    if (kept.size() == kMostKept) kept.erase(kept.begin());
    found = kept.emplace(kept.end(), std::make_shared<const HeldResponse>(selection));
  }
  std::rotate(found, found + 1, kept.end());
  return kept.back();
}

std::size_t HeldResponse::effort_of(std::size_t samples, double guard) {
  const std::size_t length = fast_length(static_cast<std::size_t>(guard * static_cast<double>(samples)) + 16);
  return length / 2 + 1 + length;
}

void HeldResponse::weigh(InputSpectrum& spectrum) const {
  spectrum.resize(bins_);
  for (std::size_t j = 0; j < bins_; ++j) spectrum[j] *= selection_factor_[j];
}

const HeldResponse::QuickTables& HeldResponse::quick_tables() const {
  constexpr std::size_t kBlock = QuickTables::kBlock;
  std::call_once(quick_->made, [&] {
    quick_->low_band.emplace(length_, selection_.samples, bins_);
    quick_->at_edges = quick_->low_band->first_halvings(QuickTables::kEdgeHalvings);
    for (std::size_t i = 0; i < kBlock; ++i) quick_->within.push_back(std::exp(-sigma_ * static_cast<double>(i)));
    for (std::size_t n = 0; n < selection_.samples; n += kBlock) {
      quick_->blocks.push_back(std::exp(-sigma_ * static_cast<double>(n)));
    }
  });
  return *quick_;
}

InputSpectrum HeldResponse::quick_input_spectrum(const Eigen::Ref<const Eigen::VectorXd>& input) const {
  constexpr std::size_t kBlock = QuickTables::kBlock;
  const QuickTables& tables = quick_tables();
  InputSpectrum spectrum =
      (*tables.low_band)(increments(input, selection_.samples, selection_.samples, [&](std::size_t n) {
        return tables.blocks[n / kBlock] * tables.within[n % kBlock];
      }));
  weigh(spectrum);
  return spectrum;
}

EdgeThinning HeldResponse::edge_thinning(const Eigen::Ref<const Eigen::VectorXd>& input, std::size_t before) const {
  const LowBandSpectrum::FirstHalvings& first = quick_tables().at_edges;
  Thinning thinning;
  thinning.every = std::size_t{1} << first.halvings;
  thinning.first = -static_cast<std::ptrdiff_t>(before);
  // The taps act on increments that are damped by rho^n = rho^(n of the output) rho^(-t).
  thinning.taps.assign(first.taps.size() + 1, 0.0);
  for (std::size_t t = 0; t < first.taps.size(); ++t) {
    const double damped = first.taps[t] * std::exp(sigma_ * static_cast<double>(t));
    thinning.taps[t] += damped;
    thinning.taps[t + 1] -= damped;
  }
  for (std::size_t k = 0; k < first.outputs; ++k) {
    thinning.weights.push_back(std::exp(-sigma_ * static_cast<double>(k * thinning.every)));
  }
  return {input.head(std::min(input.size(), static_cast<Eigen::Index>(selection_.samples - before))),
          std::move(thinning)};
}

InputSpectrum HeldResponse::thinned_input_spectrum(const Eigen::VectorXd& thinned) const {
  const QuickTables& tables = quick_tables();
  InputSpectrum spectrum =
      tables.low_band->after(tables.at_edges.halvings, std::vector<double>(thinned.begin(), thinned.end()));
  weigh(spectrum);
  return spectrum;
}

InputSpectrum HeldResponse::input_spectrum(const Eigen::Ref<const Eigen::VectorXd>& input) const {
  const std::vector<double> damped = increments(
      input, selection_.samples, length_, [&](std::size_t n) { return std::exp(-sigma_ * static_cast<double>(n)); });
  InputSpectrum spectrum(length_ / 2 + 1);
  RealFft(length_).forward(damped, spectrum);
  weigh(spectrum);
  return spectrum;
}

InputSpectrum HeldResponse::step_spectrum(std::size_t at) const {
  InputSpectrum spectrum(bins_);
  const double size = std::exp(-sigma_ * static_cast<double>(at));
  for (std::size_t j = 0; j < bins_; ++j) {
    const double turn = static_cast<double>((j * at) % length_) / static_cast<double>(length_);
    spectrum[j] = std::polar(size, -2.0 * pi * turn);
  }
  weigh(spectrum);
  return spectrum;
}

void HeldResponse::add_near_aliases(const TransferColumns& columns, double x, int aliases, Scratch& scratch) const {
  std::vector<double> re(bins_ * columns.columns());
  std::vector<double> im(re.size());
  constexpr int kMiddle = AliasSum::kExplicitAliases;
  const auto make = [&](int k) {
    nearest_->all[static_cast<std::size_t>(k + kMiddle)] = Aliases::at(k, bins_, length_, sigma_, selection_.step_s);
  };
  const auto make_further = [&] {
    for (int k = 2; k <= kMiddle; ++k) {
      make(k);
      make(-k);
    }
  };
  std::call_once(nearest_->nearest_made, [&] {
    make(1);
    make(-1);
  });
  const bool keeps_further = bins_ <= kMostBinsOfFurther;
  if (aliases > 1 && keeps_further) std::call_once(nearest_->further_made, make_further);
  for (int k = -aliases; k <= aliases; ++k) {
    if (k == 0) continue;
    const bool is_kept = std::abs(k) == 1 || keeps_further;
    const Aliases::Points made =
        is_kept ? Aliases::Points() : Aliases::at(k, bins_, length_, sigma_, selection_.step_s);
    const Aliases::Points& at = is_kept ? nearest_->all[static_cast<std::size_t>(k + kMiddle)] : made;
    const Complex factor = std::polar(1.0, -2.0 * pi * k * x);
    columns.evaluate(at.points, 0, bins_, re.data(), im.data(), bins_);
    for (std::size_t c = 0; c < columns.columns(); ++c) {
      for (std::size_t j = 0; j < bins_; ++j) {
        const Complex f = Complex(re[c * bins_ + j] - columns.direct(c), im[c * bins_ + j]) * (factor * at.inverse[j]);
        scratch.re[c * bins_ + j] += f.real();
        scratch.im[c * bins_ + j] += f.imag();
      }
    }
  }
}

/// F(p) = (G(p) - G(infinity))/p at every bin.
HeldResponse::Scratch HeldResponse::main_columns(const TransferColumns& columns) const {
  const std::size_t count = columns.columns();
  Scratch main{std::vector<double>(bins_ * count), std::vector<double>(bins_ * count)};
  columns.evaluate(points_, 0, bins_, main.re.data(), main.im.data(), bins_);
  for (std::size_t c = 0; c < count; ++c) {
    double* re = main.re.data() + c * bins_;
    double* im = main.im.data() + c * bins_;
    const double direct = columns.direct(c);
    for (std::size_t j = 0; j < bins_; ++j) {
      const double g_re = re[j] - direct;
      const double g_im = im[j];
      re[j] = g_re * inverse_re_[j] - g_im * inverse_im_[j];
      im[j] = g_re * inverse_im_[j] + g_im * inverse_re_[j];
    }
  }
  return main;
}

/// Adds the aliases. They are smooth in theta unless a sharp resonance lies beyond the Nyquist frequency; then the near
/// ones are summed at every bin.
void HeldResponse::add_aliases(const TransferColumns& columns, double x, Scratch& main) const {
  const std::size_t count = columns.columns();
  std::vector<double> scale(count);
  for (std::size_t c = 0; c < count; ++c) {
    for (std::size_t j = 0; j < bins_; ++j) {
      scale[c] = std::max(scale[c], std::abs(main.re[c * bins_ + j]) + std::abs(main.im[c * bins_ + j]));
    }
    scale[c] *= sigma_;
  }
  std::vector<AliasSum::Series> series = aliases_.evaluate(columns, x, 0);
  int near_aliases = 0;
  for (std::size_t c = 0; c < count; ++c) {
    for (const double a : series[c].a) scale[c] = std::max(scale[c], std::abs(a));
    if (series[c].unresolved_first > selection_.resolved * scale[c]) near_aliases = std::max(near_aliases, 1);
    if (series[c].unresolved_further > selection_.resolved * scale[c]) near_aliases = AliasSum::kExplicitAliases;
  }
  if (near_aliases > 0) {
    add_near_aliases(columns, x, near_aliases, main);
    series = aliases_.evaluate(columns, x, near_aliases);
  }
  for (std::size_t c = 0; c < count; ++c) {
    add_series(series[c].a, 1.0 / static_cast<double>(last_bin(bins_)), kNegligible * selection_.resolved * scale[c],
               bins_, main.re.data() + c * bins_, main.im.data() + c * bins_);
  }
}

/// exp(-p delay) at every bin; empty for no delay. The delay is `whole` + `x` samples.
std::vector<std::complex<double>> HeldResponse::delay_factors(double delay, double whole, double x) const {
  std::vector<Complex> shift;
  if (delay == 0.0) return shift;
  shift.resize(bins_);
  const auto samples = static_cast<std::size_t>(whole);
  const auto length = static_cast<double>(length_);
  for (std::size_t j = 0; j < bins_; ++j) {
    const double turn = (static_cast<double>((j * samples) % length_) + x * static_cast<double>(j)) / length;
    shift[j] = std::polar(std::exp(-sigma_ * delay), -2.0 * pi * turn);
  }
  return shift;
}

/// The spectrum of one response, folded to the requested outputs.
void HeldResponse::fold(const Column& column, const InputSpectrum& input, const std::vector<Complex>& shift,
                        std::vector<Complex>& folded) const {
  const std::size_t short_length = short_fft_.length();
  std::fill(folded.begin(), folded.end(), 0.0);
  std::size_t q = 0;
  for (std::size_t j = 0; j < bins_; ++j) {
    double f_re = column.re[j];
    double f_im = column.im[j];
    if (!shift.empty()) {
      const double s_re = shift[j].real();
      const double s_im = shift[j].imag();
      const double product_re = f_re * s_re - f_im * s_im;
      f_im = f_re * s_im + f_im * s_re;
      f_re = product_re;
    }
    if (column.direct != 0.0) {
      const Complex p(sigma_, 2.0 * pi * static_cast<double>(j) / static_cast<double>(length_));
      const Complex step = column.direct * std::exp(-column.jump_at * p) / (1.0 - std::exp(-p));
      f_re += step.real();
      f_im += step.imag();
    }
    const double u_re = input[j].real();
    const double u_im = input[j].imag();
    const Complex y(f_re * u_re - f_im * u_im, f_re * u_im + f_im * u_re);
    // Outputs are `every` samples apart: bins that differ by the short length coincide, L - j by symmetry.
    if (q <= short_length / 2) folded[q] += y;
    const std::size_t mirror = q == 0 ? 0 : short_length - q;
    if (j != 0 && 2 * j != length_ && mirror <= short_length / 2) folded[mirror] += std::conj(y);
    if (++q == short_length) q = 0;
  }
}

Eigen::MatrixXd HeldResponse::respond(const TransferColumns& columns, double delay_s,
                                      std::span<const ResponseRequest> requests) const {
  const double delay = delay_s / selection_.step_s;
  const double whole = std::round(delay);
  const double x = delay - whole;
  Scratch main = main_columns(columns);
  add_aliases(columns, x, main);
  const std::vector<Complex> shift = delay_factors(delay, whole, x);

  std::vector<Complex> folded(short_fft_.bins());
  std::vector<double> output(short_fft_.length());
  Eigen::MatrixXd responses(static_cast<Eigen::Index>(selection_.count), static_cast<Eigen::Index>(requests.size()));
  for (std::size_t r = 0; r < requests.size(); ++r) {
    const ResponseRequest& request = requests[r];
    // A jump of the direct part reaches the sample at which it happens, or the next one.
    const double jump_at = request.at_jump == AtJump::after ? std::ceil(delay) : std::floor(delay) + 1.0;
    fold({main.re.data() + request.column * bins_, main.im.data() + request.column * bins_,
          columns.direct(request.column), jump_at},
         *request.input, shift, folded);
    short_fft_.inverse(folded, output);
    for (std::size_t m = 0; m < selection_.count; ++m) {
      responses(static_cast<Eigen::Index>(m), static_cast<Eigen::Index>(r)) =
          output[m] * growth_[static_cast<Eigen::Index>(m)];
    }
  }
  return responses;
}

}  // namespace eha::ident
