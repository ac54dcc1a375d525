// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
#include <string>

#include "daemon/identify/identification.hpp"
#include "ident/estimation/fit.hpp"
#include "ident/validation/verdict.hpp"

namespace eha::identify {

/// What is known of the task's record for a verdict.
[[nodiscard]] ident::RecordFacts facts_of(const IdentificationTask& task);

/// Returns the lowest and highest line of the source's experiment, if it has lines.
[[nodiscard]] std::optional<ident::FrequencyInterval> excited_lines_of(const Source& source);

/// Returns the band in which the input of a model's record moves [Hz]; none where it does not. Cost: an FFT of the
/// input, unless the experiment's lines are known.
[[nodiscard]] std::optional<ident::FrequencyInterval> excited_by(const IdentificationTask& task,
                                                                 const ident::FitResult& result);

/// Notes in a model's provenance what its verdict reads there of the task's record: where the sensor froze, where rows
/// are missing, what to cut, and that the input hardly leaves the dead band. What it says of another record is removed.
void note_record(const IdentificationTask& task, ident::Model& model);

/// Gives a fitted model its verdict, with all known facts of the record, its usable band and its origin.
/// @param excited  of excited_by(); none: no usable band is given
/// Cost: the model's frequency response at some hundred frequencies.
void judge(const IdentificationTask& task, const std::optional<ident::FrequencyInterval>& excited,
           ident::FitResult& result);

/// Notes where to cut beside a jump of the error, else a change of the gain, where the record has no end stop, which
/// stands first. @param measured, simulated  at these times of the record, as many of each [output unit]. Cost O(N)
void note_sudden_change(const Eigen::VectorXd& time_s, const Eigen::VectorXd& measured,
                        const Eigen::VectorXd& simulated, ident::Model& model);

/// Whether any model is told to be of a record in closed loop: of a quiet loop where none of them follows the record,
/// or where its input seems to have noise that did not reach the plant.
[[nodiscard]] bool is_loop_noted(const Identification& identification);

/// Adds a sentence on the record to those that a model's file keeps for its report.
void add_remark(ident::Model& model, const std::string& remark);

/// How the input was taken between the rows of the record that estimated a model, as judge() wrote it.
[[nodiscard]] ident::Intersample intersample_of(const ident::Model& model);

/// Recommends a model, and judges the others by it. A clearly worse model is usable where the two agree, unless only
/// one of them has a map: the gain of a linear model of a valve changes with the amplitude.
/// Cost: one more verdict for each model.
void choose(const IdentificationTask& task, Identification& identification);

}  // namespace eha::identify
