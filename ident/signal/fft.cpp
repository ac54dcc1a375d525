// SPDX-License-Identifier: GPL-3.0-or-later
#include "ident/signal/fft.hpp"

#include <fftw3.h>

#include <algorithm>
#include <memory>
#include <mutex>
#include <new>
#include <stdexcept>
#include <utility>
#include <vector>

namespace eha::ident {
namespace {

// FFTW's planner has global state: executing plans is thread-safe, making them is not.
std::mutex planner;
// A ladder needs a dozen lengths, each many times.
constexpr std::size_t kMostKept = 24;
constexpr std::size_t kMostKeptLength = 8'000'000;  // together, ten bytes each

}  // namespace

/// Both plans of a length. Each is made when it is first needed: making one takes as long as a hundred transforms.
struct RealFft::Plans {
  explicit Plans(std::size_t samples) : length(samples) {}
  Plans(const Plans&) = delete;
  Plans& operator=(const Plans&) = delete;
  ~Plans() {
    const std::scoped_lock lock(planner);
    fftw_destroy_plan(forward_);
    fftw_destroy_plan(inverse_);
  }

  [[nodiscard]] fftw_plan forward() const {
    std::call_once(forward_made_, [&] {
      forward_ =
          made([](int n, double* signal, fftw_complex* bins) { return fftw_plan_dft_r2c_1d(n, signal, bins, kFlags); });
    });
    return forward_;
  }
  [[nodiscard]] fftw_plan inverse() const {
    std::call_once(inverse_made_, [&] {
      inverse_ =
          made([](int n, double* signal, fftw_complex* bins) { return fftw_plan_dft_c2r_1d(n, bins, signal, kFlags); });
    });
    return inverse_;
  }

  /// Plans are made at the first call for a length; the most recently used ones are kept.
  static std::shared_ptr<const Plans> of(std::size_t length) {
    static std::vector<std::pair<std::size_t, std::shared_ptr<const Plans>>> kept;
    std::vector<std::shared_ptr<const Plans>> dropped;  // after the lock is released: its destructor takes it
    const std::scoped_lock lock(planner);
    auto found = std::find_if(kept.begin(), kept.end(), [&](const auto& entry) { return entry.first == length; });
    if (found == kept.end()) {
      std::size_t together = length;
      for (const auto& entry : kept) together += entry.first;
      while (!kept.empty() && (kept.size() == kMostKept || together > kMostKeptLength)) {
        together -= kept.front().first;
        dropped.push_back(std::move(kept.front().second));
        kept.erase(kept.begin());
      }
      found = kept.emplace(kept.end(), length, std::make_shared<const Plans>(length));
    }
    std::rotate(found, found + 1, kept.end());
    return kept.back().second;
  }

  const std::size_t length;

 private:
  // Callers' arrays come from any allocator: no alignment is assumed.
  static constexpr unsigned kFlags = FFTW_ESTIMATE | FFTW_UNALIGNED;

  template <typename Make>
  [[nodiscard]] fftw_plan made(const Make& make) const {
    const std::scoped_lock lock(planner);
    // Estimating touches neither array, so that those of a long record cost no memory.
    const std::unique_ptr<double, decltype(&fftw_free)> signal(fftw_alloc_real(length), &fftw_free);
    const std::unique_ptr<fftw_complex, decltype(&fftw_free)> bins(fftw_alloc_complex(length / 2 + 1), &fftw_free);
    if (!signal || !bins) throw std::bad_alloc();
    const fftw_plan plan = make(static_cast<int>(length), signal.get(), bins.get());
    if (plan == nullptr) throw std::runtime_error("FFTW made no plan");
    return plan;
  }

  mutable std::once_flag forward_made_;
  mutable std::once_flag inverse_made_;
  mutable fftw_plan forward_ = nullptr;
  mutable fftw_plan inverse_ = nullptr;
};

std::size_t fast_length(std::size_t minimum, std::size_t divisor) {
  const std::size_t wanted = (minimum + divisor - 1) / divisor;
  for (std::size_t even = wanted + wanted % 2;; even += 2) {
    std::size_t rest = even;
    for (const std::size_t prime : {2U, 3U, 5U}) {
      while (rest % prime == 0) rest /= prime;
    }
    if (rest == 1) return even * divisor;
  }
}

RealFft::RealFft(std::size_t length) : length_(length), plans_(Plans::of(length)) {}

void RealFft::forward(std::span<const double> signal, std::span<std::complex<double>> spectrum) const {
  // An out-of-place r2c transform does not change its input, although FFTW's interface takes it as not const.
  fftw_execute_dft_r2c(plans_->forward(), const_cast<double*>(signal.data()),
                       reinterpret_cast<fftw_complex*>(spectrum.data()));
}

void RealFft::inverse(std::span<std::complex<double>> spectrum, std::span<double> signal) const {
  fftw_execute_dft_c2r(plans_->inverse(), reinterpret_cast<fftw_complex*>(spectrum.data()), signal.data());
}

}  // namespace eha::ident
