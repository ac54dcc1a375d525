// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "daemon/study/plants.hpp"
#include "ident/executor.hpp"

namespace eha::study {

/// Treatment of the input bias and of the history before each part of the record.
enum class Treatment {
  published,  ///< the paper's procedure exactly: neither
  bias,       ///< the same, with the bias that the default procedure estimates added to the input
  history,    ///< the default procedure with the bias held at 0: simulated from the record's first row
  both,       ///< the default procedure
};
inline constexpr std::array kTreatments{Treatment::published, Treatment::bias, Treatment::history, Treatment::both};

/// In tables: "published".
[[nodiscard]] std::string_view name_of(Treatment treatment);
/// For people: "paper's procedure".
[[nodiscard]] std::string_view title_of(Treatment treatment);

/// One model of one record.
struct FittedModel {
  double estimation_r2_percent = 0.0;
  double validation_r2_percent = 0.0;
  double validation_mse = 0.0;  ///< [in^2]
  bool stable = false;
  bool converged = false;
  double highest_order = 0.0;
  double input_bias_V = 0.0;
};

/// Both models of one record, by one treatment.
struct StudyRow {
  std::size_t plant = 0;  ///< of plant_kinds()
  std::uint64_t seed = 0;
  Treatment treatment = Treatment::published;
  FittedModel io;
  FittedModel fo;

  /// R2 of FO less that of IO on the validation part [points].
  [[nodiscard]] double gain() const { return fo.validation_r2_percent - io.validation_r2_percent; }
};

/// A record, or a treatment of it, that gave no model.
struct StudyFailure {
  std::size_t plant = 0;
  std::uint64_t seed = 0;
  std::string reason;
};

struct PaperStudy {
  int seeds = 0;
  std::vector<StudyRow> rows;  ///< by plant, seed and treatment
  std::vector<StudyFailure> failures;
};

/// @param done  records that are complete, of `records`; called by one thread at a time
using StudyProgress = std::function<void(std::size_t done, std::size_t records)>;

/// Fits io and fo by every treatment to `seeds` records of each kind of plant. All use the rows of the paper: 10 s
/// discarded, every 40th row, the first half estimates. Results do not depend on the executor.
/// Cost: some 5 s of processor time a record.
[[nodiscard]] PaperStudy study_paper(int seeds, const ident::Executor& executor, const StudyProgress& progress = {});

}  // namespace eha::study
