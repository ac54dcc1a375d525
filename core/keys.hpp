// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cmath>
#include <cstddef>
#include <limits>

namespace eha {

/// Whether a key is required.
enum class Need { required, optional };

/// Allowed values of a number. An infinite bound does not limit it; the number itself must be finite.
struct Range {
  double low = -std::numeric_limits<double>::infinity();
  double high = std::numeric_limits<double>::infinity();
  bool low_excluded = false;
  bool high_excluded = false;

  [[nodiscard]] bool contains(double value) const {
    if (!std::isfinite(value)) return false;
    return (low_excluded ? value > low : value >= low) && (high_excluded ? value < high : value <= high);
  }

  static Range any() { return {}; }
  static Range above(double low) { return {.low = low, .low_excluded = true}; }
  static Range at_least(double low) { return {.low = low}; }
  static Range between(double low, double high) { return {.low = low, .high = high}; }
};

// A struct (of a backend, an excitation, a table of a rig file) lists the keys of its configuration table once:
//
//   struct Table {
//     static void visit_keys(auto& self, auto& keys) {
//       keys.number("amplitude_V", self.amplitude_V, Range::above(0.0));
//       keys.integer("seed", self.seed, 0, kAnySeed, Need::optional);
//     }
//   };
//
// `self` is the struct, const if it is only read. `keys` is a visitor that reads, writes or counts the keys: the reader
// of a configuration file, the writer of a run's manifest or of a TOML file. It has these members:
//
//   number(name, double&, Range, Need)          number(name, optional<double>&, Range)         of an optional key
//   integer(name, integer&, low, high, Need)    integer(name, optional<integer>&, low, high)   of an optional key
//   boolean(name, bool&, Need)                  boolean(name, optional<bool>&)                of an optional key
//   text(name, string&, Need)
//   choice(name, enum&, list of {name, value}, Need)
//   table(name, T&, Need)                       tables(name, vector<T>&)                       of a T with visit_keys
//   number_or_unknown(name, optional<double>&)
//   optional_table(name, optional<T>&)
//   table_or_none(name, optional<T>&)           volts_file(name, VoltsFile&)                   a CSV file of volts

}  // namespace eha
