// SPDX-License-Identifier: GPL-3.0-or-later
#include "config/file_kind.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <variant>

#include "config/toml_section.hpp"
#include "core/error.hpp"
#include "hal/backends/backend.hpp"

namespace eha::config {
namespace {

/// The shipped files have a few kilobytes; a far larger file is no configuration file.
constexpr std::size_t kLargestFile = std::size_t{1} << 20U;

constexpr std::array<std::string_view, 3> kRigKeys = {"backend", "limits", "realtime"};
constexpr std::array<std::string_view, 10> kExperimentKeys = {"excitation", "characterise", "track",  "place",
                                                              "duration_s", "repetitions",  "record", "identification",
                                                              "model",      "acceptance"};

constexpr std::array<std::string_view, 4> kControllerKeys = {"feedback", "inverse", "reference", "promise"};

struct FileCloser {
  void operator()(std::FILE* file) const noexcept { std::fclose(file); }
};

[[noreturn]] void refuse_to_read(const std::string& path, int error) {
  const std::string message = path + ": cannot be read: " + error_text(error);
  if (error == EACCES || error == EPERM) throw PermissionError(message + "; check the file's owner and mode");
  throw ConfigError(message + "; check the path");
}

}  // namespace

FileKind kind_of(std::string_view text, const std::string& file_name) {
  const Document document = parse_document(text, file_name);
  const auto count = [&](const auto& keys) {
    return std::count_if(keys.begin(), keys.end(), [&](std::string_view key) { return document.root.contains(key); });
  };
  auto rig = count(kRigKeys);
  for (const hal::Backend& backend : hal::all_backends()) {
    const std::string_view table = std::visit([](const auto& options) { return options.kName; }, backend);
    if (document.root.contains(table)) ++rig;
  }
  const auto experiment = count(kExperimentKeys);
  const auto controller = count(kControllerKeys);
  if (controller > std::max(rig, experiment)) return FileKind::controller;
  if (rig == experiment) {
    throw ConfigError(file_name +
                      ": expected a rig file (backend, [limits], ...), an experiment file ([excitation], duration_s, "
                      "...) or a controller file ([feedback], [promise], ...), got the keys of none or of two");
  }
  return rig > experiment ? FileKind::rig : FileKind::experiment;
}

bool characterises(std::string_view text, const std::string& file_name) {
  return parse_document(text, file_name).root.contains("characterise");
}

bool brings_back(std::string_view text, const std::string& file_name) {
  const Document document = parse_document(text, file_name);
  return document.root["place"]["way_back"].value_or(false);
}

std::string read_config_file(const std::string& path) {
  std::error_code ignored;
  if (std::filesystem::is_directory(path, ignored)) {
    throw ConfigError(path + ": expected a configuration file, got a directory; name a file in it");
  }
  // Does not wait for a pipe without a writer; a pipe with a writer is read like a file.
  const int descriptor = open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);
  if (descriptor < 0) refuse_to_read(path, errno);
  fcntl(descriptor, F_SETFL, 0);
  const std::unique_ptr<std::FILE, FileCloser> file(fdopen(descriptor, "rb"));
  if (!file) {
    const int error = errno;
    close(descriptor);
    refuse_to_read(path, error);
  }
  std::string text(kLargestFile + 1, '\0');
  text.resize(std::fread(text.data(), 1, text.size(), file.get()));
  if (std::ferror(file.get()) != 0) refuse_to_read(path, errno);
  if (text.size() > kLargestFile) {
    throw ConfigError(path + ": expected a configuration file of at most 1 MiB, got more; check the path");
  }
  return text;
}

}  // namespace eha::config
