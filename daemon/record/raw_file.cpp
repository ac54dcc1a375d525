// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/record/raw_file.hpp"

#include <string>

#include "core/error.hpp"
#include "daemon/record/file_writer.hpp"

namespace eha::record {
namespace {

using acquisition::TickRecord;

/// An upper bound of the file's size.
std::uint64_t size_bound(const std::string& header, std::uint64_t rows) {
  constexpr std::uint64_t kOverhead = 1 << 20;  // datasets, attributes, histograms: measured 45 kB
  return rows * (sizeof(TickRecord) + sizeof(double)) + 2 * header.size() + kOverhead;
}

}  // namespace

void write_raw_file(const std::filesystem::path& path, const nlohmann::ordered_json& header, std::uint64_t rows,
                    std::int64_t zero_ns, const RecordSource& source) {
  const std::string text = header.dump(-1, ' ', true);
  FileWriter writer(kRawHdf5, path, size_bound(text, rows));
  writer.send_text(text);
  writer.send_number(rows);
  writer.send_number(static_cast<std::uint64_t>(zero_ns));
  std::uint64_t left = rows;
  source([&](std::span<const TickRecord> records) {
    if (records.size() > left) throw IoError("cannot write " + path.string() + ": more rows than announced");
    left -= records.size();
    writer.send(records.data(), records.size_bytes());
  });
  if (left > 0) throw IoError("cannot write " + path.string() + ": fewer rows than announced");
  writer.commit();
}

}  // namespace eha::record
