// SPDX-License-Identifier: GPL-3.0-or-later
#include "eha_run.hpp"

#include <sys/stat.h>

#include <csignal>
#include <cstdlib>
#include <fstream>
#include <sstream>
#include <stdexcept>
#include <utility>

#include "config/measured_check.hpp"
#include "config/rig_config.hpp"
#include "core/error.hpp"
#include "daemon/record/run_folder.hpp"

namespace eha::test {
namespace {

namespace fs = std::filesystem;

fs::path new_folder() {
  std::string name = "/tmp/runs-XXXXXX";
  if (mkdtemp(name.data()) == nullptr) throw std::runtime_error(name);
  return name;
}

std::string write_file(const fs::path& path, const std::string& text) {
  std::ofstream file(path);
  file << text << std::flush;
  if (!file || chmod(path.c_str(), 0644) != 0) throw std::runtime_error(path.string());
  return path.string();
}

constexpr const char* kQuickTones = R"(tones = [
  { frequency_Hz = 0.5, amplitude_V = 1.0, phase_rad = 0.3 },
  { frequency_Hz = 1.0, amplitude_V = 0.6, phase_rad = 1.9 },
  { frequency_Hz = 2.5, amplitude_V = 0.4, phase_rad = 4.2 },
])";
constexpr const char* kFaintTones = R"(tones = [
  { frequency_Hz = 0.5, amplitude_V = 0.2, phase_rad = 0.3 },
  { frequency_Hz = 1.0, amplitude_V = 0.12, phase_rad = 1.9 },
  { frequency_Hz = 2.5, amplitude_V = 0.08, phase_rad = 4.2 },
])";
constexpr const char* kSlowTones = R"(tones = [
  { frequency_Hz = 0.25, amplitude_V = 2.0, phase_rad = 0.3 },
  { frequency_Hz = 0.5, amplitude_V = 1.0, phase_rad = 1.9 },
])";

/// Tones that are small enough for the shipped limits.
std::string experiment_text(std::chrono::milliseconds duration, Tones tones) {
  return "schema = 1\nname = \"vm\"\nduration_s = " + std::to_string(static_cast<double>(duration.count()) * 1e-3) +
         R"(
repetitions = 1
[excitation]
kind = "multisine"
offset_V = 0.0
)" +
         (tones == Tones::quick   ? kQuickTones
          : tones == Tones::faint ? kFaintTones
                                  : kSlowTones) +
         R"(
[record]
discard_s = 0.0
decimation = 10
split = 0.5
[identification]
procedure = "default"
seed = 1
[[model]]
name = "io"
structure = "io"
poles = 1
zeros = 0
[acceptance]
min_validation_r2_percent = 90.0
)" + (tones == Tones::held ? "[hold]\n" : "");
}

std::vector<std::string> local_words(std::vector<std::string> words, const fs::path& runs) {
  words.insert(words.begin(), "eha");
  words.insert(words.end(), {"--local", "--yes", "--output", runs.string()});
  return words;
}

std::string write_rig(const std::string& text) {
  static int number = 0;
  return write_file("/tmp/rig-" + std::to_string(number++) + ".toml", text);
}

/// Replaces the value of a key that stands at the beginning of a line.
void set_key(std::string& text, const std::string& key, const std::string& value) {
  const std::size_t at = text.find("\n" + key + " = ");
  if (at == std::string::npos) throw std::runtime_error("the shipped rig file has no " + key);
  const std::size_t begin = at + key.size() + 4;
  text.replace(begin, text.find_first_of(" \n", begin) - begin, value);
}

/// Adds the sums of a measurement of this rig to [following], so that a run begins with its experiment; see
/// config::shows_motion_first(). A file that is not to be read stays as it is.
std::string as_measured(std::string text) {
  try {
    const config::RigConfig rig = config::parse_rig(text, "rig.toml");
    const std::string table = "\n[following]\n";
    const std::size_t at = text.find(table);
    if (!rig.limits.following || at == std::string::npos) return text;
    text.insert(at + table.size(),
                "measured_check = " + std::to_string(config::measured_check_of(*rig.limits.following)) +
                    "\nmeasured_rig_check = " + std::to_string(config::measured_rig_check_of(rig.backend)) + "\n");
  } catch (const Error&) {
  }
  return text;
}

}  // namespace

