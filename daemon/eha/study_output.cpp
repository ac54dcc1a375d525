// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/eha/study_output.hpp"

#include <fmt/format.h>

#include <utility>
#include <vector>

#include "core/os/files.hpp"
#include "core/shell_word.hpp"

namespace eha::cli {

void write_and_show(Console& console, StudyOutput output, const std::filesystem::path& folder) {
  for (const std::string& sentence : output.page.missing) console.warning(sentence);
  const std::filesystem::path page_file = folder / "report.html";
  const std::vector<std::pair<std::filesystem::path, const std::string&>> files{
      {folder / output.data_name, output.data},
      {folder / "study.txt", output.text},
      {page_file, output.page.html},
  };
  for (const auto& [file, content] : files) {
    os::write_file_atomically(file, content);
    output.document["files"].push_back(file.string());
  }
  console.print_json(output.document);
  console.print(output.text);
  for (const auto& [file, content] : files) console.print(fmt::format("written: {}", file.string()));
  console.next_step("xdg-open " + shell_word(page_file.string()));
}

}  // namespace eha::cli
