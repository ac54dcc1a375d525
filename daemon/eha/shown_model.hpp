// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <utility>

#include "core/display_unit.hpp"
#include "ident/model/output_unit.hpp"

namespace eha::cli {

/// The model for people to read, its output in the unit.
[[nodiscard]] inline ident::Model in_unit(ident::Model model, const DisplayUnit& unit) {
  const std::string shown = unit.of(model.output_unit);
  if (shown == model.output_unit) return model;
  const double factor = unit.factor(model.output_unit);
  return ident::in_output_unit(std::move(model), shown, factor);
}

}  // namespace eha::cli
