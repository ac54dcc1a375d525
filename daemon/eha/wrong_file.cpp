// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/eha/wrong_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <filesystem>
#include <string_view>
#include <system_error>

#include "config/file_kind.hpp"
#include "core/error.hpp"
#include "daemon/record/manifest.hpp"
#include "daemon/record/run_folder.hpp"

namespace eha::cli {
namespace {

namespace fs = std::filesystem;

/// A kind of file, as people know it.
struct Kind {
  std::string_view name;     ///< with its article
  std::string_view content;  ///< how it is told
  std::string_view taken_by;
};

constexpr Kind kRig{"a rig file", "backend, [limits]", "--rig and `eha check` take it"};
constexpr Kind kExperiment{
    "an experiment file", "[excitation], duration_s",
    "`eha run` and `eha check` take it, `eha design EXPERIMENT -o volts.csv` writes what `eha plot` draws"};
constexpr Kind kController{"a controller file", "[feedback], [promise]",
                           "`eha track`, `eha plot` and `eha export` take it"};
constexpr Kind kModel{"a model file", "JSON of `eha fit`",
                      "`eha validate`, `eha simulate`, `eha tune`, `eha report` and `eha export` take it"};
constexpr Kind kRecord{"a record", "columns of numbers",
                       "`eha fit`, `eha import`, `eha validate` and `eha plot` take it"};
constexpr Kind kRun{"a run folder", "with run.json", "`eha fit`, `eha report`, `eha plot` and `eha runs show` take it"};
constexpr Kind kManifest{"the manifest of a run", "run.json", "name the run's folder instead"};

/// What the words of a help text stand for.
struct Word {
  std::string_view word;
  const Kind* kind;
};

constexpr std::array<Word, 11> kWords{{{"EXPERIMENT", &kExperiment},
                                       {"RIG", &kRig},
                                       {"MODEL", &kModel},
                                       {"CONTROLLER", &kController},
                                       {"RUN", &kRun},
                                       {"SOURCE", &kRecord},
                                       {"SOURCE", &kRun},
                                       {"CSV", &kRecord},
                                       {"INPUT", &kRecord},
                                       {"FILE", &kRecord},
                                       {"RECORD", &kRecord}}};

/// The kinds that an argument takes.
std::vector<const Kind*> kinds_of(std::string_view takes) {
  std::vector<const Kind*> kinds;
  while (!takes.empty()) {
    const std::size_t end = std::min(takes.find('|'), takes.size());
    const std::string_view word = takes.substr(0, std::min(end, takes.find_first_of(" .")));
    for (const Word& one : kWords) {
      if (one.word == word) kinds.push_back(one.kind);
    }
    takes.remove_prefix(std::min(end + 1, takes.size()));
  }
  return kinds;
}

/// Finds the kind of a file by its content; nullptr if it is none of them, or cannot be read.
const Kind* kind_of(const fs::path& path) {
  std::error_code ignored;
  if (fs::is_directory(path, ignored)) return record::is_run_folder(path) ? &kRun : nullptr;
  if (!fs::is_regular_file(path, ignored)) return nullptr;
  const std::string extension = path.extension().string();
  constexpr std::array<std::string_view, 6> kOfRecords{".csv", ".mat", ".h5", ".hdf5", ".lvm", ".tsv"};
  if (std::find(kOfRecords.begin(), kOfRecords.end(), extension) != kOfRecords.end()) return &kRecord;
  try {
    const std::string text = config::read_config_file(path.string());
    if (const std::size_t first = text.find_first_not_of(" \t\r\n"); first != std::string::npos && text[first] == '{') {
      if (path.filename() == record::kManifestFile && record::is_run_folder(path.parent_path())) return &kManifest;
      return text.find("\"eha-model/") != std::string::npos ? &kModel : nullptr;
    }
    switch (config::kind_of(text, path.string())) {
      case config::FileKind::rig:
        return &kRig;
      case config::FileKind::experiment:
        return &kExperiment;
      case config::FileKind::controller:
        return &kController;
    }
  } catch (const Error&) {  // neither
  }
  return nullptr;
}

}  // namespace

std::string takers_of(const std::string& path) {
  const Kind* kind = kind_of(path);
  return kind == nullptr ? std::string()
                         : fmt::format("{} is {} ({}): {}", path, kind->name, kind->content, kind->taken_by);
}

std::string wrong_file(const std::vector<NamedFile>& files) {
  for (const NamedFile& file : files) {
    const std::vector<const Kind*> taken = kinds_of(file.takes);
    const Kind* kind = taken.empty() ? nullptr : kind_of(file.path);
    if (kind == nullptr || std::find(taken.begin(), taken.end(), kind) != taken.end()) continue;
    // Commands on models and records say themselves what to take from a run.
    const bool takes_settings = std::any_of(taken.begin(), taken.end(), [](const Kind* one) {
      return one == &kRig || one == &kExperiment || one == &kController;
    });
    if ((kind == &kRun || kind == &kManifest) && !takes_settings) continue;
    std::string expected;
    for (const Kind* one : taken) {
      if (!expected.empty()) expected += one == taken.back() ? " or " : ", ";
      expected += fmt::format("{} ({})", one->name, one->content);
    }
    return fmt::format("{}: is {} ({}), expected {}; {}", file.path, kind->name, kind->content, expected,
                       kind->taken_by);
  }
  return {};
}

}  // namespace eha::cli
