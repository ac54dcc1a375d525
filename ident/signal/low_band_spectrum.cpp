// SPDX-License-Identifier: GPL-3.0-or-later
#include "ident/signal/low_band_spectrum.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "ident/vector_clones.hpp"

namespace eha::ident {
namespace {

using std::numbers::pi;
using Complex = std::complex<double>;

constexpr double kAliased = 1e-11;
constexpr int kMostTaps = 20;  // a filter this long no longer pays

/// Taps of ((1 + z^-1)/2)^power.
std::vector<double> binomial(int power) {
  std::vector<double> taps = {1.0};
  for (int k = 0; k < power; ++k) {
    taps.push_back(0.0);
    for (std::size_t t = taps.size(); t-- > 0;) taps[t] = 0.5 * (taps[t] + (t > 0 ? taps[t - 1] : 0.0));
  }
  return taps;
}

/// to[k] += tap from[k]
EHA_VECTOR_CLONES
void add_scaled(const double* from, double tap, std::size_t count, double* to) {
  for (std::size_t k = 0; k < count; ++k) to[k] += tap * from[k];
}

/// to[k] += taps[0] a[k] + taps[1] b[k] + taps[2] a[k - 1] + taps[3] b[k - 1], in one pass over `to`.
EHA_VECTOR_CLONES
void add_four(const double* a, const double* b, const double* taps, std::size_t count, double* to) {
  const double t0 = taps[0];
  const double t1 = taps[1];
  const double t2 = taps[2];
  const double t3 = taps[3];
  const double* earlier_a = a - 1;
  const double* earlier_b = b - 1;
  for (std::size_t k = 0; k < count; ++k) to[k] += t0 * a[k] + t1 * b[k] + (t2 * earlier_a[k] + t3 * earlier_b[k]);
}

/// Length of the signal that halved() returns.
std::size_t halved_length(std::size_t samples, std::size_t taps) { return (samples + taps) / 2; }

/// out[k] = sum_t taps[t] signal[2 k - t]
std::vector<double> halved(std::vector<double> signal, const std::vector<double>& taps) {
  const std::size_t before = taps.size() / 2;
  const std::size_t count = halved_length(signal.size(), taps.size());
  std::vector<double> even(before + count, 0.0);  // signal[2 k]
  std::vector<double> odd(before + count, 0.0);   // signal[2 k - 1]
  for (std::size_t n = 0; n < signal.size(); n += 2) even[before + n / 2] = signal[n];
  for (std::size_t n = 1; n < signal.size(); n += 2) odd[before + (n + 1) / 2] = signal[n];
  signal = {};  // of 10^7 rows, perhaps
  std::vector<double> out(count, 0.0);
  constexpr std::size_t kBlock = 512;  // stays in the cache for all taps
  for (std::size_t begin = 0; begin < count; begin += kBlock) {
    const std::size_t block = std::min(kBlock, count - begin);
    const auto from = [&](const std::vector<double>& half, std::size_t t) {
      return half.data() + before + begin - t / 2;
    };
    std::size_t t = 0;
    for (; t + 4 <= taps.size(); t += 4) {
      add_four(from(even, t), from(odd, t), taps.data() + t, block, out.data() + begin);
    }
    for (; t < taps.size(); ++t) add_scaled(from(t % 2 == 0 ? even : odd, t), taps[t], block, out.data() + begin);
  }
  return out;
}

}  // namespace

LowBandSpectrum::LowBandSpectrum(std::size_t length, std::size_t samples, std::size_t bins)
    : samples_(samples), length_(length), undo_(bins, 1.0) {
  while (length_ % 2 == 0) {
    // A bin's alias lies as far below the Nyquist frequency as the bin lies above 0.
    const double alias = std::tan(pi * static_cast<double>(bins) / static_cast<double>(length_));
    if (!(alias > 0.0 && alias < 1.0)) break;
    const double power = std::ceil(std::log(kAliased) / std::log(alias));
    if (power > kMostTaps) break;
    std::vector<double> taps = binomial(static_cast<int>(power));
    samples = halved_length(samples, taps.size());
    if (samples > length_ / 2) break;
    for (std::size_t j = 0; j < bins; ++j) {
      const double angle = 2.0 * pi * static_cast<double>(j) / static_cast<double>(length_);
      // (1 + exp(-i w))/2 = cos(w/2) exp(-i w/2)
      undo_[j] *= 2.0 * std::polar(std::pow(std::cos(0.5 * angle), -power), 0.5 * angle * power);
    }
    filters_.push_back(std::move(taps));
    length_ /= 2;
  }
}

LowBandSpectrum::FirstHalvings LowBandSpectrum::first_halvings(std::size_t most) const {
  FirstHalvings first{std::min(most, filters_.size()), {1.0}, samples_};
  for (std::size_t h = 0; h < first.halvings; ++h) {
    const std::vector<double>& taps = filters_[h];
    const std::size_t apart = std::size_t{1} << h;
    std::vector<double> both(first.taps.size() + apart * (taps.size() - 1), 0.0);
    for (std::size_t t = 0; t < taps.size(); ++t) {
      for (std::size_t i = 0; i < first.taps.size(); ++i) both[apart * t + i] += taps[t] * first.taps[i];
    }
    first.taps = std::move(both);
    first.outputs = halved_length(first.outputs, taps.size());
  }
  return first;
}

std::vector<Complex> LowBandSpectrum::after(std::size_t halvings, std::vector<double> signal) const {
  for (std::size_t h = halvings; h < filters_.size(); ++h) signal = halved(std::move(signal), filters_[h]);
  signal.resize(length_, 0.0);
  std::vector<Complex> spectrum(length_ / 2 + 1);
  RealFft(length_).forward(signal, spectrum);
  spectrum.resize(undo_.size());
  spectrum.shrink_to_fit();  // callers keep it
  for (std::size_t j = 0; j < spectrum.size(); ++j) spectrum[j] *= undo_[j];
  return spectrum;
}

}  // namespace eha::ident
