// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "daemon/identify/rounds.hpp"
#include "ident/design/improvement.hpp"

namespace eha::identify {

/// Which parameter of which model an experiment improves.
struct Improved {
  const ident::Model& model;
  std::string parameter;
  std::string made_by;  ///< first words of the file's comment
};

/// The TOML file of a designed experiment: its tones, the use of its record, and the model as its [[model]].
[[nodiscard]] std::string experiment_text(const Improved& improved, const ident::ImprovementTask& task,
                                          const ident::Improvement& found);

/// The experiment that shrinks the standard error of a parameter most for which a model was rejected: of the models
/// that fail by their parameters alone the one of least AR-BIC. It is as long as the source's, and stays within the
/// voltage, slew and travel that the record has shown.
/// @returns nothing without an experiment or such a model, or where it gains less than a fifth
/// Cost: seconds.
[[nodiscard]] std::optional<NextExperiment> improved_experiment(const Source& source,
                                                                const std::vector<const ident::Model*>& models);

}  // namespace eha::identify
