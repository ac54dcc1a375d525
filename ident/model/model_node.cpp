// SPDX-License-Identifier: GPL-3.0-or-later
#include "ident/model/model_node.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "core/error.hpp"
#include "core/json_shape.hpp"
#include "core/terminal_text.hpp"
#include "core/text.hpp"

namespace eha::ident {
namespace {

using Json = ModelNode::Json;

/// A model file is seven levels deep; a far deeper one is refused.
constexpr int kDeepest = 32;

/// The member with a sentence a line; it is in no message.
constexpr std::string_view kSentences = "remarks";

/// The JSON library's message without the offending bytes.
std::string syntax_detail(std::string_view what) {
  constexpr std::string_view kMarker = "syntax error ";
  if (const auto start = what.find(kMarker); start != std::string_view::npos)
    what.remove_prefix(start + kMarker.size());
  std::string detail(what.substr(0, what.find("; last read")));
  if (const auto wanted = what.rfind("; expected"); wanted != std::string_view::npos && wanted >= detail.size()) {
    detail += what.substr(wanted);
  }
  return shortened(detail, 160);
}

/// "line:column" of a byte counted from 1.
std::string place(std::string_view text, std::size_t byte) {
  const std::string_view before = text.substr(0, byte > 0 ? byte - 1 : 0);
  const auto line = 1 + std::count(before.begin(), before.end(), '\n');
  const std::size_t last_break = before.rfind('\n');
  const std::string_view row = last_break == std::string_view::npos ? before : before.substr(last_break + 1);
  // Bytes 10xxxxxx continue a character.
  const auto column = 1 + std::count_if(row.begin(), row.end(), [](char c) { return (c & '\xC0') != '\x80'; });
  return fmt::format("{}:{}", line, column);
}

}  // namespace

void ModelNode::refuse(std::string_view expected, std::string_view got) const {
  throw ConfigError(
      fmt::format("{}: {}: expected {}, got {}", *file_name_, path_.empty() ? "model" : path_, expected, got));
}

ModelNode ModelNode::at(const char* key) const {
  if (!has(key)) child(key, Json()).refuse("a value", "no such field");
  return child(key, (*value_)[key]);
}

ModelNode ModelNode::object(const std::vector<std::string_view>& keys) const {
  if (!value_->is_object()) refuse("an object");
  for (const auto& [key, value] : value_->items()) {
    if (std::find(keys.begin(), keys.end(), key) != keys.end()) continue;
    child(key, value).refuse("a known field" + suggestion(key, keys), "an unknown one");
  }
  return *this;
}

std::vector<ModelNode> ModelNode::list() const {
  if (!value_->is_array()) refuse("an array");
  std::vector<ModelNode> nodes;
  nodes.reserve(value_->size());
  for (std::size_t i = 0; i < value_->size(); ++i) {
    nodes.emplace_back((*value_)[i], fmt::format("{}[{}]", path_, i), *file_name_);
  }
  return nodes;
}

double ModelNode::number() const {
  if (!value_->is_number()) refuse("a number");
  return value_->get<double>();
}

void ModelNode::read(std::string& target) const {
  if (!value_->is_string()) refuse("a string");
  target = one_line(value_->get_ref<const std::string&>());
}

void ModelNode::read(bool& target) const {
  if (!value_->is_boolean()) refuse("true or false");
  target = value_->get<bool>();
}

void ModelNode::read(std::size_t& target) const {
  if (!value_->is_number_unsigned()) refuse("a whole number of at least 0");
  target = value_->get<std::size_t>();
}

void ModelNode::read(int& target) const {
  const bool fits = value_->is_number_integer() && value_->get<double>() >= std::numeric_limits<int>::min() &&
                    value_->get<double>() <= std::numeric_limits<int>::max();
  if (!fits) refuse("a whole number");
  target = value_->get<int>();
}

std::map<std::string, std::string> ModelNode::texts() const {
  if (!value_->is_object()) refuse("an object");
  std::map<std::string, std::string> result;
  for (const auto& [key, value] : value_->items()) {
    const std::string text = value.is_string() ? value.get<std::string>() : value.dump();
    result[one_line(key)] = key == kSentences ? terminal_text(text) : one_line(text);
  }
  return result;
}

ModelNode ModelNode::child(const std::string& key, const Json& value) const {
  const std::string name = shortened(key, 60);
  return {value, path_.empty() ? name : path_ + "." + name, *file_name_};
}

std::string ModelNode::excerpt() const {
  if (value_->is_structured()) return value_->is_array() ? "an array" : "an object";
  return shortened(value_->dump(-1, ' ', true, Json::error_handler_t::replace), 40);
}

Json parse_model_json(std::string_view text, const std::string& file_name) {
  if (text.find_first_not_of(" \t\r\n") == std::string_view::npos) {
    throw ConfigError(file_name + ": expected a model in JSON, got an empty file");
  }
  if (text.find('\0') != std::string_view::npos) {
    throw ConfigError(file_name + ": expected a model in JSON, got a binary file");
  }
  const JsonBounds bounds{.depth = kDeepest};
  switch (json_shape(text, bounds).fault) {
    case JsonFault::too_deep:
      throw ConfigError(fmt::format("{}: expected a model at most {} levels deep, got more", file_name, kDeepest));
    case JsonFault::too_many_values:
      throw ConfigError(fmt::format("{}: expected a model of at most {} values, got more", file_name, bounds.values));
    case JsonFault::too_many_keys:
      throw ConfigError(fmt::format("{}: expected a model with at most {} keys in an object, got more", file_name,
                                    bounds.keys_of_object));
    case JsonFault::none:
    case JsonFault::syntax:
    case JsonFault::repeated_key:
      break;
  }
  try {
    return Json::parse(text.begin(), text.end());
  } catch (const Json::parse_error& error) {
    throw ConfigError(fmt::format("{}:{}: expected a model in JSON, got a syntax error {}", file_name,
                                  place(text, error.byte), syntax_detail(error.what())));
  } catch (const Json::exception& error) {
    throw ConfigError(fmt::format("{}: expected a model in JSON, got {}", file_name, shortened(error.what(), 160)));
  }
}

}  // namespace eha::ident
