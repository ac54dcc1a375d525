// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/doctor/card_checks.hpp"

#include <fmt/format.h>

#include "core/shell_word.hpp"
#include "hal/comedi/comedi_available.hpp"
#include "hal/comedi/comedi_rig.hpp"

namespace eha::doctor {
namespace {

// Advantech's PCI-1716, by the name of the out-of-tree driver.
constexpr const char* kBoard = "pci1716";
constexpr const char* kVendor = "13fe";
constexpr const char* kDevice = "1716";
constexpr const char* kOutOfTree =
    "build and install the drivers of https://github.com/Linux-Comedi/comedi (DKMS), then sudo modprobe adv_pci1710";

std::string mend_device(const hal::ComediOptions& options, const CardFinding& finding) {
  if (!hal::comedi_available) return "sudo apt-get install libcomedi-dev, then build anew";
  if (finding.code == ExitCode::permission) return "sudo usermod -aG iocard $USER && echo 'now log in again'";
  if (options.board == kBoard && finding.module == ModuleSupport::not_listed)
    return "first repair the driver, see below";
  return fmt::format("sudo modprobe {}; dmesg says what it found", shell_quoted(options.driver));
}

Check check_device(const hal::ComediOptions& options, const CardFinding& finding) {
  if (!finding.card) return fail("device", finding.error, mend_device(options, finding), finding.code);
  return ok("device", fmt::format("{} opens", options.device));
}

Check check_driver(const CardFinding& finding) {
  switch (finding.module) {
    case ModuleSupport::listed:
      return ok("driver", "adv_pci1710 lists the PCI-1716 (13fe:1716)");
    case ModuleSupport::not_listed:
      return fail("driver",
                  "the adv_pci1710 of this kernel does not list the PCI-1716 (13fe:1716); the out-of-tree one does",
                  kOutOfTree, ExitCode::device_unavailable);
    case ModuleSupport::unknown:
      break;
  }
  return warn("driver",
              "no modules.alias for this kernel, so it is unknown whether its adv_pci1710 lists the PCI-1716; Debian's "
              "own does not",
              "sudo depmod; else " + std::string(kOutOfTree));
}

Check check_board(const hal::ComediOptions& options, const hal::CardDescription& card) {
  try {
    static_cast<void>(hal::match(options, card));
  } catch (const DeviceError& error) {
    return fail(
        "board", fmt::format("{}\nthe card: {} by {}\n{}", error.what(), card.board, card.driver, to_lines(card)),
        "describe this card in the rig file, or insert the card that the file describes", ExitCode::device_unavailable);
  }
  return ok("board",
            fmt::format("{} by {}, channels, ranges and resolution as the rig file says", card.board, card.driver));
}

Check check_line(const char* name, const char* without, const char* what, const std::optional<hal::DigitalLine>& line) {
  if (!line) {
    return warn(name, fmt::format("none, as the rig file says: {}", without),
                fmt::format("wire {} and describe it in [comedi.{}], see eha-rig(5)", what, name));
  }
  return ok(name, fmt::format("subdevice {}, channel {}, active {}", line->subdevice, line->channel,
                              line->active == hal::ActiveLevel::high ? "high" : "low"));
}

}  // namespace

CardFinding find_card(const hal::ComediOptions& options, const std::filesystem::path& root,
                      const std::string& release) {
  CardFinding finding;
  try {
    finding.card = hal::describe_card(options.device);
  } catch (const Error& error) {
    finding.code = error.exit_code();
    finding.error = error.what();
  }
  if (options.board == kBoard) {
    finding.on_bus = has_pci_device(root, kVendor, kDevice);
    finding.module = module_support(root, release, "adv_pci1710", kVendor, kDevice);
  }
  return finding;
}

std::vector<Check> check_card(const hal::ComediOptions& options, const CardFinding& finding) {
  std::vector<Check> checks{check_device(options, finding)};
  if (finding.card) {
    checks.push_back(check_board(options, *finding.card));
  } else if (options.board == kBoard && finding.code != ExitCode::permission) {
    if (!finding.on_bus) {
      checks.push_back(fail("card", "no PCI-1716 (13fe:1716) on the PCI bus", "seat the card; lspci -d 13fe: shows it",
                            ExitCode::device_unavailable));
    } else {
      checks.push_back(ok("card", "a PCI-1716 (13fe:1716) is on the PCI bus"));
    }
    checks.push_back(check_driver(finding));
  }
  return checks;
}

std::vector<Check> check_lines(const hal::ComediOptions& options) {
  return {
      check_line("emergency_stop", "only switching its mains off stops the rig", "one", options.emergency_stop),
      check_line("enable", "nothing switches the hydraulics off when the program or the valve amplifier fails", "one",
                 options.enable),
      check_line("heartbeat",
                 "a call that hangs in the card's driver, or a kernel that hangs, leaves the hydraulics on, and so "
                 "do a run with --local and its guard that are killed together; no program can switch them off then",
                 "a relay that drops the hydraulics' contactor when the line stops toggling (its longest drop time: "
                 "docs/safety.md)",
                 options.heartbeat)};
}

}  // namespace eha::doctor
