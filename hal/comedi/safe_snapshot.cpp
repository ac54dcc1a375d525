// SPDX-License-Identifier: GPL-3.0-or-later
#include "hal/comedi/safe_snapshot.hpp"

#include <cstdint>
#include <nlohmann/json.hpp>
#include <sstream>

#include "core/error.hpp"
#include "hal/comedi/comedi_options.hpp"

namespace eha::hal {
namespace {

using Json = nlohmann::ordered_json;
constexpr const char* kSchema = "eha-safe/1";

unsigned number(const Json& object, const char* key) {
  const Json& value = object.at(key);
  // get<unsigned> would accept -1 and 1.5 without an error.
  if (!value.is_number_unsigned() || value.get<std::uint64_t>() > 0xffffffffU) {
    throw ConfigError(std::string(key) + ": expected a whole number from 0 to 4294967295, got " + value.dump());
  }
  return value.get<unsigned>();
}

}  // namespace

std::string to_text(const SafeSnapshot& s) {
  Json json = {
      {"schema", kSchema},
      {"backend", ComediOptions::kName},
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

SafeAction ComediOptions::safe_action(std::string_view snapshot, std::string_view file_name) {
  const auto card = std::make_shared<SafeCard>(safe_snapshot_from_text(snapshot, file_name));
  SafeAction action{.device = card->snapshot().device, .make_safe = [card](std::chrono::milliseconds patience) {
                      card->make_safe(patience);
                      std::ostringstream done;
                      done << "output at " << card->snapshot().safe_V << " V, "
                           << (card->snapshot().enable ? "hydraulics off" : "no enable line");
                      return done.str();
                    }};
  if (card->snapshot().enable) action.switch_off = [card] { return card->switch_off(); };
  action.keep_open = [card] { return card->keep_open(); };
  return action;
}

}  // namespace eha::hal
