// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "core/error.hpp"
#include "daemon/eha/model_options.hpp"
#include "daemon/importer/importer_options.hpp"
#include "ident/fit_options.hpp"

namespace eha::cli {

class Console;

struct FitCommand {
  std::string source;  ///< run folder or file with a record
  importer::Options import = {};
  std::optional<std::string> experiment_file = {};
  std::optional<ident::Procedure> procedure = {};
  bool compares_with_paper = false;  ///< --procedure both; `procedure` is the default one then
  std::optional<std::uint64_t> seed = {};
  RecordOptions record;
  ModelOptions models;
  std::optional<std::filesystem::path> output = {};     ///< folder for one model file per model
  bool sweep = false;                                   ///< the commensurate order over sweep_orders instead
  std::vector<double> sweep_orders = {0.5, 1.2, 0.05};  ///< first, last, step
  bool cross_validate = false;                          ///< on each repetition, scored on the others
};

[[nodiscard]] ExitCode execute(const FitCommand& command, Console& console);

}  // namespace eha::cli
