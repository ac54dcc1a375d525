// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>

#include "daemon/identify/progress.hpp"
#include "daemon/identify/source.hpp"
#include "ident/estimation/fit.hpp"
#include "ident/validation/parameter_change.hpp"

namespace eha::identify {

// When two records, or a model and a record, can be told to be of two plants.

// Times the usual error, regardless of the parameters' intervals.
inline constexpr double kHopeless = 5.0;
// Above it a model predicts the record, however exact a refit is.
inline constexpr double kHopelessFit_percent = 95.0;
// Joint intervals by which another experiment shifts a map's parameters on an unchanged plant, as straight lines stand
// for a curved valve with friction; measured on the simulated rig with other amplitudes, tones and levels: at most 1.4.
inline constexpr double kShiftByExperiment = 1.5;
// The same where the kind of input is another one: small sums of sines, one sine, odd multisines; at most 2.4, and
// errors of up to 34 times the usual one, which therefore tell nothing beside another input.
inline constexpr double kShiftByOtherInput = 4.0;

/// Why a straight model of a record says nothing about one of another length; empty where both are long enough.
/// @param record_s  compared of the record [s]   @param model_s  of the other one, which `of` names [s]
[[nodiscard]] std::string too_short(double record_s, double model_s, const std::string& of);

/// Options for a fit of a whole record.
[[nodiscard]] ident::FitOptions whole(ident::FitOptions options);
/// Those of the record's experiment, for a fit of all of it.
[[nodiscard]] ident::FitOptions options_of(const Source& source);

/// Progress of the fits inside the nth of `count` fits.
[[nodiscard]] ident::FitProgress part_of(const Progress& progress, std::size_t nth, std::size_t count,
                                         const std::string& of);

/// How many times a step holds another, at least once; 0 where it is no whole number of times.
[[nodiscard]] int times(double step_s, double of_s);

/// Whether the inputs differ at the times that both records have; false where their rows never coincide.
[[nodiscard]] bool has_other_input(const ident::Record& a, const ident::Record& b);

/// Whether a comparison holds although the inputs differ: both models leave plain noise over, so that no part of the
/// plant is left that another input would move otherwise, and what changed did so by more than a part within the noise
/// makes it.
[[nodiscard]] bool holds_for_other_inputs(const ident::Model& before, const ident::Model& after,
                                          const ident::PlantChange& change);

/// Whether null or dead band changed, and by no more than a map that does not fit its record may be off the valve's.
/// @param shift  as of ident::noted_shift() [input unit]
[[nodiscard]] bool explains_valve(double shift, const ident::PlantChange& change);

}  // namespace eha::identify
