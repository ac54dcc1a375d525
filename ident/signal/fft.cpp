// SPDX-License-Identifier: GPL-3.0-or-later
#include "ident/signal/fft.hpp"

#include <fftw3.h>

#include <mutex>
#include <stdexcept>

namespace eha::ident {
namespace {

// FFTW's planner has global state of its own; executing plans is thread-safe, making them is not.
std::mutex planner;

}  // namespace

struct RealFft::Plans {
  fftw_plan forward = nullptr;
  fftw_plan inverse = nullptr;

  explicit Plans(std::size_t length) {
    std::vector<double> signal(length);
    std::vector<std::complex<double>> spectrum(length / 2 + 1);
    auto* bins = reinterpret_cast<fftw_complex*>(spectrum.data());
    const int n = static_cast<int>(length);
    const std::scoped_lock lock(planner);
    // Callers' arrays come from any allocator: no alignment is assumed.
    forward = fftw_plan_dft_r2c_1d(n, signal.data(), bins, FFTW_ESTIMATE | FFTW_UNALIGNED);
    inverse = fftw_plan_dft_c2r_1d(n, bins, signal.data(), FFTW_ESTIMATE | FFTW_UNALIGNED);
    if (forward == nullptr || inverse == nullptr) throw std::runtime_error("FFTW made no plan");
  }
  Plans(const Plans&) = delete;
  Plans& operator=(const Plans&) = delete;
  ~Plans() {
    const std::scoped_lock lock(planner);
    fftw_destroy_plan(forward);
    fftw_destroy_plan(inverse);
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

RealFft::RealFft(std::size_t length) : length_(length), plans_(std::make_shared<const Plans>(length)) {}

void RealFft::forward(std::span<const double> signal, std::span<std::complex<double>> spectrum) const {
  // Out of place, an r2c transform leaves its input alone; FFTW's interface just does not say so.
  fftw_execute_dft_r2c(plans_->forward, const_cast<double*>(signal.data()),
                       reinterpret_cast<fftw_complex*>(spectrum.data()));
}

void RealFft::inverse(std::span<std::complex<double>> spectrum, std::span<double> signal) const {
  fftw_execute_dft_c2r(plans_->inverse, reinterpret_cast<fftw_complex*>(spectrum.data()), signal.data());
}

}  // namespace eha::ident
