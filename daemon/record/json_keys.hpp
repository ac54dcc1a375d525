// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cmath>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/keys.hpp"
#include "core/volts_file.hpp"
#include "daemon/record/sha256.hpp"

namespace eha::record {

/// Writes the keys of a table as a JSON object, see core/keys.hpp. An absent value is null; an absent optional table is
/// left out.
class JsonKeys {
 public:
  using Json = nlohmann::ordered_json;

  explicit JsonKeys(Json& json) : json_(json) {}

  /// JSON has no infinity: an absent limit is null.
  void number(std::string_view key, double value, const Range&, Need = Need::required) {
    set(key, std::isfinite(value) ? Json(value) : Json(nullptr));
  }
  void boolean(std::string_view key, bool value, Need = Need::required) { set(key, value); }
  void number(std::string_view key, const std::optional<double>& value, const Range&) {
    set(key, value ? Json(*value) : Json(nullptr));
  }
  template <class Integer>
  void integer(std::string_view key, Integer value, std::int64_t, std::int64_t, Need = Need::required) {
    set(key, value);
  }
  template <class Integer>
  void integer(std::string_view key, const std::optional<Integer>& value, std::int64_t, std::int64_t) {
    set(key, value ? Json(*value) : Json(nullptr));
  }
  void text(std::string_view key, const std::string& value, Need = Need::required) { set(key, value); }
  template <class Value, class Choices>
  void choice(std::string_view key, const Value& value, const Choices& choices, Need = Need::required) {
    for (const auto& [name, choice] : choices) {
      if (choice == value) set(key, name);
    }
  }
  void number_or_unknown(std::string_view key, const std::optional<double>& value) {
    set(key, value ? Json(*value) : Json("unknown"));
  }
  template <class Table>
  void table(std::string_view key, const Table& table, Need = Need::required) {
    set(key, keys_of(table));
  }
  template <class Table>
  void optional_table(std::string_view key, const std::optional<Table>& table) {
    if (table) set(key, keys_of(*table));
  }
  template <class Table>
  void table_or_none(std::string_view key, const std::optional<Table>& table) {
    set(key, table ? keys_of(*table) : Json("none"));
  }

  template <class Table>
  void tables(std::string_view key, const std::vector<Table>& tables) {
    Json list = Json::array();
    for (const Table& table : tables) list.push_back(keys_of(table));
    set(key, std::move(list));
  }
  void volts_file(std::string_view key, const VoltsFile& file) {
    set(key, {{"name", file.name},
              {"rows", file.volts_V.size()},
              {"sha256", sha256_of(std::as_bytes(std::span(file.volts_V)))}});
  }

  /// Writes the keys of a table, as listed by `Keys`.
  template <class Keys, class Table>
  static Json keys_as(const Table& table) {
    Json json = Json::object();
    JsonKeys keys(json);
    Keys::visit_keys(table, keys);
    return json;
  }
  template <class Table>
  static Json keys_of(const Table& table) {
    return keys_as<Table>(table);
  }

 private:
  void set(std::string_view key, Json value) { json_[std::string(key)] = std::move(value); }

  Json& json_;
};

}  // namespace eha::record
