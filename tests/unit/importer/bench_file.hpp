// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <string>

#include "core/error.hpp"
#include "daemon/importer/import.hpp"
#include "tests/unit/temporary_folder.hpp"

namespace eha::importer {

inline std::string with_comma(double value, int decimals) {
  std::string text = fmt::format("{:.{}f}", value, decimals);
  if (const std::size_t point = text.find('.'); point != std::string::npos) text[point] = ',';
  return text;
}

/// Files of the bench, read as the program reads them.
class BenchFile : public testing::Test {
 protected:
  std::filesystem::path write(const std::string& name, const std::string& text) { return folder_.write(name, text); }

  static std::string refusal_of(const std::filesystem::path& path, const Options& options = {}) {
    try {
      static_cast<void>(import_record(path, options));
      return "";
    } catch (const DataError& error) {
      return error.what();
    }
  }

  static std::string remarks_of(const std::filesystem::path& path) {
    return fmt::format("{}", fmt::join(import_record(path, {}).remarks, "\n"));
  }

  /// What a refusal offers as the sample period.
  static double offered(const std::string& refusal) {
    const std::size_t at = refusal.find("--period ");
    return at == std::string::npos ? 0.0 : std::strtod(refusal.c_str() + at + 9, nullptr);
  }

  test::TemporaryFolder folder_;
};

}  // namespace eha::importer
