// SPDX-License-Identifier: GPL-3.0-or-later
// The reader of CSV records either refuses with DataError or returns an even, finite record. A file written from that
// record reads back as the same record.
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <string>

#include "core/error.hpp"
#include "daemon/importer/import.hpp"
#include "tests/fuzz/memory_file.hpp"
#include "tests/fuzz/require.hpp"

namespace {

using eha::fuzz::MemoryFile;
using eha::fuzz::require;
using eha::record::InputSeries;

bool same_bits(const double* a, const double* b, std::size_t count) {
  return std::memcmp(a, b, count * sizeof(double)) == 0;
}

void check_record(const MemoryFile& file) {
  try {
    const eha::ident::Record record = eha::importer::import_record(file.path(), {}).record;
    require(record.step_s > 0.0 && std::isfinite(record.step_s), "a record's step is a time");
    require(record.input.size() >= 2 && record.input.size() == record.output.size(), "columns have equal lengths");
    require(record.input.allFinite() && record.output.allFinite(), "a record's samples are finite");
  } catch (const eha::DataError& error) {
    eha::fuzz::require_good_message(error.what(), file.path().string());
  } catch (const eha::IoError&) {
    // No text: eha-reader would read it, which has targets of its own.
  }
}

void check_round_trip(const InputSeries& series) {
  const std::string text = eha::record::series_csv(series.time_s, series.channel, series.values);
  const MemoryFile file(reinterpret_cast<const std::uint8_t*>(text.data()), text.size());
  try {
    const InputSeries again = eha::importer::import_input(file.path(), {}, "").series;
    require(again.time_s.size() == series.time_s.size(), "a written series has its rows");
    require(same_bits(again.time_s.data(), series.time_s.data(), series.time_s.size()), "times read back to the bit");
    require(same_bits(again.values.data(), series.values.data(), series.time_s.size()), "values read back to the bit");
    require(again.channel.name == series.channel.name && again.channel.unit == series.channel.unit,
            "the channel reads back");
  } catch (const eha::DataError& error) {
    require(false, text.substr(0, 400) + "\na written series can be read: " + error.what());
  }
}

void check_series(const MemoryFile& file) {
  try {
    const InputSeries series = eha::importer::import_input(file.path(), {}, "").series;
    require(series.step_s > 0.0 && std::isfinite(series.step_s), "a series' step is a time");
    require(series.time_s.size() >= 2 && static_cast<std::size_t>(series.values.size()) == series.time_s.size(),
            "each time has its value");
    require(series.values.allFinite(), "a series' samples are finite");
    bool is_exact = true;
    for (std::size_t k = 0; k < series.time_s.size(); ++k) {
      const double off_s = std::abs(series.time_s[k] - series.time_s.front() - static_cast<double>(k) * series.step_s);
      require(off_s < series.step_s, "no row is a step off the grid");
      is_exact = is_exact && off_s < 1e-9 * series.step_s;
    }
    // 1, 2e1, 3e1 s is an even grid rounded to one digit; 1, 20, 30 s is none.
    if (is_exact) check_round_trip(series);
  } catch (const eha::DataError& error) {
    eha::fuzz::require_good_message(error.what(), file.path().string());
  } catch (const eha::IoError&) {
    // No text: eha-reader would read it, which has targets of its own.
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const MemoryFile file(data, size);
  check_record(file);
  check_series(file);
  return 0;
}
