// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <nlohmann/json.hpp>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace eha {

/// What a JSON text may hold. Whoever parses a stranger's text looks at it first: the library walks a document by
/// recursion, takes some 80 bytes a value, and finds a key of an ordered object by a linear search.
struct JsonBounds {
  int depth = 64;
  std::size_t values = 8'000'000;
  std::size_t keys_of_object = 1000;
};

enum class JsonFault { none, syntax, too_deep, too_many_values, too_many_keys, repeated_key };

struct JsonShape {
  JsonFault fault = JsonFault::none;
  std::string key = {};  ///< that is there twice, of a repeated_key
};

/// Whether an object may hold a key twice.
enum class JsonKeys { any, unique };

namespace detail {

class ShapeReader final : public nlohmann::json_sax<nlohmann::json> {
 public:
  ShapeReader(const JsonBounds& bounds, JsonKeys keys) : bounds_(bounds), keys_(keys) {}

  [[nodiscard]] JsonShape found() && { return std::move(found_); }

  bool null() override { return count(); }
  bool boolean(bool) override { return count(); }
  bool number_integer(number_integer_t) override { return count(); }
  bool number_unsigned(number_unsigned_t) override { return count(); }
  bool number_float(number_float_t, const string_t&) override { return count(); }
  bool string(string_t&) override { return count(); }
  bool binary(binary_t&) override { return count(); }
  bool start_object(std::size_t) override { return open(); }
  bool start_array(std::size_t) override { return open(); }
  bool end_object() override { return close(); }
  bool end_array() override { return close(); }

  bool key(string_t& name) override {
    Level& level = levels_.back();
    if (++level.keys > bounds_.keys_of_object) return is_wrong(JsonFault::too_many_keys);
    if (keys_ == JsonKeys::any || level.names.insert(name).second) return true;
    found_.key = name;
    return is_wrong(JsonFault::repeated_key);
  }

  bool parse_error(std::size_t, const std::string&, const nlohmann::detail::exception&) override {
    return is_wrong(JsonFault::syntax);
  }

 private:
  struct Level {
    std::size_t keys = 0;
    std::set<std::string> names = {};
  };

  bool is_wrong(JsonFault fault) {
    found_.fault = fault;
    return false;
  }
  bool count() { return ++values_ <= bounds_.values || is_wrong(JsonFault::too_many_values); }
  bool open() {
    levels_.emplace_back();
    if (levels_.size() > static_cast<std::size_t>(bounds_.depth)) return is_wrong(JsonFault::too_deep);
    return count();
  }
  bool close() {
    levels_.pop_back();
    return true;
  }

  JsonBounds bounds_;
  JsonKeys keys_;
  std::vector<Level> levels_;
  std::size_t values_ = 0;
  JsonShape found_;
};

}  // namespace detail

/// Reads a text without keeping it, up to its first fault. Cost O(n), O(n log k) with unique keys, of which those of
/// the open objects are kept.
[[nodiscard]] inline JsonShape json_shape(std::string_view text, const JsonBounds& bounds,
                                          JsonKeys keys = JsonKeys::any) {
  detail::ShapeReader reader(bounds, keys);
  nlohmann::json::sax_parse(text.begin(), text.end(), &reader);
  return std::move(reader).found();
}

}  // namespace eha
