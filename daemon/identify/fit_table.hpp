// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "ident/estimation/fit.hpp"
#include "ident/record.hpp"

namespace eha::identify {

struct IdentifiedModel;

/// File names in a run folder, or beside the models of `eha fit -o`; the second for the paper's procedure.
inline constexpr std::string_view kFitFile = "fit.csv";
inline constexpr std::string_view kPaperFitFile = "fit_paper.csv";

/// A model's output at the rows of a FitTable.
struct FitColumn {
  std::string model;
  std::vector<double> simulated;  ///< [output unit]
};

/// The compared samples of a fit: input, measured output, and each model's output.
struct FitTable {
  ident::Channel input;
  ident::Channel output;
  std::vector<double> time_s;
  std::vector<double> applied;   ///< filtered and decimated like the output [input unit]
  std::vector<double> measured;  ///< as compared [output unit]
  std::vector<FitColumn> models;

  [[nodiscard]] const FitColumn* find(std::string_view model) const;
};

/// Computes the table of models that were fitted to one record with one set of options. Leaves out a model with other
/// rows than the first one's; empty without models. Cost O(rows filter).
[[nodiscard]] FitTable fit_table(const ident::Record& record, const ident::FitOptions& options,
                                 const std::vector<IdentifiedModel>& models);

/// As CSV: time_s, input, output, then each model's output and residual (measured less simulated): "io_in",
/// "io_residual_in". Seven digits; an output that overflowed is an empty field. Cost O(rows models).
[[nodiscard]] std::string to_csv(const FitTable& table);

/// Reads the output of to_csv(). @throws DataError  not such a file; IoError, PermissionError
[[nodiscard]] FitTable read_fit_table(const std::filesystem::path& path);

}  // namespace eha::identify
