// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <memory>

#include "ident/fractional/held_response.hpp"
#include "ident/fractional/simulate.hpp"
#include "ident/model/model.hpp"
#include "ident/record.hpp"
#include "ident/signal/decimation.hpp"
#include "ident/signal/measured_rows.hpp"

namespace eha::ident {

/// Output of the whole model, bias or map, offset and free response included: N samples at the input's times.
/// @throws as simulate(TransferFunction, ...)
[[nodiscard]] Eigen::VectorXd simulate(const Model& model, const Eigen::Ref<const Eigen::VectorXd>& input,
                                       double step_s, SimulationMethod method = SimulationMethod::exact);

/// The parts of a model's output at the rows of a comparison, filtered like the data.
struct ModelOutput {
  Eigen::VectorXd forced;  ///< G(v), count rows
  Eigen::MatrixXd free;    ///< responses to unit terms of the initial state, then of the past input; none for neither
  [[nodiscard]] Eigen::VectorXd total(const Model& model) const;
  /// The same at those of its rows that were measured.
  [[nodiscard]] ModelOutput at(const MeasuredRows& rows) const;
};

/// Outputs of models at the rows of one comparison of one record. The parts that depend on the record alone are
/// computed once, at the first model that does not grow. Not thread-safe; record and comparison must outlive it.
class OutputOnRecord {
 public:
  OutputOnRecord(const Record& record, const Comparison& comparison);
  OutputOnRecord(const Record&&, const Comparison&) = delete;
  OutputOnRecord(const Record&, const Comparison&&) = delete;

  [[nodiscard]] const Record& record() const noexcept { return record_; }
  [[nodiscard]] const Comparison& comparison() const noexcept { return comparison_; }
  [[nodiscard]] const MeasuredRows& measured_rows() const noexcept { return measured_rows_; }

  /// Simulates a growing model by the direct recursion, which may overflow, any other exactly.
  /// Cost without a map: O(L log L) at the first call, then that of the compared rows; with a map O(L log L) a call.
  [[nodiscard]] ModelOutput of(const Model& model);

  /// The response of a transfer function that does not grow to a signal as long as the record, from rest: at the rows
  /// of the comparison, filtered like the data. Cost O(L log L).
  [[nodiscard]] Eigen::VectorXd response(const TransferFunction& g, const Eigen::Ref<const Eigen::VectorXd>& signal);

 private:
  [[nodiscard]] const HeldResponse& held_response();
  [[nodiscard]] InputSpectrum spectrum_of(const Eigen::Ref<const Eigen::VectorXd>& input);

  const Record& record_;
  const Comparison& comparison_;
  MeasuredRows measured_rows_;
  std::shared_ptr<const HeldResponse> response_;
  InputSpectrum input_;  ///< of the input as recorded; empty until it is needed
};

/// Returns the model with initial_output and initial_state refitted to `measured` over the same rows.
[[nodiscard]] Model with_offset_fitted(const Model& model, const ModelOutput& output, const Eigen::VectorXd& measured);

}  // namespace eha::ident
