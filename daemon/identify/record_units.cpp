// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/identify/record_units.hpp"

#include <fmt/format.h>

#include <utility>

#include "core/display_unit.hpp"
#include "core/error.hpp"
#include "ident/validation/output_unit.hpp"

namespace eha::identify {
namespace {

bool agree(const std::string& a, const std::string& b) { return a.empty() || b.empty() || a == b; }

}  // namespace

ident::Model in_units_of(const Source& source, ident::Model model, const std::string& name) {
  const std::string& input = source.record.input_channel.unit;
  const std::string& output = source.record.output_channel.unit;
  const DisplayUnit unit(output);
  const bool is_convertible = unit.of(model.output_unit) == output;
  if (!agree(model.input_unit, input) || (!agree(model.output_unit, output) && !is_convertible)) {
    throw DataError(
        fmt::format("{} is a model from {} to {}, and {} is a record in {} and {}; expected the same units, "
                    "or outputs that are lengths",
                    name, model.input_unit, model.output_unit, source.name, input, output));
  }
  return agree(model.output_unit, output) ? model : in_unit(std::move(model), unit);
}

}  // namespace eha::identify
