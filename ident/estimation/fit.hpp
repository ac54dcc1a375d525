// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "core/error.hpp"
#include "ident/executor.hpp"
#include "ident/fit_options.hpp"
#include "ident/model/model.hpp"
#include "ident/model/model_output.hpp"
#include "ident/record.hpp"
#include "ident/structure/structure_options.hpp"
#include "ident/uncertainty/bode_curve.hpp"
#include "ident/work.hpp"

namespace eha::ident {

class InsideFits;
class PreparedRecord;
struct FittedOptimum;

/// A fitted model and what was compared to get it.
struct FitResult {
  Model model;                         ///< estimation, validation and stability filled; verdict not
  Eigen::VectorXd time_s;              ///< of the compared samples, estimation part then validation part
  Eigen::VectorXd measured;            ///< filtered and decimated as compared [output unit]
  Eigen::VectorXd simulated;           ///< [output unit]
  std::size_t estimation_samples = 0;  ///< number of them that estimated
  ParameterCovariance covariance;      ///< by the default procedure; none by the paper's
  WorkByStage work;
  std::shared_ptr<const FittedOptimum> fitted;  ///< by the default procedure; to go on from
};

/// No trial of a structure was stable on a record.
class NoStableModel : public DataError {
 public:
  using DataError::DataError;
};

/// Called before each fit of a structure. @param share  of the fits that are done, 0..1 @param structure  "io1"
using FitProgress = std::function<void(double share, const std::string& structure)>;

/// Estimates one structure from one record by output error. A record of constant input is refused unless it shows the
/// response to earlier input: `input_before` has another value, or an initial state is requested.
/// @throws DataError    the record is too short, constant, or not finite; as NoStableModel, nothing stable was found
/// @throws ConfigError  the structure or a parameter request makes no sense
/// Its error on the estimating samples is never above that of a structure inside it by more than 0.1 %: those are
/// fitted first, and are starts. (One exception is known, behind a valve's map: 1.4 % of the mean square.)
/// @param known  models fitted to the same rows with the same options, used in place of fits of the sub-structures;
///               no effect with the paper's procedure
/// Deterministic for a given seed, whatever the executor.
[[nodiscard]] FitResult fit(const Record& record, const StructureOptions& asked, const FitOptions& options,
                            const Executor& executor = run_in_order, const std::vector<Model>& known = {},
                            const FitProgress& progress = {});

/// The same by the default procedure, on a record that several fits share. @param options  of the same rows
[[nodiscard]] FitResult fit(const PreparedRecord& prepared, const StructureOptions& asked, const FitOptions& options,
                            const Executor& executor = run_in_order, const std::vector<Model>& known = {},
                            const FitProgress& progress = {});

/// The same, with fits of the structures inside that several fits share. All of those so far are starts, also those
/// that an earlier structure asked for: among equal optima the order of the structures may decide.
[[nodiscard]] FitResult fit(const PreparedRecord& prepared, const StructureOptions& asked, const FitOptions& options,
                            const Executor& executor, const std::vector<Model>& known, const FitProgress& progress,
                            InsideFits& inside);

/// Scores a model on a record it has not seen, without its past input: initial_output (and initial_state) as stored in
/// `score` and estimated anew in `offset_reestimated`. The bias is kept, but for one that is the level before the first
/// row: begun_on().
[[nodiscard]] ValidationReport validate(const Model& model, const Record& record, const FitOptions& options);

/// The compared rows of a record beside a model's output, of one length.
struct OutputOfModel {
  Eigen::VectorXd time_s;
  Eigen::VectorXd measured;   ///< [output unit]
  Eigen::VectorXd simulated;  ///< initial_output and initial_state estimated anew [output unit]
};

/// Simulates a model on a record as validate() does. @throws as validate(). Cost: one simulation.
[[nodiscard]] OutputOfModel output_of(const Model& model, const Record& record, const FitOptions& options);

}  // namespace eha::ident
