// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace eha::ident {

/// One JSON value of a model file and its path, for messages. The document and the file's name must outlive it.
/// at(), object(), list(), number(), read() and texts() throw ConfigError "FILE: PATH: expected ..., got ..." for a
/// value of another kind. Cost: logarithmic in the number of keys; lists and objects linear.
class ModelNode {
 public:
  /// Sorted keys: finds each in logarithmic time, also in a hostile file.
  using Json = nlohmann::json;

  ModelNode(const Json& value, std::string path, const std::string& file_name)
      : value_(&value), path_(std::move(path)), file_name_(&file_name) {}

  [[noreturn]] void refuse(std::string_view expected, std::string_view got) const;
  [[noreturn]] void refuse(std::string_view expected) const { refuse(expected, excerpt()); }

  [[nodiscard]] bool has(const char* key) const { return value_->contains(key); }
  [[nodiscard]] bool is_null() const { return value_->is_null(); }

  /// Returns a member; throws if it is missing.
  [[nodiscard]] ModelNode at(const char* key) const;
  /// Returns this node; throws unless it is an object with no other keys than these.
  [[nodiscard]] ModelNode object(const std::vector<std::string_view>& keys) const;
  [[nodiscard]] std::vector<ModelNode> list() const;
  [[nodiscard]] double number() const;

  /// @param target  NaN where the file has null
  void read(double& target) const { target = value_->is_null() ? std::numeric_limits<double>::quiet_NaN() : number(); }
  void read(std::string& target) const;
  void read(bool& target) const;
  void read(std::size_t& target) const;
  void read(int& target) const;
  template <typename T>
  void read(std::vector<T>& target) const {
    for (const ModelNode& node : list()) node.read(target.emplace_back());
  }
  /// Reads a member that may be missing; leaves `target` unchanged then.
  template <typename T>
  void read(const char* key, T& target) const {
    if (has(key)) child(key, (*value_)[key]).read(target);
  }

  /// Returns the members as texts of one line: a string as such, anything else as JSON text. "remarks" keeps its lines.
  [[nodiscard]] std::map<std::string, std::string> texts() const;

 private:
  [[nodiscard]] ModelNode child(const std::string& key, const Json& value) const;
  [[nodiscard]] std::string excerpt() const;

  const Json* value_;
  std::string path_;
  const std::string* file_name_;
};

/// Parses the text of a model file. Cost: linear in its length.
/// @throws ConfigError  "FILE:LINE:COLUMN: ..." for text that is not JSON, is binary or empty, or is nested too deeply
[[nodiscard]] ModelNode::Json parse_model_json(std::string_view text, const std::string& file_name);

}  // namespace eha::ident
