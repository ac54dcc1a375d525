// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <vector>

namespace eha::ident {

enum class Procedure { standard, paper };  ///< spelled "default" and "paper" in files

/// The family a model is sought in.
enum class StructureKind {
  io,            ///< integer orders: `poles` poles, `zeros` zeros
  fo,            ///< K s^b0 / (a2 s^n2 + a1 s^n1 + a0)
  commensurate,  ///< polynomials in s^q of degrees `zeros` and `poles`
  lag,           ///< K / (a1 s^n1 + a0)
};

/// What the user wants of one parameter; unset members are the structure's own choice.
struct ParameterRequest {
  std::string name;  ///< as in Model::parameters: "n2", "a0", "K", "b0", "q", "delay_s", "input_bias", "initial_output"
  std::optional<bool> fixed;  ///< true holds it at `start`, false frees it
  std::optional<double> start;
  std::optional<double> lower;
  std::optional<double> upper;
};

/// Whether the response to what came before t = 0 is part of the model: for integer orders that of an unknown state,
/// which automatic takes when the data ask for it; else that to an unknown past input, only when asked for.
enum class InitialState { automatic, none, estimated };

/// One model to look for.
struct StructureOptions {
  std::string name = "io";  ///< file name of the model
  StructureKind kind = StructureKind::io;
  int poles = 2;  ///< io and commensurate: 1..10
  int zeros = 0;  ///< io and commensurate: 0..poles
  bool delay_free = false;
  double delay_s = 0.0;  ///< value when held, start when free [s]
  InitialState initial_state = InitialState::automatic;
  std::vector<ParameterRequest> parameters;
};

/// Where a fit starts.
enum class Search {
  global,  ///< anywhere in the structure's search box, then local
  local,   ///< at the requested start values, nowhere else
};

/// Where the 95 % intervals come from.
enum class IntervalMethod {
  profile,   ///< the profile of the cost where it is no parabola; takes as long as a hundred local fits then
  straight,  ///< standard errors alone, where only the estimates are wanted
};

/// How a record is used.
struct FitOptions {
  Procedure procedure = Procedure::standard;
  Search search = Search::global;
  IntervalMethod intervals = IntervalMethod::profile;
  int decimation = 1;      ///< every how many samples model and data are compared
  double discard_s = 0.0;  ///< not compared, though simulated [s]
  double split = 0.5;      ///< share of the compared samples that estimates; 1 leaves no validation
  std::uint64_t seed = 1;
};

/// What a model must reach to be written to disk as accepted.
struct AcceptanceLimits {
  double min_validation_r2_percent = 90.0;
  double max_abs_error = std::numeric_limits<double>::infinity();  ///< [output unit]
  bool require_stable = true;
  double min_stability_margin_rad = 0.0;
};

}  // namespace eha::ident
