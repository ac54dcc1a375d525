// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <numbers>
#include <random>
#include <string>
#include <utility>

#include "ident/fit_options.hpp"
#include "ident/model/model_output.hpp"
#include "ident/record.hpp"
#include "ident/structure/structure_options.hpp"

/// Records of known models, excited as in the paper.
namespace eha::ident::synthetic {

inline double uniform(std::mt19937_64& generator) { return static_cast<double>(generator() >> 11) * 0x1p-53; }

inline double normal(std::mt19937_64& generator) {
  return std::sqrt(-2.0 * std::log(1.0 - uniform(generator))) * std::cos(2.0 * std::numbers::pi * uniform(generator));
}

/// Three tones of the paper's band, 50 s.
inline Eigen::VectorXd excitation(double step_s) {
  Eigen::VectorXd u(static_cast<Eigen::Index>(std::lround(50.0 / step_s)));
  for (Eigen::Index k = 0; k < u.size(); ++k) {
    const double t = 2.0 * std::numbers::pi * step_s * static_cast<double>(k);
    u[k] = 1.9 * std::cos(0.05 * t + 0.3) + 1.6 * std::cos(0.2 * t + 1.9) + 1.5 * std::cos(0.65 * t + 4.2);
  }
  return u;
}

inline Record record_of(const Model& model, double step_s, double noise, std::uint64_t seed) {
  Record record;
  record.step_s = step_s;
  record.input = excitation(step_s);
  record.output = simulate(model, record.input, step_s);
  const double spread = std::sqrt((record.output.array() - record.output.mean()).square().mean());
  std::mt19937_64 generator(seed);
  for (double& y : record.output) y += noise * spread * normal(generator);
  return record;
}

inline Model fractional(double a2, double n2, double n1, double a0, double gain) {
  Model model;
  model.transfer_function = {{{gain, 0.0}}, {{a2, n2}, {1.0, n1}, {a0, 0.0}}, 0.0};
  return model;
}

inline double value(const Model& model, const std::string& name) {
  for (const ParameterEstimate& p : model.parameters) {
    if (p.name == name) return p.value;
  }
  ADD_FAILURE() << "no parameter " << name;
  return NAN;
}

inline StructureOptions asked_for(Structure structure) {
  StructureOptions options;
  options.structure = std::move(structure);
  options.name = "model";
  return options;
}

}  // namespace eha::ident::synthetic
