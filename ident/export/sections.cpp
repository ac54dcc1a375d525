// SPDX-License-Identifier: GPL-3.0-or-later
#include "ident/export/sections.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace eha::ident {
namespace {

using Complex = std::complex<double>;

constexpr double kTaylorNorm = 0.5;
constexpr int kTaylorTerms = 14;        // 0.5^15 / 15! is below half a rounding error
constexpr double kWholeSamples = 1e-9;  // a delay this close to whole samples counts as whole

Eigen::Index order(const Section& section) { return static_cast<Eigen::Index>(section.denominator.size()); }

/// [A b; 0 0] in the time of `rate`.
Eigen::MatrixXd augmented(const Section& section) {
  const Eigen::Index n = order(section);
  Eigen::MatrixXd m = Eigen::MatrixXd::Zero(n + 1, n + 1);
  for (Eigen::Index i = 0; i < n; ++i) {
    m(i, 0) = -section.denominator[static_cast<std::size_t>(i)];
    if (i + 1 < n) m(i, i + 1) = 1.0;
    m(i, n) = section.numerator[static_cast<std::size_t>(i)];
  }
  return m;
}

Eigen::MatrixXd exponential(Eigen::MatrixXd m) {
  int squarings = 0;
  for (double norm = m.cwiseAbs().rowwise().sum().maxCoeff(); norm > kTaylorNorm; norm *= 0.5) ++squarings;
  m *= std::ldexp(1.0, -squarings);
  Eigen::MatrixXd sum = Eigen::MatrixXd::Identity(m.rows(), m.cols());
  for (int k = kTaylorTerms; k >= 1; --k) {
    sum = (Eigen::MatrixXd::Identity(m.rows(), m.cols()) + m * sum / static_cast<double>(k)).eval();
  }
  for (int k = 0; k < squarings; ++k) sum = (sum * sum).eval();
  return sum;
}

}  // namespace

DiscreteSection discretise(const Section& section, double step_s, double late_s) {
  const Eigen::Index n = order(section);
  const Eigen::MatrixXd m = augmented(section);
  const auto over = [&](double duration_s) { return exponential(m * (section.rate_rad_s * duration_s)); };
  const Eigen::MatrixXd whole = over(step_s);
  if (late_s <= 0.0) return {whole.topLeftCorner(n, n), Eigen::VectorXd::Zero(n), whole.topRightCorner(n, 1)};
  const Eigen::MatrixXd first = over(late_s);
  const Eigen::MatrixXd rest = over(step_s - late_s);
  return {whole.topLeftCorner(n, n), rest.topLeftCorner(n, n) * first.topRightCorner(n, 1), rest.topRightCorner(n, 1)};
}

Eigen::VectorXd respond(const Sections& sections, const Eigen::Ref<const Eigen::VectorXd>& input, double step_s) {
  const double samples = sections.delay_s / step_s;
  double whole = std::floor(samples);
  if (samples - whole > 1.0 - kWholeSamples) whole += 1.0;
  const double late_s = samples - whole < kWholeSamples ? 0.0 : sections.delay_s - whole * step_s;
  const auto rows = static_cast<Eigen::Index>(std::min(whole, static_cast<double>(input.size())));
  const auto delayed = [&](Eigen::Index k) { return k >= 0 ? input[k] : 0.0; };

  Eigen::VectorXd output(input.size());
  for (Eigen::Index k = 0; k < input.size(); ++k) output[k] = sections.direct * delayed(k - rows - 1);
  for (const Section& section : sections.list) {
    const DiscreteSection discrete = discretise(section, step_s, late_s);
    Eigen::VectorXd x = Eigen::Map<const Eigen::VectorXd>(section.state.data(), order(section));
    for (Eigen::Index k = 0; k < input.size(); ++k) {
      output[k] += x[0];
      x = (discrete.a * x + discrete.b_before * delayed(k - rows - 1) + discrete.b * delayed(k - rows)).eval();
    }
  }
  return output;
}

Complex frequency_response(const Sections& sections, Complex s) {
  Complex sum = sections.direct;
  for (const Section& section : sections.list) {
    const Complex sigma = s / section.rate_rad_s;
    Complex denominator = 1.0;
    Complex numerator = 0.0;
    for (std::size_t i = 0; i < section.denominator.size(); ++i) {
      denominator = denominator * sigma + section.denominator[i];
      numerator = numerator * sigma + section.numerator[i];
    }
    sum += numerator / denominator;
  }
  return sum;
}

StateSpace state_space(const Sections& sections) {
  Eigen::Index states = 0;
  for (const Section& section : sections.list) states += order(section);
  StateSpace s{Eigen::MatrixXd::Zero(states, states), Eigen::VectorXd::Zero(states), Eigen::VectorXd::Zero(states),
               sections.direct, Eigen::VectorXd::Zero(states)};
  Eigen::Index at = 0;
  for (const Section& section : sections.list) {
    const Eigen::Index n = order(section);
    const Eigen::MatrixXd m = augmented(section) * section.rate_rad_s;
    s.a.block(at, at, n, n) = m.topLeftCorner(n, n);
    s.b.segment(at, n) = m.topRightCorner(n, 1);
    s.c[at] = 1.0;
    s.x0.segment(at, n) = Eigen::Map<const Eigen::VectorXd>(section.state.data(), n);
    at += n;
  }
  return s;
}

}  // namespace eha::ident
