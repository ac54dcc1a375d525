// SPDX-License-Identifier: GPL-3.0-or-later
#include "hal/comedi/safe_snapshot.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>

#include "core/error.hpp"

namespace eha::hal {
namespace {

using Json = nlohmann::ordered_json;
constexpr const char* kSchema = "eha-safe/1";
/// A snapshot has a few hundred bytes; a file beyond this is something else.
constexpr std::uintmax_t kLargestFile = 65536;

/// A file descriptor that closes itself.
class File {
 public:
  explicit File(int descriptor) noexcept : descriptor_(descriptor) {}
  File(const File&) = delete;
  File& operator=(const File&) = delete;
  ~File() {
    if (descriptor_ >= 0) close(descriptor_);
  }
  [[nodiscard]] int get() const noexcept { return descriptor_; }

 private:
  int descriptor_;
};

[[noreturn]] void fail(const std::filesystem::path& path, const char* doing) {
  throw IoError(path.string() + ": " + doing + ": " + std::strerror(errno));
}

void write_all(int descriptor, std::string_view text, const std::filesystem::path& path) {
  while (!text.empty()) {
    const ssize_t written = write(descriptor, text.data(), text.size());
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) fail(path, "cannot write");
    text.remove_prefix(static_cast<std::size_t>(written));
  }
}

unsigned number(const Json& object, const char* key) {
  const Json& value = object.at(key);
  // get<unsigned> would take -1 and 1.5 without a word.
  if (!value.is_number_unsigned() || value.get<std::uint64_t>() > 0xffffffffU) {
    throw ConfigError(std::string(key) + ": expected a whole number from 0 to 4294967295, got " + value.dump());
  }
  return value.get<unsigned>();
}

}  // namespace

std::string to_text(const SafeSnapshot& s) {
  Json json = {
      {"schema", kSchema},
      {"device", s.device},
      {"board", s.board},
      {"output", {{"subdevice", s.subdevice}, {"channel", s.channel}, {"range", s.range}, {"reference", s.reference}}},
      {"safe_code", s.safe_code},
      {"safe_V", s.safe_V},
      {"enable", nullptr}};
  if (s.enable) {
    json["enable"] = {{"subdevice", s.enable->subdevice},
                      {"channel", s.enable->channel},
                      {"off_level", s.enable->off_level},
                      {"is_bidirectional", s.enable->is_bidirectional}};
  }
  return json.dump(2) + "\n";
}

SafeSnapshot safe_snapshot_from_text(std::string_view text, std::string_view file_name) {
  try {
    const Json json = Json::parse(text);
    if (json.at("schema") != kSchema) {
      throw ConfigError(std::string("schema: expected \"") + kSchema + "\", got " + json.at("schema").dump());
    }
    SafeSnapshot s;
    s.device = json.at("device").get<std::string>();
    s.board = json.at("board").get<std::string>();
    const Json& output = json.at("output");
    s.subdevice = number(output, "subdevice");
    s.channel = number(output, "channel");
    s.range = number(output, "range");
    s.reference = number(output, "reference");
    s.safe_code = number(json, "safe_code");
    s.safe_V = json.at("safe_V").get<double>();
    if (const Json& enable = json.at("enable"); !enable.is_null()) {
      s.enable = SafeSnapshot::Line{.subdevice = number(enable, "subdevice"),
                                    .channel = number(enable, "channel"),
                                    .off_level = number(enable, "off_level"),
                                    .is_bidirectional = enable.at("is_bidirectional").get<bool>()};
      if (s.enable->channel > 31) throw ConfigError("enable.channel: expected from 0 to 31");
      if (s.enable->off_level > 1) throw ConfigError("enable.off_level: expected 0 or 1");
    }
    return s;
  } catch (const Json::exception& error) {
    throw ConfigError(std::string(file_name) + ": not a snapshot of a rig: " + error.what());
  } catch (const ConfigError& error) {
    throw ConfigError(std::string(file_name) + ": " + error.what());
  }
}

void write_safe_snapshot(const SafeSnapshot& snapshot, const std::filesystem::path& path) {
  std::filesystem::path temporary = path;
  temporary += ".new";
  {
    const File file(open(temporary.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0644));
    if (file.get() < 0) fail(temporary, "cannot create");
    write_all(file.get(), to_text(snapshot), temporary);
    if (fsync(file.get()) != 0) fail(temporary, "cannot flush");
  }
  if (rename(temporary.c_str(), path.c_str()) != 0) fail(path, "cannot replace");
  const std::filesystem::path folder = path.has_parent_path() ? path.parent_path() : ".";
  const File directory(open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  if (directory.get() < 0 || fsync(directory.get()) != 0) fail(folder, "cannot flush");
}

SafeSnapshot read_safe_snapshot(const std::filesystem::path& path) {
  std::error_code error;
  const std::uintmax_t size = std::filesystem::file_size(path, error);
  if (error) throw IoError(path.string() + ": cannot read the snapshot of the rig: " + error.message());
  if (size > kLargestFile)
    throw ConfigError(path.string() + ": not a snapshot of a rig: " + std::to_string(size) + " bytes");
  std::ifstream file(path, std::ios::binary);
  const std::string text{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
  if (!file.is_open() || file.bad()) fail(path, "cannot read the snapshot of the rig");
  return safe_snapshot_from_text(text, path.string());
}

}  // namespace eha::hal
