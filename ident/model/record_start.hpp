// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "ident/model/model.hpp"
#include "ident/model/model_output.hpp"

namespace eha::ident {

/// Whether a plant at a constant input comes to rest, within a fifth of the record that estimated it. A constant added
/// to its input is then one added to its output: input_bias is the level before that record's first row, not a property
/// of the plant. False for a grey box, and for a model that does not say how long its record was.
[[nodiscard]] bool comes_to_rest(const Model& model);

/// Time that the fit of a model compared [s]; 0 where the model does not say.
[[nodiscard]] double compared_s(const Model& model);

/// Whether a model can begin at rest at any level: it comes to rest and says the level before the first row by its bias
/// alone, as it has no map, and neither an initial state nor a past input; or it is a grey box with a state of rest.
[[nodiscard]] bool begins_at_a_level(const Model& model);

/// Whether a model that comes to rest has a map that shows no valve: no dead band and equal gains within their
/// intervals. Its null is then such a level, too.
[[nodiscard]] bool has_straight_map(const Model& model);

/// The model at rest at an input level before the first row, in place of that of its own record. The output at rest is
/// that of the model for every level.
/// @param model  begins_at_a_level(), or comes to rest, without a map
[[nodiscard]] Model begun_at(const Model& model, double level);

/// The model begun at the level that describes the start of another record best, and otherwise kept: least squares of
/// that level and an offset, which is left out again. Returns a model that does not come to rest, or that has an
/// initial state or a past input, unchanged, and one of the paper's procedure. Of a grey box that estimates its start
/// the states are estimated instead, from those at rest under the first input on. Cost: two simulations, some 20 of a
/// grey box.
[[nodiscard]] Model begun_on(const Model& model, OutputOnRecord& outputs);

}  // namespace eha::ident
