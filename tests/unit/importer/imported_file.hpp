// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <functional>
#include <optional>
#include <sstream>
#include <string>
#include <vector>

#include "core/error.hpp"
#include "daemon/importer/import.hpp"
#include "tests/unit/temporary_folder.hpp"

namespace eha::importer {

/// The commands of a refusal, in their order.
inline std::vector<std::string> commands_of(const std::string& refusal) {
  std::vector<std::string> commands;
  for (std::size_t begin = refusal.find('`'); begin != std::string::npos;) {
    const std::size_t end = refusal.find('`', begin + 1);
    commands.push_back(refusal.substr(begin + 1, end - begin - 1));
    begin = end == std::string::npos ? end : refusal.find('`', end + 1);
  }
  return commands;
}

/// The options of such a command, of which the last counts.
inline Options options_of(const std::string& command) {
  Options options;
  std::istringstream words(command);
  std::string word;
  const auto sign = [](const std::string& name) { return name == "comma" ? ',' : name == "point" ? '.' : '\''; };
  while (words >> word) {
    if (word == "--resample") options.resample = true;
    if (!word.starts_with("--") || word == "--resample") continue;
    std::string value;
    words >> value;
    if (word == "--time") options.time = value;
    if (word == "--input") options.input = value;
    if (word == "--output") options.output = value;
    if (word == "--period") options.period_s = std::stod(value);
    if (word == "--from") options.from_s = std::stod(value);
    if (word == "--to") options.to_s = std::stod(value);
    if (word == "--decimal") options.decimal = sign(value);
    if (word == "--thousands") options.thousands = sign(value);
  }
  return options;
}

class ImportedFile : public testing::Test {
 protected:
  std::filesystem::path write(const std::string& name, const std::string& text) { return folder_.write(name, text); }

  static std::string refusal_of(const std::filesystem::path& path, const Options& options = {}) {
    try {
      return "taken: " + import_record(path, options).guess;
    } catch (const Error& error) {
      return error.what();
    }
  }

  /// What the command number `at` of a refusal reads.
  static Imported answered(const std::filesystem::path& path, const std::string& refusal, std::size_t at = 0) {
    const std::vector<std::string> commands = commands_of(refusal);
    if (at >= commands.size()) throw std::runtime_error("no such command: " + refusal);
    return import_record(path, options_of(commands[at]));
  }

  /// Runs commands of a shell in the folder of the files. @returns whether all went well
  [[nodiscard]] bool shell(const std::string& command) const {
    return std::system(fmt::format("cd '{}' && {}", folder_.path().string(), command).c_str()) == 0;
  }

  test::TemporaryFolder folder_;
};

/// 300 volts and places of a rod, and the text of rows of them.
struct Rig {
  static constexpr int kRows = 300;
  static double volts(int k) { return 4.0 * std::sin(0.1 * k); }
  static double place(int k) { return 50.0 + 10.0 * std::sin(0.1 * k - 0.5); }

  static std::string rows(const std::string& header, const std::function<std::string(int)>& row, int count = kRows) {
    std::string text = header;
    for (int k = 0; k < count; ++k) text += row(k) + "\n";
    return text;
  }
};

inline std::string with_commas(std::string text) {
  std::replace(text.begin(), text.end(), '.', ',');
  return text;
}

}  // namespace eha::importer
