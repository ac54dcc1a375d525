// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
#include <string>

#include "ident/model/model.hpp"
#include "ident/validation/verdict.hpp"

namespace eha::ident {

/// A structure beside those of a table whose fit to the same record holds, and explains what a model leaves over.
struct Explanation {
  std::string has;  ///< what it has more: "dry friction", "3 poles and 2 zeros", or the limits of the input
  /// Of `eha fit`: "--model friction". The input saturates, which no structure has: "--from 12 --to 48", a part within
  /// its limits; empty without one that is long enough.
  std::string options;
  std::string ratio;  ///< its rms error on unseen data over the model's: "0.064"
};

/// Whether no structure has what explains the rest, as the input saturates.
[[nodiscard]] bool is_saturation(const Explanation& explanation);

/// Keeps it in the model's provenance, for its verdict and for the next command.
void note_explanation(Model& model, const Explanation& explanation);

/// None where none was noted.
[[nodiscard]] std::optional<Explanation> explanation(const Model& model);

/// None where the verdict misses nothing that it explains, or has a cause that lies in the record.
[[nodiscard]] std::optional<Explanation> explanation_of(const Model& model, const Verdict& verdict);

/// For a model that is judged on another record.
void forget_explanation(Model& model);

/// That it holds, how much it errs, and the command that fits it.
[[nodiscard]] std::string sentence_of(const Explanation& explanation);

}  // namespace eha::ident
