// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "ident/structure/structure.hpp"
#include "ident/structure/structures.hpp"

namespace eha::ident {

/// A user's request for one parameter. For unset members the structure's choice applies.
struct ParameterRequest {
  std::string name;           ///< as in Model::parameters: "n2", "a0", "K", "b0", "q", "delay_s", "input_bias"
  std::optional<bool> fixed;  ///< true holds it at `start`, false frees it
  std::optional<double> start;
  std::optional<double> lower;
  std::optional<double> upper;
};

/// Whether the model includes the response to input before t = 0. With a finite state it is the response of an unknown
/// state; `automatic` includes it if the data support it. Otherwise it is the response to an unknown past input, with
/// `estimated` only.
enum class InitialState { automatic, none, estimated };

/// One model to fit.
struct StructureOptions {
  std::string name = "io";  ///< file name of the model
  Structure structure = structures::io();
  InitialState initial_state = InitialState::automatic;
  std::vector<ParameterRequest> parameters = {};
};

}  // namespace eha::ident