std::string pci1716_rig_text() {
  std::ifstream shipped(kPci1716Rig);
  std::stringstream text;
  text << shipped.rdbuf();
  std::string rig = text.str();
  set_key(rig, "sample", "false");
  return rig;
}

std::string pci1716_rig() { return write_rig(pci1716_rig_text()); }

std::string patient_pci1716_rig(const std::string& appended,
                                const std::vector<std::pair<std::string, std::string>>& changes) {
  std::string rig = pci1716_rig_text() + appended;
  set_key(rig, "abort_consecutive_late", "500");
  set_key(rig, "abort_total_late", "5000");
  for (const auto& [key, value] : changes) set_key(rig, key, value);
  return write_rig(as_measured(std::move(rig)));
}

std::string kernel_board_rig(RigFile kind) {
  const std::string device = kind == RigFile::missing_device ? "/dev/comedi7" : "/dev/comedi0";
  const std::string board = kind == RigFile::wrong_board ? "pci1716" : "comedi_test";
  const std::string range_max_V = kind == RigFile::wrong_range ? "7.0" : "10.0";
  return write_rig(as_measured(R"(schema = 1
name = "kernel test board"
backend = "comedi"
[limits]
command_min_V = -5.0
command_max_V = 5.0
slew_V_per_s = 40.0
safe_V = 0.0
travel_min_in = 0.15
travel_max_in = 5.75
stopping_deceleration_in_per_s2 = 200.0
velocity_limit_in_per_s = 20.0
frozen_sensor_s = 0.5
# The board's input is its output: its position follows the voltage, which no rod does. Faint tones pass nevertheless.
[following]
gain_positive_in_per_V_s = 0.1
gain_negative_in_per_V_s = 0.1
null_V = 0.0
dead_band_V = 1.5
limit_in = 0.27
[realtime]
sample_period_s = 0.001
priority = 80
abort_consecutive_late = 500
abort_total_late = 5000
[comedi]
device = ")" + device +
                               R"("
board = ")" + board +
                               R"("
driver = "comedi_test"
resolution_bits = 16
feedback_settling_us = 10.0
scale_in_per_V = 0.295
offset_in = 2.95
calibration_date = "2026-01-01"
emergency_stop = "none"
enable = "none"
heartbeat = "none"
[comedi.feedback]
subdevice = 0
channel = 0
reference = "ground"
range_min_V = -10.0
range_max_V = 10.0
[comedi.command]
subdevice = 1
channel = 0
reference = "ground"
range_min_V = -10.0
range_max_V = )" + range_max_V +
                               "\n"));
}

EhaRun::EhaRun(const std::string& rig_file, std::chrono::milliseconds duration, Tones tones)
    : runs_(new_folder()),
      process_({"eha", "run", write_file("/tmp/experiment.toml", experiment_text(duration, tones)), "--local", "--rig",
                rig_file, "--yes", "--output", runs_.string()}) {}

EhaRun::EhaRun(std::vector<std::string> words) : runs_(new_folder()), process_(local_words(std::move(words), runs_)) {}

void EhaRun::wait_until_running() const {
  const auto running = [&] {
    if (left_nothing()) return false;
    // The journal grows block by block; two of them hold rows beyond the ramp.
    std::error_code none_yet;
    const auto bytes = fs::file_size(folder() / record::kJournalFile, none_yet);
    return !none_yet && bytes > 30'000;
  };
  if (!wait_until(running)) throw std::runtime_error("the run did not get going: " + process_.output());
}

void EhaRun::wait_until_recorded() {
  const auto recorded = [&] { return process_.output().find("recorded in ") != std::string::npos; };
  if (!wait_until(recorded)) throw std::runtime_error("the run did not end: " + process_.output());
  process_.signal(SIGKILL);
  process_.wait();
}

fs::path EhaRun::folder() const {
  std::vector<fs::path> folders;
  for (const auto& entry : fs::directory_iterator(runs_)) {
    if (entry.is_directory() && !entry.is_symlink()) folders.push_back(entry.path());
  }
  if (folders.size() != 1) {
    throw std::runtime_error(std::to_string(folders.size()) + " run folders: " + process_.output());
  }
  return folders.front();
}

bool EhaRun::left_nothing() const { return fs::is_empty(runs_); }

nlohmann::ordered_json EhaRun::manifest() const { return to_json(record::read_manifest(folder())); }

std::vector<acquisition::TickRecord> EhaRun::ticks() const { return record::read_ticks(folder()); }

}  // namespace eha::test
