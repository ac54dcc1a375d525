// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

#include "core/os/own_folder.hpp"

namespace eha::cli {

/// Completed steps of a commissioning: a folder with `commission.json`, which is written after each step.
class CommissionState {
 public:
  /// Reads the folder's file, or starts a new one.
  /// @param remedy  for messages: what to do where others may change the folder or the file
  /// @throws IoError, PermissionError  as OwnFolder   @throws DataError  the file is damaged
  CommissionState(std::filesystem::path folder, std::string remedy);

  [[nodiscard]] const std::filesystem::path& folder() const noexcept { return files_.path(); }
  [[nodiscard]] std::filesystem::path file(const std::string& name) const { return folder() / name; }
  /// The folder with its files, which nobody but this user and root may change.
  [[nodiscard]] os::OwnFolder& files() noexcept { return files_; }
  [[nodiscard]] const os::OwnFolder& files() const noexcept { return files_; }

  [[nodiscard]] bool has(const std::string& step) const { return document_.at("steps").contains(step); }
  /// Returns the result of a completed step. @throws std::exception  it is not completed
  [[nodiscard]] const nlohmann::ordered_json& result(const std::string& step) const {
    return document_.at("steps").at(step);
  }
  /// Records a completed step. @throws IoError, PermissionError
  void finish(const std::string& step, nlohmann::ordered_json result);

  /// Fingerprint of the rig file after the last step; empty at first.
  [[nodiscard]] std::string rig_sha256() const { return document_.value("rig_sha256", ""); }
  /// The rig file's path; empty at first.
  [[nodiscard]] std::string rig_file() const { return document_.value("rig", ""); }
  void set_rig(const std::string& file, const std::string& sha256);

  [[nodiscard]] const nlohmann::ordered_json& document() const noexcept { return document_; }

 private:
  void write();

  os::OwnFolder files_;
  nlohmann::ordered_json document_;
};

}  // namespace eha::cli
