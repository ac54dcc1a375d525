// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <vector>

namespace eha::cli {

/// A file or folder of the command line.
struct NamedFile {
  std::string path;
  std::string takes;  ///< kinds that the argument takes, as in its help: "RIG", "MODEL|RUN"
};

/// Says which named file is of a kind that its argument does not take, what was expected, and which commands take it.
/// Meant for after a refusal: reads the files. @returns empty if every kind is right or not recognised
[[nodiscard]] std::string wrong_file(const std::vector<NamedFile>& files);

/// What a file is and which commands take it, of one that a command does not expect; empty where its kind is not
/// recognised. Reads the file.
[[nodiscard]] std::string takers_of(const std::string& path);

}  // namespace eha::cli
