// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/record/run_files.hpp"

#include <fmt/format.h>

#include <cmath>
#include <cstdint>
#include <optional>
#include <span>

#include "core/error.hpp"
#include "core/os/files.hpp"
#include "daemon/acquisition/clock.hpp"
#include "daemon/record/experiment_rows.hpp"
#include "daemon/record/manifest.hpp"
#include "daemon/record/raw_file.hpp"
#include "daemon/record/run_folder.hpp"
#include "daemon/record/run_header.hpp"
#include "ident/signal/decimation.hpp"

namespace eha::record {
namespace {

using acquisition::kNanosecondsPerSecond;
using acquisition::TickRecord;

constexpr std::size_t kBufferedText = 1u << 16;

/// Writes the rows that the experiment's decimation and discarded time keep.
/// @param gap_lines  comment lines on the gaps of the journal
void write_decimated(const std::filesystem::path& folder, const RunHeader& header, const std::filesystem::path& journal,
                     const std::string& gap_lines) {
  const std::int64_t period_ns = std::llround(header.sample_period_s * 1e9);
  const std::int64_t spacing_ns = period_ns * static_cast<std::int64_t>(header.decimation);
  const ident::KeptRows kept =
      ident::keep_every(header.decimation, ident::discarded_rows(header.discard_s, header.sample_period_s));
  os::AtomicFile file(folder / decimated_file_name(static_cast<double>(spacing_ns) * 1e-9));
  std::string text = gap_lines + "time_s,voltage_V,displacement_in\n";
  ExperimentRows rows(os::shown(journal), [&](std::size_t row, double voltage_V, double displacement_in) {
    if (!kept.keeps(row)) return;
    text += seconds_text(static_cast<std::int64_t>(row) * period_ns);
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

std::string describe_gaps(const JournalFacts& facts, std::int64_t zero_ns) {
  std::string lines;
  for (const JournalGap& gap : facts.gaps) {
    if (gap.rows == 0 || gap.at_ns < zero_ns) continue;
    lines += fmt::format("# {} ticks from {} s on were lost from a damaged journal and are interpolated\n", gap.rows,
                         seconds_text(gap.at_ns - zero_ns));
  }
  return lines;
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
  JournalFacts facts = read_journal(journal, [&](std::span<const TickRecord> ticks) {
    for (const TickRecord& tick : ticks) {
      if (zero_ns) break;
      if (tick.state == acquisition::State::running) zero_ns = tick.scheduled_ns;
    }
  });
  if (facts.header.is_null()) {
    try {
      facts.header = header_from_manifest(read_manifest(folder).other);
    } catch (const Error& error) {
      throw DataError(journal.string() + ": the header is damaged, and its copy cannot be read: " + error.what());
    }
  }
  write_raw_file(folder / kRawFile, facts.header, facts.rows, zero_ns.value_or(0),
                 [&](const auto& consume) { read_journal(journal, consume); });
  write_decimated(folder, read_run_header(facts.header, journal.string()), journal,
                  describe_gaps(facts, zero_ns.value_or(0)));
  return facts;
}

}  // namespace eha::record
