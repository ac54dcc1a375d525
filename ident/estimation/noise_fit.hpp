// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <optional>

#include "ident/estimation/fit_choice.hpp"

namespace eha::ident {

/// Repeats the search from an optimum with a noise model: whitens residual and derivatives by the autoregressive model
/// of the residual, whose correlations are first corrected for what the estimation took from the noise. Repeats this
/// once from the new residual. Coloured noise then costs the parameters less precision, and their errors follow from
/// the noise at each frequency.
/// @param most_cost    output error (sum of squares) of a model inside this structure, or infinity
/// @param work  counted on
/// @returns nothing where it does not help: the residual is white, the search does not converge, AR-BIC does not fall,
///          a standard error grows by half, a parameter moves by more than three of its standard errors, or the output
///          error (sum of squares) rises by more than the parameters' errors explain or above most_cost; the residual
///          then holds what the structure could follow or what it cannot, and is no noise
/// Cost: some ten simulations with derivatives. Cochrane and Orcutt, J. Am. Stat. Assoc. 44 (1949); the correlations
/// that an estimation takes: Harville, J. Am. Stat. Assoc. 72 (1977); two estimates that differ where the model is
/// wrong: Hausman, Econometrica 46 (1978).
[[nodiscard]] std::optional<LocalOptimum> with_noise_model(const ComparedRecord& compared, const LocalOptimum& plain,
                                                           double most_cost, Work& work);

}  // namespace eha::ident
