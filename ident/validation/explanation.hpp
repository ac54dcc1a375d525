// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
#include <string>

#include "ident/model/model.hpp"
#include "ident/validation/verdict.hpp"

namespace eha::ident {

enum class ExplanationKind {
  structure,  ///< one beside those of the table
  limit,      ///< the input saturates, which no structure has
  power,      ///< the gain is curved, which no structure has
  play,       ///< at the input or before the sensor, which no structure has
};

/// What explains the rest that a model leaves over: a fit of it to the same record holds.
struct Explanation {
  ExplanationKind kind = ExplanationKind::structure;
  /// What it has more: "dry friction", "3 poles and 2 zeros"; the limits of the input, its power, or
  /// the width and the place of a play.
  std::string has;
  /// Of `eha fit`: "--model friction"; of a limit "--from 12 --to 48", a part of the record within it. Empty without.
  std::string options;
  std::string ratio = {};  ///< its rms error on unseen data over the model's: "0.064"
};

/// Keeps it in the model's provenance, for its verdict and for the next command.
void note_explanation(Model& model, const Explanation& explanation);

/// None where none was noted.
[[nodiscard]] std::optional<Explanation> explanation(const Model& model);

/// None where the verdict misses nothing that it explains, or has a cause that lies in the record.
[[nodiscard]] std::optional<Explanation> explanation_of(const Model& model, const Verdict& verdict);

/// The rms error of a model that it explains over its own, at least 1; none where the text of a file is no ratio.
[[nodiscard]] std::optional<double> explained_factor(const Explanation& explanation);

/// For a model that is judged on another record.
void forget_explanation(Model& model);

/// That it holds, how much it errs, and the command that fits it.
[[nodiscard]] std::string sentence_of(const Explanation& explanation);

}  // namespace eha::ident
