// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/record/raw_hdf5.hpp"

#include <array>
#include <cstddef>
#include <cstring>
#include <string>
#include <string_view>

#include "core/error.hpp"
#include "core/json_text.hpp"
#include "core/os/files.hpp"
#include "daemon/acquisition/histogram.hpp"
#include "daemon/record/hdf5_handle.hpp"

namespace eha::record {
namespace {

using acquisition::TickRecord;

constexpr const char* kFormat = "eha-raw/1";

/// One member of TickRecord as a dataset.
struct Column {
  const char* name;
  const char* unit;
  const char* description;
  std::size_t offset;
  std::size_t size;
  hid_t type;
};

std::vector<Column> columns() {
  const auto column = [](const char* name, const char* unit, const char* description, std::size_t offset,
                         std::size_t size, hid_t type) { return Column{name, unit, description, offset, size, type}; };
#define EHA_COLUMN(member, unit, type, description) \
  column(#member, unit, description, offsetof(TickRecord, member), sizeof(TickRecord::member), type)
  return {
      EHA_COLUMN(scheduled_ns, "ns", H5T_STD_I64LE, "when the tick was due, from the run's first tick"),
      EHA_COLUMN(sequence, "", H5T_STD_U32LE, "tick number"),
      EHA_COLUMN(lateness_ns, "ns", H5T_STD_I32LE, "wake-up after the scheduled time"),
      EHA_COLUMN(execution_ns, "ns", H5T_STD_U32LE, "duration of the tick's work"),
      EHA_COLUMN(feedback_code, "", H5T_STD_U32LE, "raw code of the displacement converter"),
      EHA_COLUMN(command_code, "", H5T_STD_U32LE, "raw code on the output"),
      EHA_COLUMN(digital_inputs, "", H5T_STD_U32LE, "raw digital input word"),
      EHA_COLUMN(flags, "", H5T_STD_U16LE,
                 "1 late, 2 skipped, 4 clamped, 8 slew limited, 16 feedback held, 32 command held, 64 rail, 128 "
                 "emergency stop, 256 lost from a damaged journal, 512 over 80 % of the way to a travel limit, 1024 "
                 "over 80 % of the velocity limit"),
      EHA_COLUMN(state, "", H5T_STD_U8LE,
                 "0 faulted, 1 idle, 2 armed, 3 ramp in, 4 running (the experiment), 5 ramp out, 6 safe stop"),
      EHA_COLUMN(fault, "", H5T_STD_U8LE, "first fault of the run so far, 0 none"),
      EHA_COLUMN(repetition, "", H5T_STD_U16LE, "1-based while running, otherwise 0"),
      EHA_COLUMN(read_status, "", H5T_STD_U8LE,
                 "0 ok, 1 timed out, 2 I/O error, 3 busy, 4 locked, 5 removed, 6 not finite"),
      EHA_COLUMN(command_status, "", H5T_STD_U8LE, "as read_status"),
      EHA_COLUMN(requested_V, "V", H5T_IEEE_F64LE, "voltage asked for"),
      EHA_COLUMN(applied_V, "V", H5T_IEEE_F64LE, "voltage on the output until the next tick"),
      EHA_COLUMN(displacement_in, "in", H5T_IEEE_F64LE, "rod position sampled just before the voltage was applied"),
  };
#undef EHA_COLUMN
}

[[noreturn]] void throw_write_error() { throw IoError("the HDF5 library failed"); }

Hdf5Properties untimed(hid_t list_class) {
  Hdf5Properties properties(H5Pcreate(list_class));
  H5Pset_obj_track_times(properties.get(), false);
  return properties;
}

/// Writes one HDF5 file; every member throws IoError on failure.
class Writer {
 public:
  explicit Writer(const std::filesystem::path& path)
      : file_(H5Fcreate(path.c_str(), H5F_ACC_TRUNC, untimed(H5P_FILE_CREATE).get(), H5P_DEFAULT)) {
    if (!file_) throw_write_error();
  }

  void write_text(const char* name, std::string_view text) {
    const Hdf5Type type = text_type(text.size());
    const Hdf5Space space(H5Screate(H5S_SCALAR));
    const Hdf5Dataset dataset(H5Dcreate2(file_.get(), name, type.get(), space.get(), H5P_DEFAULT,
                                         untimed(H5P_DATASET_CREATE).get(), H5P_DEFAULT));
    require(dataset && H5Dwrite(dataset.get(), type.get(), H5S_ALL, H5S_ALL, H5P_DEFAULT, text.data()) >= 0);
  }

  void describe(hid_t object, const char* name, std::string_view text) {
    const Hdf5Type type = text_type(text.size());
    const Hdf5Space space(H5Screate(H5S_SCALAR));
    const Hdf5Attribute attribute(H5Acreate2(object, name, type.get(), space.get(), H5P_DEFAULT, H5P_DEFAULT));
    // An empty text is stored as one NUL: HDF5 has no strings of length 0.
    const std::string stored = text.empty() ? std::string(1, '\0') : std::string(text);
    require(attribute && H5Awrite(attribute.get(), type.get(), stored.data()) >= 0);
  }

  Hdf5Dataset create(const char* name, hid_t type, std::uint64_t rows, const char* unit, const char* description) {
    const hsize_t size = rows;
    const Hdf5Space space(H5Screate_simple(1, &size, nullptr));
    Hdf5Dataset dataset(
        H5Dcreate2(file_.get(), name, type, space.get(), H5P_DEFAULT, untimed(H5P_DATASET_CREATE).get(), H5P_DEFAULT));
    require(static_cast<bool>(dataset));
    describe(dataset.get(), "unit", unit);
    describe(dataset.get(), "description", description);
    return dataset;
  }

  void write_rows(const Hdf5Dataset& dataset, hid_t type, std::uint64_t first, std::uint64_t count, const void* data) {
    const hsize_t start = first;
    const hsize_t size = count;
    const Hdf5Space file_space(H5Dget_space(dataset.get()));
    const Hdf5Space memory_space(H5Screate_simple(1, &size, nullptr));
    require(H5Sselect_hyperslab(file_space.get(), H5S_SELECT_SET, &start, nullptr, &size, nullptr) >= 0 &&
            H5Dwrite(dataset.get(), type, memory_space.get(), file_space.get(), H5P_DEFAULT, data) >= 0);
  }

  [[nodiscard]] hid_t file() const { return file_.get(); }
  void close() { require(file_.close()); }

 private:
  static Hdf5Type text_type(std::size_t size) {
    Hdf5Type type(H5Tcopy(H5T_C_S1));
    H5Tset_size(type.get(), size == 0 ? 1 : size);
    H5Tset_strpad(type.get(), H5T_STR_NULLPAD);
    return type;
  }

  static void require(bool condition) {
    if (!condition) throw_write_error();
  }

  Hdf5File file_;
};

void write_histogram(Writer& writer, const char* name, const char* description,
                     const acquisition::Histogram& histogram) {
  const auto& buckets = histogram.buckets();
  const Hdf5Dataset dataset = writer.create(name, H5T_STD_U32LE, buckets.size(), "1", description);
  writer.write_rows(dataset, H5T_STD_U32LE, 0, buckets.size(), buckets.data());
}

/// The lateness of a tick that ran. After skipped ticks it counts from the first of them.
/// @param next_sequence  of the tick due after the last one that ran
std::int64_t lateness_ns(const TickRecord& tick, std::uint32_t next_sequence) {
  if (tick.sequence <= next_sequence) return tick.lateness_ns;
  const std::int64_t period_ns = tick.scheduled_ns / tick.sequence;
  return tick.lateness_ns + period_ns * (tick.sequence - next_sequence);
}

void write_content(Writer& writer, const std::string& header, std::uint64_t rows, std::int64_t zero_ns,
                   const RecordSource& source) {
  const std::vector<Column> all = columns();
  writer.describe(writer.file(), "format", kFormat);
  writer.write_text("header", header);
  std::vector<Hdf5Dataset> datasets;
  const Hdf5Dataset time =
      writer.create("time_s", H5T_IEEE_F64LE, rows, "s", "scheduled time from the first row of the experiment");
  for (const Column& column : all) {
    datasets.push_back(writer.create(column.name, column.type, rows, column.unit, column.description));
  }
  acquisition::Histogram latency;
  acquisition::Histogram execution;
  std::uint32_t next_sequence = 0;  // after the last tick that ran
  std::uint64_t written = 0;
  std::vector<double> times_s;
  std::vector<std::byte> values;
  source([&](std::span<const TickRecord> records) {
    times_s.resize(records.size());
    for (std::size_t i = 0; i < records.size(); ++i) {
      times_s[i] = (static_cast<double>(records[i].scheduled_ns) - static_cast<double>(zero_ns)) / 1e9;
      if ((records[i].flags & acquisition::kLost) != 0) next_sequence = records[i].sequence + 1;
      if ((records[i].flags & (acquisition::kSkipped | acquisition::kLost)) != 0) continue;
      latency.add(lateness_ns(records[i], next_sequence), records[i].scheduled_ns);
      next_sequence = records[i].sequence + 1;
      execution.add(records[i].execution_ns, records[i].scheduled_ns);
    }
    writer.write_rows(time, H5T_IEEE_F64LE, written, records.size(), times_s.data());
    for (std::size_t c = 0; c < all.size(); ++c) {
      values.resize(records.size() * all[c].size);
      for (std::size_t i = 0; i < records.size(); ++i) {
        std::memcpy(values.data() + i * all[c].size, reinterpret_cast<const std::byte*>(&records[i]) + all[c].offset,
                    all[c].size);
      }
      writer.write_rows(datasets[c], all[c].type, written, records.size(), values.data());
    }
    written += records.size();
  });
  write_histogram(writer, "latency_histogram", "ticks by wake-up lateness, 1 us a bucket, the last holds the rest",
                  latency);
  write_histogram(writer, "execution_histogram",
                  "ticks by duration of their work, 1 us a bucket, the last holds the rest", execution);
}

std::string read_text(hid_t file, const char* name, const std::string& damaged) {
  const Hdf5Dataset dataset(H5Dopen2(file, name, H5P_DEFAULT));
  if (!dataset) throw DataError(damaged);
  const Hdf5Type type(H5Dget_type(dataset.get()));
  const Hdf5Space space(H5Dget_space(dataset.get()));
  if (!type || H5Tget_class(type.get()) != H5T_STRING || H5Tis_variable_str(type.get()) != 0 ||
      H5Sget_simple_extent_npoints(space.get()) != 1) {
    throw DataError(damaged);
  }
  if (is_elsewhere(dataset.get()) || H5Dget_storage_size(dataset.get()) < H5Tget_size(type.get())) {
    throw DataError(damaged);
  }
  std::string text(H5Tget_size(type.get()), '\0');
  if (H5Dread(dataset.get(), type.get(), H5S_ALL, H5S_ALL, H5P_DEFAULT, text.data()) < 0) throw DataError(damaged);
  return text;
}

}  // namespace

void write_raw_hdf5(const std::filesystem::path& path, const std::string& header, std::uint64_t rows,
                    std::int64_t zero_ns, const RecordSource& source) {
  const QuietHdf5 quiet;
  Writer writer(path);
  write_content(writer, header, rows, zero_ns, source);
  writer.close();
}

RawFile read_raw_file(const std::filesystem::path& path, const std::string& name) {
  // Opened once before HDF5, which does not report the system's error.
  static_cast<void>(os::open_regular_file(path));
  const QuietHdf5 quiet;
  const std::string damaged = (name.empty() ? path.string() : name) + ": not the raw record of a run, or damaged";
  const Hdf5File file(H5Fopen(path.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT));
  if (!file) throw DataError(damaged);
  RawFile raw;
  raw.header = parse_json_text<nlohmann::ordered_json>(read_text(file.get(), "header", damaged));
  if (!raw.header.is_object()) throw DataError(damaged);
  std::vector<std::byte> values;
  bool is_first = true;
  for (const Column& column : columns()) {
    const Hdf5Dataset dataset(H5Dopen2(file.get(), column.name, H5P_DEFAULT));
    if (!dataset) throw DataError(damaged + " (no " + column.name + ")");
    const Hdf5Space space(H5Dget_space(dataset.get()));
    const hssize_t points = H5Sget_simple_extent_npoints(space.get());
    if (H5Sget_simple_extent_ndims(space.get()) != 1 || points < 0) throw DataError(damaged);
    const auto rows = static_cast<std::size_t>(points);
    // A run from elsewhere must not include the content of another file, nor wait for a pipe.
    if (is_elsewhere(dataset.get())) throw DataError(damaged + " (" + column.name + " is in another file)");
    // A damaged length in a small file must not cause a huge allocation.
    if (rows > 0 && H5Dget_storage_size(dataset.get()) < rows) throw DataError(damaged);
    if (is_first) raw.records.resize(rows);
    is_first = false;
    if (rows != raw.records.size()) throw DataError(damaged + " (" + column.name + " has another length)");
    values.resize(rows * column.size);
    if (H5Dread(dataset.get(), column.type, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data()) < 0) throw DataError(damaged);
    for (std::size_t i = 0; i < rows; ++i) {
      std::memcpy(reinterpret_cast<std::byte*>(&raw.records[i]) + column.offset, values.data() + i * column.size,
                  column.size);
    }
  }
  return raw;
}

}  // namespace eha::record
