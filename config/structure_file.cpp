// SPDX-License-Identifier: GPL-3.0-or-later
#include "config/structure_file.hpp"

#include "config/file_kind.hpp"
#include "config/model_config.hpp"

namespace eha::config {

ident::StructureOptions parse_structure(std::string_view text, const std::string& file_name) {
  Document document = parse_document(text, file_name);
  Section root = Section::root(document);
  ident::StructureOptions asked = read_single_model(root, document);
  document.issues.throw_if_any();
  check_model(asked, "", document);
  document.issues.throw_if_any();
  return asked;
}

ident::StructureOptions load_structure(const std::string& path) {
  return parse_structure(read_config_file(path), path);
}

}  // namespace eha::config
