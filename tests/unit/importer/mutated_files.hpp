// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/time.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <csignal>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <iostream>
#include <iterator>
#include <new>
#include <random>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "core/error.hpp"
#include "daemon/importer/foreign_reader.hpp"
#include "daemon/importer/import.hpp"
#include "daemon/record/confined_reader.hpp"
#include "daemon/record/raw_hdf5.hpp"
#include "tests/unit/importer/damaged_fixtures.hpp"
#include "tests/unit/temporary_folder.hpp"

// MAT-files, HDF5, text and raw records of runs with bytes changed at random: a record, arrays or a refusal within the
// limits, nothing else. A child process reads thousands of them; what ends it, takes long or much memory is read again
// as a user's file is: text by the importer in a process of its own, the others by eha-reader.

namespace eha::importer::foreign {

constexpr std::int64_t kMuch_KiB = 64 * 1024;
constexpr rlim_t kHeadroom = rlim_t{192} << 20U;  // what eha-reader has beside its program for a small file
constexpr std::int64_t kMost_KiB = 1024 * 1024;
constexpr double kMost_s = 20.0;
constexpr int kFilesOfAChild = 2000;  // the libraries leak where they refuse a file

inline std::string mutated(std::string bytes, bool is_text, std::mt19937_64& generator) {
  constexpr std::uint64_t kSizes[] = {
      0, 1, 2, 0x7f, 0xff, 0x7fff, 0xffff, 0x7fffffff, 0x80000000, 0xffffffff, 0x7fffffffffffffff, 0xffffffffffffffff};
  constexpr std::string_view kWords[] = {"nan",      "-inf", "1e308",    "1e-400", "9999999999999999999999",
                                         ",",        ";",    "\t",       "\"",     "\n",
                                         "\r\n",     "#",    "10:00:00", "0x1",    "--",
                                         "\xFF\xFE", "time", "unit",     "1e9",    "\xC3\xA4"};
  const std::size_t changes = 1 + generator() % 4;
  for (std::size_t i = 0; i < changes && bytes.size() > 16; ++i) {
    const std::size_t at = generator() % (bytes.size() - 8);
    switch (generator() % (is_text ? 8 : 6)) {
      case 0:
        bytes[at] = static_cast<char>(bytes[at] ^ (1 << generator() % 8));
        break;
      case 1:
        bytes[at] = static_cast<char>(generator() % 256);
        break;
      case 2:
      case 3: {
        const std::uint64_t size = kSizes[generator() % std::size(kSizes)];
        std::memcpy(&bytes[at], &size, generator() % 2 == 0 ? 4 : 8);
        break;
      }
      case 4:
        bytes.resize(at + 8);
        break;
      case 5:
        bytes.insert(at, bytes.substr(generator() % bytes.size(), 1 + generator() % 64));
        break;
      case 6:
        bytes.insert(at, kWords[generator() % std::size(kWords)]);
        break;
      default:
        bytes.replace(at, generator() % 8, kWords[generator() % std::size(kWords)]);
    }
  }
  return bytes;
}

/// A file of a campaign, from its number alone.
class DamagedFiles {
 public:
  DamagedFiles(const std::string& kind, std::uint64_t seed) : seed_(seed) {
    for (Fixture& fixture : fixtures_to_damage()) {
      if (fixture.kind == kind) sound_.push_back(std::move(fixture));
    }
  }
  [[nodiscard]] const std::string& name(std::uint64_t i) const { return sound_[i % sound_.size()].name; }
  [[nodiscard]] std::string content(std::uint64_t i) const {
    std::mt19937_64 generator(seed_ * 1'000'003 + i);
    const Fixture& fixture = sound_[i % sound_.size()];
    return mutated(fixture.content, fixture.kind == "csv", generator);
  }

 private:
  std::uint64_t seed_;
  std::vector<Fixture> sound_;
};

struct Tally {
  std::int64_t at = 0;
  std::int64_t read = 0;
  std::int64_t refused = 0;
  std::int64_t odd_count = 0;
  std::array<std::int64_t, 100'000> odd{};  ///< files to read again
};

inline std::int64_t peak_KiB() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return usage.ru_maxrss;
}

/// What a process and those that it waited for have used.
struct Used {
  double processor_s = 0.0;
  std::int64_t peak_KiB = 0;
  int crashes = 0;  ///< of eha-reader

  void take(const rusage& usage) {
    const auto seconds = [](const timeval& time) {
      return static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_usec);
    };
    processor_s = std::max(processor_s, seconds(usage.ru_utime) + seconds(usage.ru_stime));
    peak_KiB = std::max<std::int64_t>(peak_KiB, usage.ru_maxrss);
  }
};

inline void limit_addresses(rlim_t most) {
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
  const rlimit limits{most, most};
  require(setrlimit(RLIMIT_AS, &limits) == 0);
#else
  static_cast<void>(most);
#endif
}

/// @returns whether it was read; a refusal is false
inline bool read_here(const std::string& kind, const std::filesystem::path& path) {
  try {
    if (kind == "csv") {
      static_cast<void>(import_record(path, {}));
      return true;
    }
    if (kind == record::kRawRows) static_cast<void>(record::read_raw_file(path));
    for (const ForeignReader& reader : kForeignReaders) {
      if (reader.kind == kind) static_cast<void>(reader.read(path, "damaged"));
    }
    return true;
  } catch (const DataError&) {
    return false;
  }
}

