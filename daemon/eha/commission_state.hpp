// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

namespace eha::cli {

/// Completed steps of a commissioning: a folder with `commission.json`, which is written after each step.
class CommissionState {
 public:
  /// Reads the folder's file, or starts a new one. @throws IoError, PermissionError, DataError  it is damaged
  explicit CommissionState(std::filesystem::path folder);

  [[nodiscard]] const std::filesystem::path& folder() const noexcept { return folder_; }
  [[nodiscard]] std::filesystem::path file(const std::string& name) const { return folder_ / name; }

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
  void write() const;

  std::filesystem::path folder_;
  nlohmann::ordered_json document_;
};

}  // namespace eha::cli
