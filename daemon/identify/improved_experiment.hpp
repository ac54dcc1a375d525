// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "ident/design/improvement.hpp"
#include "ident/model/model.hpp"

namespace eha::identify {

/// Model and parameter that an experiment improves.
struct Improved {
  const ident::Model& model;
  std::string parameter;
  std::string made_by;  ///< first words of the file's comment
};

/// Writes the TOML file of a designed experiment: its tones, the use of its record, and the model as its [[model]].
[[nodiscard]] std::string experiment_text(const Improved& improved, const ident::ImprovementTask& task,
                                          const ident::Improvement& found);

/// Returns the standard error of an estimated parameter, in its own unit; NaN if the model has no such parameter.
[[nodiscard]] double estimated_std(const ident::Model& model, const std::string& parameter);

/// A parameter of a model file.
struct WeakParameter {
  std::string model;
  std::string parameter;
};

/// Returns the parameter for which a model is rejected. Of the models that fail only by parameters picks the one of
/// least AR-BIC. Its standard error is known, so an experiment can be designed for it.
/// A grey box takes no part.
/// @returns nothing if every model is also rejected for another reason, or none is rejected
[[nodiscard]] std::optional<WeakParameter> weak_parameter(const std::vector<const ident::Model*>& models);

}  // namespace eha::identify