/// The child: reads files until the last, or until one of them is odd. @returns never
[[noreturn]] inline void read_files(const DamagedFiles& files, const std::string& kind,
                                    const std::filesystem::path& path, std::int64_t end, Tally& tally) {
  std::int64_t pages = 0;
  std::ifstream("/proc/self/statm") >> pages;
  limit_addresses(static_cast<rlim_t>(pages) * static_cast<rlim_t>(sysconf(_SC_PAGESIZE)) + kHeadroom);
  const rlimit no_core{0, 0};
  setrlimit(RLIMIT_CORE, &no_core);
  // With a name: HDF5 opens no file in memory that has none.
  const os::FileDescriptor file = os::open_file(path, O_RDWR | O_CREAT | O_TRUNC, 0600);
  const std::int64_t before_KiB = peak_KiB();
  for (; tally.at < end; ++tally.at) {
    const std::string content = files.content(static_cast<std::uint64_t>(tally.at));
    if (ftruncate(file.get(), 0) != 0 || pwrite(file.get(), content.data(), content.size(), 0) < 0) _exit(2);
    itimerval second{{0, 0}, {1, 0}};
    setitimer(ITIMER_PROF, &second, nullptr);  // SIGPROF ends the process
    bool is_odd = false;
    try {
      ++(read_here(kind, path) ? tally.read : tally.refused);
    } catch (const IoError&) {
      is_odd = kind != "csv";  // no text: eha-reader's
      if (!is_odd) ++tally.refused;
    } catch (const std::exception&) {
      is_odd = true;
    }
    if (is_odd || peak_KiB() > before_KiB + kMuch_KiB) _exit(1);
  }
  _exit(0);
}

/// Reads a file as a user's is read. @returns how that ended, empty when well
inline std::string read_again(const std::string& kind, const std::filesystem::path& path, Used& most) {
  const pid_t child = fork();
  require(child >= 0);
  if (child == 0) {
    const rlimit time{static_cast<rlim_t>(kMost_s), static_cast<rlim_t>(kMost_s)};
    setrlimit(RLIMIT_CPU, &time);
    limit_addresses(static_cast<rlim_t>(kMost_KiB) * 1024);
    try {
      if (kind == "csv") _exit(read_here(kind, path) ? 0 : 1);
      if (kind == record::kRawRows) {
        static_cast<void>(record::read_raw_rows(path));
      } else {
        static_cast<void>(read_foreign(kind, path));
      }
      _exit(0);
    } catch (const DataError& error) {
      // A fault of the library ended eha-reader, which is confined for that.
      _exit(std::string_view(error.what()).find("(signal ") == std::string_view::npos ? 1 : 3);
    } catch (const std::exception&) {
      _exit(2);
    }
  }
  int status = 0;
  rusage usage{};
  require(wait4(child, &status, 0, &usage) == child);
  most.take(usage);
  if (WIFSIGNALED(status)) return "signal " + std::to_string(WTERMSIG(status));
  if (WEXITSTATUS(status) == 2) return "an error that is no refusal";
  most.crashes += WEXITSTATUS(status) == 3 ? 1 : 0;
  return "";
}

inline void read_mutated(const std::string& kind, std::int64_t count, std::uint64_t seed) {
  const DamagedFiles files(kind, seed);
  const test::TemporaryFolder folder;
  void* shared = mmap(nullptr, sizeof(Tally), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
  ASSERT_NE(shared, MAP_FAILED);
  Tally& tally = *new (shared) Tally;
  while (tally.at < count) {
    const std::int64_t end = std::min(count, tally.at + kFilesOfAChild);
    const pid_t child = fork();
    ASSERT_GE(child, 0);
    if (child == 0) read_files(files, kind, folder.path() / "damaged", end, tally);
    int status = 0;
    ASSERT_EQ(waitpid(child, &status, 0), child);
    if (WIFEXITED(status) && WEXITSTATUS(status) == 0) continue;
    ASSERT_LT(tally.odd_count, static_cast<std::int64_t>(tally.odd.size()));
    tally.odd[static_cast<std::size_t>(tally.odd_count++)] = tally.at++;
  }
  int bad = 0;
  Used most;
  for (std::int64_t k = 0; k < tally.odd_count; ++k) {
    const auto i = static_cast<std::uint64_t>(tally.odd[static_cast<std::size_t>(k)]);
    const auto path = folder.write(files.name(i), files.content(i));
    const std::string end = read_again(kind, path, most);
    if (end.empty()) continue;
    ++bad;
    ADD_FAILURE() << kind << " of seed " << seed << ", file " << i << " (" << files.name(i) << "): " << end;
    if (const char* kept = std::getenv("EHA_KEEP")) {
      std::filesystem::copy_file(path, std::filesystem::path(kept) / (kind + std::to_string(i)),
                                 std::filesystem::copy_options::overwrite_existing);
    }
  }
  EXPECT_LE(most.processor_s, kMost_s + 1.0);
  EXPECT_LE(most.peak_KiB, kMost_KiB);
  std::cout << kind << ": " << count << " files, " << tally.read << " read, " << tally.refused << " refused, "
            << tally.odd_count << " odd and read again: " << bad << " of them badly, " << most.crashes
            << " ended eha-reader, with at most " << most.processor_s << " s and " << most.peak_KiB / 1024 << " MiB\n";
  munmap(shared, sizeof(Tally));
}

}  // namespace eha::importer::foreign
