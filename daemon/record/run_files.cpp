// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/record/run_files.hpp"

#include <fmt/format.h>

#include <cmath>
#include <cstdint>
#include <optional>
#include <span>

#include "core/error.hpp"
#include "core/os/files.hpp"
#include "daemon/record/experiment_rows.hpp"
#include "daemon/record/raw_file.hpp"
#include "daemon/record/run_folder.hpp"

namespace eha::record {
namespace {

using acquisition::TickRecord;

constexpr std::int64_t kNanosecondsPerSecond = 1'000'000'000;
constexpr std::size_t kBufferedText = 1u << 16;

/// How the record is thinned out, from the journal's header.
struct Decimation {
  std::int64_t period_ns = 0;
  std::size_t every = 1;
  std::size_t first_row = 0;
};

Decimation decimation_of(const nlohmann::ordered_json& header, const std::filesystem::path& path) {
  try {
    Decimation decimation;
    const auto& record = header.at("experiment").at("record");
    const double period_s = header.at("sample_period_s").get<double>();
    decimation.period_ns = std::llround(period_s * 1e9);
    decimation.every = record.at("decimation").get<std::size_t>();
    // From the ninth decimal of a row on, the quotient is rounding, not time.
    decimation.first_row = static_cast<std::size_t>(std::ceil(record.at("discard_s").get<double>() / period_s - 1e-9));
    if (decimation.every == 0 || decimation.period_ns <= 0) throw DataError("not positive");
    return decimation;
  } catch (const std::exception& error) {
    throw DataError(path.string() + ": the header does not say how to decimate: " + error.what());
  }
}

void write_decimated(const std::filesystem::path& folder, const Decimation& decimation,
                     const std::filesystem::path& journal) {
  const std::int64_t spacing_ns = decimation.period_ns * static_cast<std::int64_t>(decimation.every);
  os::AtomicFile file(folder / decimated_file_name(static_cast<double>(spacing_ns) * 1e-9));
  std::string text = "time_s,voltage_V,displacement_in\n";
  ExperimentRows rows([&](std::size_t row, double voltage_V, double displacement_in) {
    if (row < decimation.first_row || row % decimation.every != 0) return;
    text += seconds_text(static_cast<std::int64_t>(row) * decimation.period_ns);
    fmt::format_to(std::back_inserter(text), ",{},{}\n", voltage_V, displacement_in);
    if (text.size() < kBufferedText) return;
    file.write(text);
    text.clear();
  });
  read_journal(journal, [&](std::span<const TickRecord> ticks) { rows.add(ticks); });
  rows.finish();
  file.write(text);
  file.commit();
}

}  // namespace

std::string decimated_file_name(double spacing_s) {
  return fmt::format("data_{}ms.csv", std::round(spacing_s * 1e9) / 1e6);
}

std::string seconds_text(std::int64_t time_ns) {
  std::string text = fmt::format("{}.{:09}", time_ns / kNanosecondsPerSecond, time_ns % kNanosecondsPerSecond);
  text.erase(text.find_last_not_of('0') + 1);
  if (text.back() == '.') text.pop_back();
  return text;
}

JournalFacts write_files_from_journal(const std::filesystem::path& folder) {
  const std::filesystem::path journal = folder / kJournalFile;
  std::optional<std::int64_t> zero_ns;
  const JournalFacts facts = read_journal(journal, [&](std::span<const TickRecord> ticks) {
    for (const TickRecord& tick : ticks) {
      if (zero_ns) break;
      if (tick.state == acquisition::State::running) zero_ns = tick.scheduled_ns;
    }
  });
  write_raw_file(folder / kRawFile, facts.header, facts.rows, zero_ns.value_or(0),
                 [&](const auto& consume) { read_journal(journal, consume); });
  write_decimated(folder, decimation_of(facts.header, journal), journal);
  return facts;
}

}  // namespace eha::record
