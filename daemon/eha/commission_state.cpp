// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/eha/commission_state.hpp"

#include <optional>
#include <string>
#include <utility>

#include "core/error.hpp"
#include "daemon/record/one_line_texts.hpp"

namespace eha::cli {
namespace {

using Json = nlohmann::ordered_json;

constexpr const char* kStateFile = "commission.json";

}  // namespace

CommissionState::CommissionState(std::filesystem::path folder, std::string remedy)
    : files_(std::move(folder), std::move(remedy)),
      document_{{"schema", "eha-commission/1"}, {"steps", Json::object()}} {
  const std::optional<std::string> text = files_.read(kStateFile);
  if (!text) return;
  const std::string name = file(kStateFile).string();
  document_ = Json::parse(*text, nullptr, false);
  record::make_one_line(document_);
  if (!document_.is_object() || document_.value("schema", "") != "eha-commission/1" || !document_.contains("steps") ||
      !document_.at("steps").is_object()) {
    throw DataError(name + ": is no state of a commissioning; name another folder with -o");
  }
}

void CommissionState::finish(const std::string& step, Json result) {
  document_["steps"][step] = std::move(result);
  write();
}

void CommissionState::set_rig(const std::string& rig_file, const std::string& sha256) {
  document_["rig"] = rig_file;
  document_["rig_sha256"] = sha256;
  write();
}

void CommissionState::write() {
  files_.make();
  files_.write(kStateFile, document_.dump(2) + "\n");
}

}  // namespace eha::cli
