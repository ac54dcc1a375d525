// SPDX-License-Identifier: GPL-3.0-or-later
#include "ident/fractional/simulate.hpp"

#include <cmath>
#include <string>

#include "core/error.hpp"
#include "ident/fractional/grunwald_letnikov.hpp"
#include "ident/fractional/held_response.hpp"
#include "ident/fractional/stability.hpp"

namespace eha::ident {
namespace {

// Below this length the direct recursion is quicker than three transforms.
constexpr Eigen::Index kGlCrossover = 700;

Eigen::VectorXd simulate_exactly(const TransferFunction& g, const Eigen::Ref<const Eigen::VectorXd>& input,
                                 double step_s) {
  const auto samples = static_cast<std::size_t>(input.size());
  const auto response = HeldResponse::of({samples, step_s, 0, 1, samples, {}});
  const InputSpectrum spectrum = response->input_spectrum(input);
  const ResponseRequest request{0, &spectrum};
  return response->respond(TransferColumns(g, {g.numerator}, {}), g.delay_s, {&request, 1});
}

}  // namespace

SimulationMethod simulation_method(std::string_view name) {
  if (name == "exact") return SimulationMethod::exact;
  if (name == "gl1") return SimulationMethod::gl1;
  if (name == "cq2") return SimulationMethod::cq2;
  throw UsageError("simulation method: expected exact, gl1 or cq2, got \"" + std::string(name) + "\"");
}

Eigen::VectorXd simulate(const TransferFunction& g, const Eigen::Ref<const Eigen::VectorXd>& input, double step_s,
                         SimulationMethod method) {
  check(g);
  if (!(step_s > 0.0) || !std::isfinite(step_s))
    throw DataError("sample period: expected a positive number of seconds");
  if (!input.allFinite()) throw DataError("input: expected finite samples, got a NaN or infinite one");
  if (input.size() == 0) return {};
  const bool unstable = grows(g);
  if (method == SimulationMethod::gl1) {
    if (unstable || input.size() < kGlCrossover) return simulate_gl_directly(g, input, step_s);
    return simulate_by_quadrature(g, input, step_s, Quadrature::bdf1);
  }
  if (unstable) {
    throw ConfigError(
        "transfer_function: unstable (a pole has a positive real part), which this method cannot simulate; use "
        "--method gl1 to see it grow");
  }
  if (method == SimulationMethod::cq2) return simulate_by_quadrature(g, input, step_s, Quadrature::bdf2);
  return simulate_exactly(g, input, step_s);
}

}  // namespace eha::ident
