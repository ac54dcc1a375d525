// SPDX-License-Identifier: GPL-3.0-or-later
#include "ident/estimation/model_output.hpp"

#include <Eigen/QR>

#include "ident/fractional/grunwald_letnikov.hpp"
#include "ident/fractional/held_response.hpp"
#include "ident/fractional/stability.hpp"

namespace eha::ident {
namespace {

/// Free responses s^i/D, i = 0.., as step responses of s^(i+1)/D.
TransferColumns free_columns(const Model& model) {
  std::vector<std::vector<Term>> numerators;
  for (std::size_t i = 0; i < model.initial_state.size(); ++i)
    numerators.push_back({{1.0, static_cast<double>(i + 1)}});
  return {model.transfer_function, numerators, {}};
}

Eigen::MatrixXd free_responses(const Model& model, const HeldResponse& response) {
  const InputSpectrum step = response.step_spectrum();
  std::vector<ResponseRequest> requests;
  for (std::size_t i = 0; i < model.initial_state.size(); ++i) requests.push_back({i, &step, AtJump::after});
  return response.respond(free_columns(model), 0.0, requests);
}

}  // namespace

Eigen::VectorXd simulate(const Model& model, const Eigen::Ref<const Eigen::VectorXd>& input, double step_s,
                         SimulationMethod method) {
  Eigen::VectorXd y = simulate(model.transfer_function, input.array() + model.input_bias, step_s, method);
  y.array() += model.initial_output;
  if (!model.initial_state.empty() && input.size() > 0) {
    const auto samples = static_cast<std::size_t>(input.size());
    const HeldResponse response({samples, step_s, 0, 1, samples, {}});
    y += free_responses(model, response) *
         Eigen::Map<const Eigen::VectorXd>(model.initial_state.data(),
                                           static_cast<Eigen::Index>(model.initial_state.size()));
  }
  return y;
}

Eigen::VectorXd ModelOutput::total(const Model& model) const {
  Eigen::VectorXd y = forced.array() + model.initial_output;
  if (free.cols() > 0) {
    y += free * Eigen::Map<const Eigen::VectorXd>(model.initial_state.data(),
                                                  static_cast<Eigen::Index>(model.initial_state.size()));
  }
  return y;
}

ModelOutput output_at(const Model& model, const Record& record, const Comparison& comparison) {
  const Eigen::VectorXd input = record.input.array() + model.input_bias;
  if (grows(model.transfer_function)) {
    return {picked(simulate_gl_directly(model.transfer_function, input, record.step_s), comparison), {}};
  }
  const HeldResponse response({static_cast<std::size_t>(input.size()), record.step_s, comparison.first,
                               comparison.every, comparison.count, comparison.taps});
  const InputSpectrum spectrum = response.input_spectrum(input);
  const ResponseRequest request{0, &spectrum};
  const TransferColumns columns(model.transfer_function, {model.transfer_function.numerator}, {});
  ModelOutput output{response.respond(columns, model.transfer_function.delay_s, {&request, 1}), {}};
  if (!model.initial_state.empty()) output.free = free_responses(model, response);
  return output;
}

Model with_offset_fitted(const Model& model, const ModelOutput& output, const Eigen::VectorXd& measured) {
  Eigen::MatrixXd columns(measured.size(), output.free.cols() + 1);
  columns << Eigen::VectorXd::Ones(measured.size()), output.free;
  const Eigen::VectorXd scale = columns.colwise().norm().cwiseMax(1e-300).cwiseInverse();
  Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(columns.rows(), columns.cols());
  qr.setThreshold(1e-10);
  qr.compute(columns * scale.asDiagonal());
  const Eigen::VectorXd solved = scale.cwiseProduct(qr.solve(measured - output.forced));
  Model fitted = model;
  fitted.initial_output = solved[0];
  for (std::size_t i = 0; i < fitted.initial_state.size() && output.free.cols() > 0; ++i) {
    fitted.initial_state[i] = solved[static_cast<Eigen::Index>(i) + 1];
  }
  return fitted;
}

}  // namespace eha::ident
