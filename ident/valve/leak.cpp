// SPDX-License-Identifier: GPL-3.0-or-later
#include "ident/valve/leak.hpp"

#include <fmt/format.h>

#include <cmath>

#include "core/capitalised.hpp"

namespace eha::ident {

std::optional<Leak> leak_of(double creep_in_per_s, double gain_positive, double gain_negative) {
  const double gain = creep_in_per_s > 0.0 ? gain_positive : gain_negative;
  if (!(std::abs(creep_in_per_s) >= kWantedNull_V * gain)) return std::nullopt;
  return Leak{std::abs(creep_in_per_s), std::abs(creep_in_per_s) / gain};
}

std::optional<Leak> leak_of(const ValveSheet& sheet) {
  if (!sheet.creep_in_per_s) return std::nullopt;
  return leak_of(sheet.creep_in_per_s->value, sheet.gain_positive_in_per_V_s.value,
                 sheet.gain_negative_in_per_V_s.value);
}

namespace {

constexpr const char* kLeaks = "oil leaks past the piston or through the valve";

std::string creep_text(const Leak& leak, const DisplayUnit& unit) {
  return fmt::format("the rod creeps at {:.2g} {}/s within the dead band, as {:.2g} V of command would move it",
                     unit.factor("in") * leak.creep_in_per_s, unit.of("in"), leak.as_V);
}

}  // namespace

std::string leak_text(const Leak& leak, const DisplayUnit& unit) {
  return fmt::format("{}: {}", creep_text(leak, unit), kLeaks);
}

std::string leak_finding(const Leak& leak, const DisplayUnit& unit) {
  return fmt::format(
      "{}: by the valve sheet {}. That moves null, dead band and gains of the moving rod by more than their intervals, "
      "and another sheet, model or controller does not mend it: {}.",
      capitalised(kLeaks), creep_text(leak, unit), kRepairFirst);
}

}  // namespace eha::ident
