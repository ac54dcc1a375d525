// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "process.hpp"

namespace eha::test {

/// `ehad` on a rig of the test machine, ended as systemd ends it when this goes. Every user may use its socket.
class Service {
 public:
  /// @throws std::runtime_error  it does not listen
  explicit Service(const std::string& rig_file);
  Service(const Service&) = delete;
  Service& operator=(const Service&) = delete;
  ~Service();

  /// A command of `eha` for the service. @param words  without eha and --socket
  [[nodiscard]] Process eha(std::vector<std::string> words, const ProcessOptions& options = {}) const;

 private:
  std::filesystem::path folder_;
  Process process_;
};

}  // namespace eha::test
