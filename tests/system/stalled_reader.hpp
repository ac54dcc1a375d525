// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <fcntl.h>
#include <sys/stat.h>
#include <sys/types.h>
#include <unistd.h>

#include <array>
#include <filesystem>
#include <stdexcept>
#include <string>

namespace eha::test {

/// A pipe with a name whose reader has stopped reading.
class StalledReader {
 public:
  explicit StalledReader(const std::filesystem::path& path) : path_(path) {
    if (mkfifo(path.c_str(), 0600) != 0) throw std::runtime_error("cannot make a pipe");
    descriptor_ = open(path.c_str(), O_RDWR | O_NONBLOCK | O_CLOEXEC);
  }
  StalledReader(const StalledReader&) = delete;
  StalledReader& operator=(const StalledReader&) = delete;
  ~StalledReader() { close(descriptor_); }

  void fill() const {
    const std::array<char, 1024> bytes{};
    while (write(descriptor_, bytes.data(), bytes.size()) > 0) {
    }
    while (write(descriptor_, bytes.data(), 1) > 0) {
    }
  }
  [[nodiscard]] std::string drain() const {
    std::string text;
    std::array<char, 4096> bytes{};
    for (ssize_t count = 0; (count = read(descriptor_, bytes.data(), bytes.size())) > 0;) {
      text.append(bytes.data(), static_cast<std::size_t>(count));
    }
    return text;
  }

 private:
  std::filesystem::path path_;
  int descriptor_ = -1;
};

}  // namespace eha::test
