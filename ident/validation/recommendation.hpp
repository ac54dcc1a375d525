// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "ident/acceptance_limits.hpp"
#include "ident/model/model.hpp"
#include "ident/signal/measured_rows.hpp"

namespace eha::ident {

/// The recommended model among those fitted to one record.
struct Recommendation {
  std::string model = {};   ///< name; empty: none can be recommended
  std::string reason = {};  ///< one sentence
  /// Name of the next best, of the identified ones if there is another; without a recommended model the one that its
  /// reason names. Empty: there is no other model.
  std::string runner_up = {};
  /// The validation part took part in the choice, because the best model by the estimation part failed there. Only a
  /// fresh record can then say how well the model predicts.
  bool validation_chose = false;
  bool is_unclear = false;       ///< the record hardly tells the model from the runner-up
  bool is_lag_or_delay = false;  ///< as that is a lag in the place of a dead time, or the other way round
  /// Without a recommended model: the accepted ones, each with why it is not recommended. Empty: there is none.
  std::string accepted_instead = {};
};

/// "this record hardly tells io from fo", of a recommendation that is_unclear.
[[nodiscard]] std::string unclear_choice(const Recommendation& recommendation);

/// Fall of AR-BIC needed to recommend a model of fractional order instead of every one of integer order.
inline constexpr double kFractionalGain = 10.0;

/// What a map of the valve must gain in AR-BIC on models without one: a dead band that is too small to show fits other
/// effects as well.
inline constexpr double kMapGain = 10.0;

/// The best accepted model that leaves nothing over that the input moves, where `model` does, and errs no more than
/// kAsWell times as much; null without one.
/// @param models  those of one record
[[nodiscard]] const Model* explaining(const Model& model, const std::vector<const Model*>& models);

/// The end stop on which a record's rod stands: as the recommended model has it, which may follow the record where a
/// worse one takes a plant that has settled for a stop; without one (empty) as the first model that sees it.
/// @param models  those of the record @returns none if none does
[[nodiscard]] std::optional<EndStop> end_stop_of(const std::vector<const Model*>& models, std::string_view recommended);

/// Rms error of a model over that of another, both on the validation part; none where one of them has none.
[[nodiscard]] std::optional<double> error_over(const Model& model, const Model& other);

/// Of a model that is_comparable().
[[nodiscard]] double ar_bic(const Model& model);

/// Whether two models were fitted to the same rows by the same procedure, and both have an AR-BIC.
[[nodiscard]] bool is_comparable(const Model& model, const Model& with);

/// Whether an order of the model was estimated.
[[nodiscard]] bool has_estimated_order(const Model& model);

/// The order of every table of models, as places in `models`: first the recommended one; without one that which the
/// reason names (`runner_up`), else the one of least AR-BIC where all have one. Then by verdict_word() (good, usable,
/// outdone, not needed, undetermined, rejected, not judged), within it the least rms error first, on the validation
/// part where there is one.
[[nodiscard]] std::vector<std::size_t> table_order(const std::vector<const Model*>& models,
                                                   const Recommendation& recommendation);

/// Rows of such a table in that order. @param model_of  the model of a row, by reference
template <typename Row, typename ModelOf>
[[nodiscard]] std::vector<Row> in_table_order(const std::vector<Row>& rows, const Recommendation& recommendation,
                                              ModelOf model_of) {
  std::vector<const Model*> models;
  for (const Row& row : rows) models.push_back(&model_of(row));
  std::vector<Row> sorted;
  for (const std::size_t i : table_order(models, recommendation)) sorted.push_back(rows[i]);
  return sorted;
}

/// Mean square of the error that tables show: on the validation part, else on the samples that estimated; infinite
/// without either.
[[nodiscard]] double shown_mse(const Model& model);

/// Picks a model by the estimation part alone: of those that the verdict would accept without looking at the validation
/// part, the one of least AR-BIC. One with an estimated order is picked only if its AR-BIC is less than that of every
/// model of integer order, and of every one whose estimated orders are within 0.01 of whole numbers, by kFractionalGain
/// and, where its test for nonlinear effects (of the validation part) fails, that test's statistic; one whose own
/// orders are all so near to whole numbers only if none of integer order is accepted; one with a dead time that may be
/// a lag, or with a resonance beyond ten times the usable band must gain as much on the others; one with a map kMapGain
/// on those without. One for which asks_too_much_of_input(), fits_rounding(), stands_for_dead_time() or
/// is_bent_by_loop() of model_choice.hpp holds takes no part. If the verdict rejects the picked model, or an accepted
/// one has less than half its error on the validation part (a third with more parameters), the next one is taken and
/// `validation_chose` set; without one, none.
/// @param models  fitted to the same rows of one record, each with its verdict; one without AR-BIC, of other rows or by
///                the paper's procedure takes no part
/// @param limits, unmeasured  as judge()
[[nodiscard]] Recommendation recommend(const std::vector<const Model*>& models, const AcceptanceLimits& limits,
                                       const Unmeasured& unmeasured = {});

/// "Recommended: io_valve (runner-up fo): least AR-BIC ...", or "No model is recommended: ...".
[[nodiscard]] std::string sentence(const Recommendation& recommendation);

}  // namespace eha::ident
