// SPDX-License-Identifier: GPL-3.0-or-later
#include "config/excitation_section.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <string>
#include <utility>
#include <variant>
#include <vector>

namespace eha::config {
namespace {

/// Lists the keys of a kind.
class KeyNames {
 public:
  explicit KeyNames(const ident::ExcitationKind& kind) {
    std::visit([&](const auto& options) { options.visit_keys(options, *this); }, kind);
  }
  [[nodiscard]] bool contains(std::string_view key) const {
    return std::find(names_.begin(), names_.end(), key) != names_.end();
  }
  [[nodiscard]] const std::vector<std::string_view>& names() const { return names_; }

  void number(std::string_view key, auto&&...) { names_.push_back(key); }
  void integer(std::string_view key, auto&&...) { names_.push_back(key); }
  void text(std::string_view key, auto&&...) { names_.push_back(key); }
  void choice(std::string_view key, auto&&...) { names_.push_back(key); }
  void table(std::string_view key, auto&&...) { names_.push_back(key); }
  void tables(std::string_view key, auto&&...) { names_.push_back(key); }
  void volts_file(std::string_view key, auto&&...) { names_.push_back(key); }

 private:
  std::vector<std::string_view> names_;
};

}  // namespace

void read_excitation(Section& section, ident::Excitation& excitation, Document& document) {
  std::vector<std::pair<std::string_view, ident::ExcitationKind>> choices;
  for (ident::ExcitationKind& kind : ident::all_excitation_kinds()) {
    const std::string_view name = ident::name_of(kind);
    choices.emplace_back(name, std::move(kind));
  }
  section.choice("kind", excitation.kind, choices);
  section.number("offset_V", excitation.offset_V, Range::any(), Need::optional);
  const bool is_known = section.has("kind") && document.issues.clean(section.path("kind"));
  if (is_known) std::visit([&](auto& options) { options.visit_keys(options, section); }, excitation.kind);
  const KeyNames own(excitation.kind);
  std::vector<std::string_view> seen;
  for (const auto& [name, kind] : choices) {
    const KeyNames keys(kind);
    for (const std::string_view key : keys.names()) {
      if (!is_known) {
        section.ignore(key);
      } else if (!own.contains(key) && std::find(seen.begin(), seen.end(), key) == seen.end()) {
        section.forbid(key, fmt::format("kind = \"{}\"", ident::name_of(excitation.kind)));
        seen.push_back(key);
      }
    }
  }
  if (is_known) section.add_issues(ident::issues_of(excitation));
}

}  // namespace eha::config
