// SPDX-License-Identifier: GPL-3.0-or-later
// eha-hdf5 KIND: writes what it receives on standard input to the file that is its descriptor 3 (file_writer.hpp). eha
// and ehad start it; users do not.
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <exception>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "core/error.hpp"
#include "core/os/child_process.hpp"
#include "daemon/record/column_files.hpp"
#include "daemon/record/file_writer.hpp"
#include "daemon/record/raw_hdf5.hpp"

namespace {

constexpr std::uint64_t kPiece = 4096;  // rows

using eha::acquisition::TickRecord;

void receive_all(void* bytes, std::size_t size) { eha::record::receive(STDIN_FILENO, bytes, size); }

std::uint64_t received_number() {
  std::uint64_t number = 0;
  receive_all(&number, sizeof number);
  return number;
}

std::string received_text() {
  std::string text(received_number(), '\0');
  receive_all(text.data(), text.size());
  return text;
}

void write_raw(const std::string& path) {
  const std::string header = received_text();
  const std::uint64_t rows = received_number();
  const auto zero_ns = static_cast<std::int64_t>(received_number());
  eha::record::write_raw_hdf5(path, header, rows, zero_ns, [rows](const auto& consume) {
    std::vector<TickRecord> piece;
    for (std::uint64_t left = rows; left > 0; left -= piece.size()) {
      piece.resize(std::min(left, kPiece));
      receive_all(piece.data(), piece.size() * sizeof(TickRecord));
      consume(piece);
    }
  });
}

void receive_columns(const std::function<void(eha::record::NamedColumn&)>& consume) {
  for (std::uint64_t left = received_number(); left > 0; --left) {
    eha::record::NamedColumn column;
    column.name = received_text();
    column.unit = received_text();
    column.values.resize(received_number());
    receive_all(column.values.data(), column.values.size() * sizeof(double));
    consume(column);
  }
}

}  // namespace

int main(int argc, char** argv) {
  const std::string_view kind = argc == 2 ? argv[1] : "";
  const std::string path = fmt::format("/proc/self/fd/{}", eha::os::kSharedDescriptor);
  try {
    if (kind == eha::record::kRawHdf5) {
      write_raw(path);
    } else if (kind == eha::record::kMatColumns) {
      eha::record::write_mat_columns(path, &receive_columns);
    } else if (kind == eha::record::kHdf5Columns) {
      eha::record::write_hdf5_columns(path, &receive_columns);
    } else {
      std::fputs("eha-hdf5: error: to be started by eha only; see eha export\n", stderr);
      return static_cast<int>(eha::ExitCode::usage);
    }
    return 0;
  } catch (const std::exception&) {
    // Who started it says what could not be written. HDF5 1.10 crashes in an orderly end after a write that failed.
    _exit(static_cast<int>(eha::ExitCode::io));
  }
}
