// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "ident/structure/structure.hpp"
#include "ident/structure/structures.hpp"

namespace eha::ident {

/// What the user wants of one parameter; unset members are the structure's own choice.
struct ParameterRequest {
  std::string name;           ///< as in Model::parameters: "n2", "a0", "K", "b0", "q", "delay_s", "input_bias"
  std::optional<bool> fixed;  ///< true holds it at `start`, false frees it
  std::optional<double> start;
  std::optional<double> lower;
  std::optional<double> upper;
};

/// Whether the response to what came before t = 0 is part of the model: that of an unknown state where the structure
/// has a finite one, which automatic takes when the data ask for it; else that to an unknown past input, only when
/// asked for.
enum class InitialState { automatic, none, estimated };

/// One model to look for.
struct StructureOptions {
  std::string name = "io";  ///< file name of the model
  Structure structure = structures::io();
  InitialState initial_state = InitialState::automatic;
  std::vector<ParameterRequest> parameters = {};
};

}  // namespace eha::ident
