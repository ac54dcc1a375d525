// SPDX-License-Identifier: GPL-3.0-or-later
#include "ident/statistics/distributions.hpp"

#include <boost/math/distributions/chi_squared.hpp>
#include <boost/math/distributions/fisher_f.hpp>
#include <boost/math/distributions/non_central_chi_squared.hpp>
#include <boost/math/distributions/normal.hpp>
#include <boost/math/distributions/students_t.hpp>

namespace eha::ident {
namespace {

template <typename Distribution>
double exceeded(const Distribution& distribution, double share) {
  return boost::math::quantile(boost::math::complement(distribution, share));
}

template <typename Distribution>
double share_above(const Distribution& distribution, double value) {
  return boost::math::cdf(boost::math::complement(distribution, value));
}

}  // namespace

double normal_exceeded(double share) { return exceeded(boost::math::normal(), share); }

double student_exceeded(double share, double degrees) { return exceeded(boost::math::students_t(degrees), share); }

double chi_squared_exceeded(double share, double degrees) { return exceeded(boost::math::chi_squared(degrees), share); }

double chi_squared_share(double value, double degrees, double noncentrality) {
  if (noncentrality == 0.0) return share_above(boost::math::chi_squared(degrees), value);
  return share_above(boost::math::non_central_chi_squared(degrees, noncentrality), value);
}

double fisher_exceeded(double share, double degrees, double freedom) {
  return exceeded(boost::math::fisher_f(degrees, freedom), share);
}

double fisher_share(double value, double degrees, double freedom) {
  return share_above(boost::math::fisher_f(degrees, freedom), value);
}

}  // namespace eha::ident
