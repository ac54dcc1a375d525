// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "daemon/identify/progress.hpp"
#include "daemon/identify/source.hpp"
#include "ident/estimation/fit.hpp"
#include "ident/validation/gain_change.hpp"
#include "ident/validation/parameter_change.hpp"

namespace eha::identify {

/// A model compared with a record.
struct ScoredModel {
  ident::ValidationReport validation;
  double rms_error = 0.0;  ///< offset estimated again [output unit]
  ident::OutputOfModel output = {};
  /// The model's structure fitted to the record; none if the program does not have the structure.
  std::optional<ident::FitResult> refit;
  double refit_rms_error = 0.0;
  std::optional<ident::PlantChange> change;  ///< from the model to its refit
  /// Parameters changed, and the error is ident::kGreatestErrorOverRefit times the greater of the refit's and that on
  /// the model's own record; behind a map the parameters by more than another experiment shifts them.
  bool of_another_plant = false;
  /// A gain that alone takes away most of the error, where that is greater than usual; none: no gain does.
  std::optional<ident::OtherGain> other_gain = {};
  /// Why the record does not show whether the model is of this plant, and what to record; empty: it does. A straight
  /// model is another one for each stretch of a valve's motion: it needs half the time that estimated it.
  std::string cannot_tell = {};
  /// Of those, what speaks against the model: far more error than on its own record, or more than a model that
  /// does not suit the record. One of another input or length only may be used.
  bool is_doubtful = false;
  /// That a drift was taken out of the record's output; empty: none was.
  std::string drift = {};
};

/// "a gain 0.45 % greater alone takes the error from 0.0031 to 0.0008 in: ..." @param scored  with `other_gain`
/// @param factor, unit  of the lengths in the sentence, over those of the record
[[nodiscard]] std::string other_gain_text(const ScoredModel& scored, double factor, const std::string& unit);

/// Scores every model on the whole record with the same samples and criteria.
/// @throws as ident::validate
[[nodiscard]] std::vector<ScoredModel> score_models(const std::vector<ident::Model>& models, const Source& source,
                                                    const Progress& progress = {});

/// The same with the record for each model as its input was taken for the model: one source a model, of one record.
[[nodiscard]] std::vector<ScoredModel> score_models(const std::vector<ident::Model>& models,
                                                    const std::vector<const Source*>& sources,
                                                    const Progress& progress = {});

/// The same for one model, with the record prepared by `options`.
[[nodiscard]] ScoredModel score_model(const ident::Model& model, const Source& source, ident::FitOptions options,
                                      const Progress& progress = {});

}  // namespace eha::identify
