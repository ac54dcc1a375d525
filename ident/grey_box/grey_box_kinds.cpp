// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>

#include "ident/grey_box/grey_box_kind.hpp"

namespace eha::ident {

std::span<const GreyBoxKind* const> grey_box_kinds() {
  static const std::array kKinds{&friction_kind(), &outflow_kind(), &overflow_kind()};
  return kKinds;
}

std::size_t index_of(const GreyBoxKind& kind, std::string_view parameter) {
  const auto at = std::find_if(kind.parameters.begin(), kind.parameters.end(),
                               [&](const GreyBoxParameter& p) { return p.name == parameter; });
  return static_cast<std::size_t>(at - kind.parameters.begin());
}

}  // namespace eha::ident
