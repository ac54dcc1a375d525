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
// A fit needs five or six lengths, each many times.
constexpr std::size_t kMostKept = 8;

}  // namespace

struct RealFft::Plans {
  fftw_plan forward = nullptr;
  fftw_plan inverse = nullptr;

  explicit Plans(std::size_t length) {
    // Estimating touches neither array, so that those of a long record cost no memory.
    const std::unique_ptr<double, decltype(&fftw_free)> signal(fftw_alloc_real(length), &fftw_free);
    const std::unique_ptr<fftw_complex, decltype(&fftw_free)> spectrum(fftw_alloc_complex(length / 2 + 1), &fftw_free);
    if (!signal || !spectrum) throw std::bad_alloc();
    fftw_complex* const bins = spectrum.get();
    const int n = static_cast<int>(length);
    // Callers' arrays come from any allocator: no alignment is assumed.
    forward = fftw_plan_dft_r2c_1d(n, signal.get(), bins, FFTW_ESTIMATE | FFTW_UNALIGNED);
    inverse = fftw_plan_dft_c2r_1d(n, bins, signal.get(), FFTW_ESTIMATE | FFTW_UNALIGNED);
    if (forward == nullptr || inverse == nullptr) throw std::runtime_error("FFTW made no plan");
  }
  Plans(const Plans&) = delete;
  Plans& operator=(const Plans&) = delete;
  ~Plans() {
    const std::scoped_lock lock(planner);
    fftw_destroy_plan(forward);
    fftw_destroy_plan(inverse);
  }

  /// Plans are made at the first call for a length; the most recently used ones are kept.
  static std::shared_ptr<const Plans> of(std::size_t length) {
    static std::vector<std::pair<std::size_t, std::shared_ptr<const Plans>>> kept;
    std::shared_ptr<const Plans> dropped;  // after the lock is released: its destructor takes it
    const std::scoped_lock lock(planner);
    auto found = std::find_if(kept.begin(), kept.end(), [&](const auto& entry) { return entry.first == length; });
    if (found == kept.end()) {
      if (kept.size() == kMostKept) {
        dropped = std::move(kept.front().second);
        kept.erase(kept.begin());
      }
      found = kept.emplace(kept.end(), length, std::make_shared<const Plans>(length));
    }
    std::rotate(found, found + 1, kept.end());
    return kept.back().second;
  }
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
  fftw_execute_dft_r2c(plans_->forward, const_cast<double*>(signal.data()),
                       reinterpret_cast<fftw_complex*>(spectrum.data()));
}

void RealFft::inverse(std::span<std::complex<double>> spectrum, std::span<double> signal) const {
  fftw_execute_dft_c2r(plans_->inverse, reinterpret_cast<fftw_complex*>(spectrum.data()), signal.data());
}

}  // namespace eha::ident
