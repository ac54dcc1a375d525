// SPDX-License-Identifier: GPL-3.0-or-later
//
// Compiled with -ffast-math so that exp, sin and cos become vector calls (glibc's libmvec, at most 4 ulp). No
// infinity or NaN may be relied on in this file.
#include "ident/fractional/transfer_columns.hpp"

#include <algorithm>
#include <cmath>

#include "ident/vector_clones.hpp"

namespace eha::ident {
namespace {

constexpr std::size_t kBlock = 128;

struct Block {
  double re[kBlock];
  double im[kBlock];
};

/// s^order; cosine and sine have separate loops, because the compiler joins them into a call that it cannot vectorise.
EHA_VECTOR_CLONES
void raise(const double* log_magnitude, const double* angle, double order, std::size_t n, double* re, double* im) {
  double magnitude[kBlock];
  for (std::size_t i = 0; i < n; ++i) magnitude[i] = std::exp(order * log_magnitude[i]);
  for (std::size_t i = 0; i < n; ++i) re[i] = magnitude[i] * std::cos(order * angle[i]);
  for (std::size_t i = 0; i < n; ++i) im[i] = magnitude[i] * std::sin(order * angle[i]);
}

EHA_VECTOR_CLONES
void add_scaled(const Block& power, double coefficient, std::size_t n, Block& sum) {
  for (std::size_t i = 0; i < n; ++i) sum.re[i] += coefficient * power.re[i];
  for (std::size_t i = 0; i < n; ++i) sum.im[i] += coefficient * power.im[i];
}

/// sum += (coefficient + log_coefficient (ln|s| + i arg s)) power
EHA_VECTOR_CLONES
void add_log_scaled(const Block& power, double coefficient, double log_coefficient, const double* log_magnitude,
                    const double* angle, std::size_t n, Block& sum) {
  for (std::size_t i = 0; i < n; ++i) {
    const double re = coefficient + log_coefficient * log_magnitude[i];
    const double im = log_coefficient * angle[i];
    sum.re[i] += re * power.re[i] - im * power.im[i];
    sum.im[i] += re * power.im[i] + im * power.re[i];
  }
}

EHA_VECTOR_CLONES
void invert(std::size_t n, Block& value) {
  // Scaled first, because the square of a high power of s at a distant point of the quadrature would overflow.
  for (std::size_t i = 0; i < n; ++i) {
    const double size = 1.0 / std::max(std::abs(value.re[i]), std::abs(value.im[i]));
    const double re = value.re[i] * size;
    const double im = value.im[i] * size;
    const double scale = size / (re * re + im * im);
    value.re[i] = re * scale;
    value.im[i] = -im * scale;
  }
}

EHA_VECTOR_CLONES
void multiply(const Block& a, const Block& b, std::size_t n, double* re, double* im) {
  for (std::size_t i = 0; i < n; ++i) {
    const double product_re = a.re[i] * b.re[i] - a.im[i] * b.im[i];
    const double product_im = a.re[i] * b.im[i] + a.im[i] * b.re[i];
    re[i] = product_re;
    im[i] = product_im;
  }
}

/// difference -= a b
EHA_VECTOR_CLONES
void subtract_product(const Block& a, const Block& b, std::size_t n, Block& difference) {
  for (std::size_t i = 0; i < n; ++i) {
    difference.re[i] -= a.re[i] * b.re[i] - a.im[i] * b.im[i];
    difference.im[i] -= a.re[i] * b.im[i] + a.im[i] * b.re[i];
  }
}

/// Coefficient of the highest order among terms that reach `order`, else 0.
double coefficient_at(const std::vector<Term>& terms, double order) {
  double sum = 0.0;
  for (const Term& term : terms) {
    if (std::abs(term.order - order) <= 1e-12 * std::max(1.0, order)) sum += term.coefficient;
  }
  return sum;
}

double coefficient_at(const std::vector<LogTerm>& terms, double order) {
  double sum = 0.0;
  for (const LogTerm& term : terms) {
    if (std::abs(term.order - order) <= 1e-12 * std::max(1.0, order)) sum += term.coefficient;
  }
  return sum;
}

}  // namespace

void LaplacePoints::add(double re, double im) {
  log_magnitude.push_back(0.5 * std::log(re * re + im * im));
  angle.push_back(std::atan2(im, re));
}

std::size_t TransferColumns::power(double order) {
  const auto found = std::find(orders_.begin(), orders_.end(), order);
  if (found != orders_.end()) return static_cast<std::size_t>(found - orders_.begin());
  orders_.push_back(order);
  return orders_.size() - 1;
}

std::vector<TransferColumns::Weighted> TransferColumns::weigh(const std::vector<Term>& terms) {
  std::vector<Weighted> weighted;
  for (const Term& term : terms) weighted.push_back({power(term.order), term.coefficient, 0.0});
  return weighted;
}

std::vector<TransferColumns::Weighted> TransferColumns::weigh(const std::vector<LogTerm>& terms) {
  std::vector<Weighted> weighted;
  for (const LogTerm& term : terms) weighted.push_back({power(term.order), term.coefficient, term.log_coefficient});
  return weighted;
}

TransferColumns::TransferColumns(const TransferFunction& g, const std::vector<std::vector<Term>>& numerators,
                                 const std::vector<Sensitivity>& sensitivities)
    : has_sensitivities_(!sensitivities.empty()) {
  double top = 0.0;
  for (const Term& term : g.denominator) {
    if (term.coefficient != 0.0) top = std::max(top, term.order);
  }
  const double lead = coefficient_at(g.denominator, top);
  const double direct = coefficient_at(g.numerator, top) / lead;
  denominator_ = weigh(g.denominator);
  numerator_ = weigh(g.numerator);
  for (const auto& terms : numerators) {
    columns_.push_back({weigh(terms), {}, 0.0, coefficient_at(terms, top) / lead});
  }
  for (const Sensitivity& s : sensitivities) {
    const double slope = (coefficient_at(s.numerator, top) - direct * coefficient_at(s.denominator, top)) / lead;
    columns_.push_back({weigh(s.numerator), weigh(s.denominator), s.delay, slope});
  }
  factors_.assign(orders_.size(), 0);
  const auto one = std::find(orders_.begin(), orders_.end(), 1.0);
  if (one == orders_.end()) return;
  unit_ = static_cast<std::size_t>(one - orders_.begin());
  for (std::size_t k = unit_ + 1; k < orders_.size(); ++k) {
    const auto below = std::find(orders_.begin(), orders_.begin() + static_cast<std::ptrdiff_t>(k), orders_[k] - 1.0);
    // Index 0 would mean none; it is the denominator's order 0, and s^1 = s^0 s is the unit itself.
    if (orders_[k] >= 2.0 && below != orders_.begin() + static_cast<std::ptrdiff_t>(k)) {
      factors_[k] = static_cast<std::size_t>(below - orders_.begin());
    }
  }
}

void TransferColumns::evaluate(const LaplacePoints& points, std::size_t first, std::size_t count, double* re,
                               double* im, std::size_t stride) const {
  std::vector<Block> powers(orders_.size());
  Block inverse;
  Block g;
  Block sum;
  Block other;
  for (std::size_t start = 0; start < count; start += kBlock) {
    const std::size_t n = std::min(kBlock, count - start);
    const double* log_magnitude = points.log_magnitude.data() + first + start;
    const double* angle = points.angle.data() + first + start;
    for (std::size_t k = 0; k < orders_.size(); ++k) {
      if (orders_[k] == 0.0) {
        std::fill_n(powers[k].re, n, 1.0);
        std::fill_n(powers[k].im, n, 0.0);
      } else if (const std::size_t m = factors_[k]; m != 0) {
        // s^k = s^(k-1) s: a product costs a tenth of a power.
        multiply(powers[m], powers[unit_], n, powers[k].re, powers[k].im);
      } else {
        raise(log_magnitude, angle, orders_[k], n, powers[k].re, powers[k].im);
      }
    }
    const auto accumulate = [&](const std::vector<Weighted>& terms, Block& into) {
      std::fill_n(into.re, n, 0.0);
      std::fill_n(into.im, n, 0.0);
      for (const Weighted& term : terms) {
        if (term.log_coefficient == 0.0) {
          add_scaled(powers[term.power], term.coefficient, n, into);
        } else {
          add_log_scaled(powers[term.power], term.coefficient, term.log_coefficient, log_magnitude, angle, n, into);
        }
      }
    };
    accumulate(denominator_, inverse);
    invert(n, inverse);
    if (has_sensitivities_) {
      accumulate(numerator_, sum);
      multiply(sum, inverse, n, g.re, g.im);
    }
    for (std::size_t c = 0; c < columns_.size(); ++c) {
      const Column& column = columns_[c];
      accumulate(column.numerator, sum);
      if (!column.denominator.empty()) {
        accumulate(column.denominator, other);
        subtract_product(g, other, n, sum);
      }
      double* out_re = re + c * stride + start;
      double* out_im = im + c * stride + start;
      multiply(sum, inverse, n, out_re, out_im);
      if (column.delay != 0.0) {
        for (std::size_t i = 0; i < n; ++i) {
          const double magnitude = column.delay * std::exp(log_magnitude[i]);
          const double s_re = magnitude * std::cos(angle[i]);
          const double s_im = magnitude * std::sin(angle[i]);
          out_re[i] -= s_re * g.re[i] - s_im * g.im[i];
          out_im[i] -= s_re * g.im[i] + s_im * g.re[i];
        }
      }
    }
  }
}

}  // namespace eha::ident
