// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

#include "daemon/eha/console.hpp"
#include "daemon/report/page.hpp"

namespace eha::cli {

/// Results of a study, in each of their forms.
struct StudyOutput {
  nlohmann::ordered_json document;  ///< of --json; write_and_show() adds the files
  std::string text;                 ///< table and conclusions
  report::Page page;
  std::string data_name;  ///< name of the file for programs
  std::string data;       ///< its content
};

/// Writes the data, study.txt and report.html to `folder`, prints the text and names the files and the next step.
/// @throws IoError  a file cannot be written
void write_and_show(Console& console, StudyOutput output, const std::filesystem::path& folder);

}  // namespace eha::cli
