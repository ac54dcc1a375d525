// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <chrono>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "daemon/acquisition/tick_record.hpp"
#include "process.hpp"

namespace eha::test {

/// The rig file that is shipped for the real card.
inline constexpr const char* kPci1716Rig = "/usr/share/ehad/rigs/pci1716.toml";

/// That file as a rig's own, no sample: its text, and a file with it.
[[nodiscard]] std::string pci1716_rig_text();
[[nodiscard]] std::string pci1716_rig();

/// The same with room for late ticks. On the machine's one emulated processor, whatever else happens during a run makes
/// some: the end of the guard, which has locked memory and a higher priority, more than the shipped limits allow.
/// @param appended  further tables   @param changes  keys that begin a line, and their values
[[nodiscard]] std::string patient_pci1716_rig(const std::string& appended = {},
                                              const std::vector<std::pair<std::string, std::string>>& changes = {});

/// A rig file for the kernel's own test board, which has no digital lines of use. `wrong_board` and `wrong_range` make
/// it differ from the board.
enum class RigFile { right, wrong_board, wrong_range, missing_device };
[[nodiscard]] std::string kernel_board_rig(RigFile kind = RigFile::right);

/// Sum of sines that an experiment plays: `quick` never rests for the frozen-sensor time and hardly moves a rod, `slow`
/// moves it by some tenths of an inch, `held` are the slow ones with a hold.
enum class Tones { quick, faint, slow, held };

/// `eha run --local` on a card, its output in a folder of its own.
class EhaRun {
 public:
  EhaRun(const std::string& rig_file, std::chrono::milliseconds duration, Tones tones = Tones::quick);
  /// Another command that makes a run, as goto. @param words  of eha, without --local, --yes and --output
  explicit EhaRun(std::vector<std::string> words);

  Process& process() { return process_; }
  /// Blocks until the first row of the experiment itself was commanded.
  void wait_until_running() const;

  /// Blocks until the experiment is recorded and the rig safe; identification is cut short, which takes long in here.
  void wait_until_recorded();

  /// The one run folder. @throws std::runtime_error  none, or several
  [[nodiscard]] std::filesystem::path folder() const;
  [[nodiscard]] bool left_nothing() const;
  [[nodiscard]] nlohmann::ordered_json manifest() const;
  [[nodiscard]] std::vector<acquisition::TickRecord> ticks() const;

 private:
  std::filesystem::path runs_;
  Process process_;
};

}  // namespace eha::test
