// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/unit/delays/machines.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "daemon/delays/delays.hpp"

namespace eha::delays {
namespace {

using Names = std::vector<std::string>;

constexpr LoopThread kBound{.cpu = 1, .priority = 80, .process = 500};
constexpr LoopThread kAnywhere{.cpu = {}, .priority = 80, .process = 500};

Names names(const std::vector<Delay>& delays) {
  Names all;
  for (const Delay& delay : delays) all.push_back(delay.name);
  return all;
}

bool says(const std::vector<Delay>& delays, const std::string& name, const std::string& text) {
  return std::any_of(delays.begin(), delays.end(), [&](const Delay& delay) {
    return delay.name == name && delay.found.find(text) != std::string::npos && !delay.remedy.empty();
  });
}

std::vector<Delay> standing(const Machine& machine, const LoopThread& loop) {
  return standing_delays(machine.root(), read_counters(machine.root()), loop);
}

/// Ten seconds in which `happens` changes the machine.
template <typename Change>
std::vector<Delay> seen(const Machine& machine, const LoopThread& loop, const Change& happens) {
  const Counters before = read_counters(machine.root());
  machine.passes("1010.00 1910.00\n");
  happens();
  return seen_delays(machine.root(), before, read_counters(machine.root()), loop);
}

/// As it comes from the shop: two CPUs a core, interrupts anywhere, watchdogs on.
void make_desktop(const Machine& machine) {
  machine.common();
  for (int cpu : {0, 2}) machine.halves(cpu, "0,2");
  for (int cpu : {1, 3}) machine.halves(cpu, "1,3");
  machine.write("proc/interrupts",
                std::string(kFourCpus) +
                    " 130:     100000     250000          0          0   PCI-MSI 524288-edge      nvme0q1\n"
                    " 131:          0        900          0          0   PCI-MSI 327680-edge      xhci_hcd\n"
                    "NMI:          1          1          1          1   Non-maskable interrupts\n"
                    "LOC:     500000     500000     500000     500000   Local timer interrupts\n");
  machine.write("proc/irq/130/effective_affinity_list", "1\n");
  machine.write("proc/irq/131/effective_affinity_list", "2\n");
  machine.write("proc/sys/kernel/nmi_watchdog", "1\n");
  machine.write("proc/sys/kernel/soft_watchdog", "1\n");
  machine.write("proc/sys/kernel/watchdog_cpumask", "0-3\n");
  machine.write("proc/cmdline", "BOOT_IMAGE=/vmlinuz root=/dev/sda1 quiet\n");
  machine.write("proc/cpuinfo", "processor\t: 0\nflags\t\t: fpu vme sse2 constant_tsc\n");
  machine.write("proc/stat",
                "cpu  4 0 0 0 0 0 0 0 0 0\ncpu0 100 0 0 0 0 0 0 0 0 0\ncpu1 100 0 0 0 0 0 0 0 0 0\n"
                "cpu2 100 0 0 0 0 0 0 0 0 0\ncpu3 100 0 0 0 0 0 0 0 0 0\n");
}

TEST(StockDesktop, IsNamedForWhatItsLoopShares) {
  const Machine machine;
  make_desktop(machine);
  const std::vector<Delay> delays = standing(machine, kBound);
  EXPECT_EQ(names(delays), (Names{"sibling", "interrupts", "tick", "rcu", "watchdog", "watchdog"}));
  EXPECT_TRUE(says(delays, "sibling", "CPU 3 is the other half of the core of CPU 1"));
  EXPECT_TRUE(says(delays, "interrupts", "the interrupts of 1 devices: 130 (nvme0q1)"));
  EXPECT_EQ(names(standing(machine, kAnywhere)), Names{}) << "nothing is asked of a loop that runs anywhere";
}

TEST(StockDesktop, SawABusyHalfOfTheCoreAndAStormOfInterrupts) {
  const Machine machine;
  make_desktop(machine);
  const std::vector<Delay> delays = seen(machine, kBound, [&] {
    machine.write("proc/stat", "cpu1 110 0 0 0 0 0 0 0 0 0\ncpu3 970 0 0 0 0 0 0 0 0 0\n");
    machine.write("proc/interrupts",
                  std::string(kFourCpus) +
                      " 130:     100000     302000          0          0   PCI-MSI 524288-edge      nvme0q1\n"
                      " 131:          0        900     900000          0   PCI-MSI 327680-edge      xhci_hcd\n"
                      "LOC:     520000     520000     520000     520000   Local timer interrupts\n");
  });
  EXPECT_EQ(names(delays), (Names{"sibling", "interrupts"}));
  EXPECT_TRUE(says(delays, "sibling", "CPU 3, the other half of the core of CPU 1, was busy for 87 %"));
  EXPECT_TRUE(says(delays, "interrupts", "interrupt 130 (nvme0q1) came 5200 times a second to CPU 1"));
}

/// An isolated processor, interrupts and kernel elsewhere, PREEMPT_RT.
void make_rig(const Machine& machine) {
  machine.common();
  machine.halves(1, "1");
  machine.write(
      "proc/interrupts",
      std::string(kFourCpus) + "  24:     800000          3          0          0   PCI-MSI 0-edge      eth0\n");
  machine.write("proc/irq/24/effective_affinity_list", "0\n");
  machine.write("proc/sys/kernel/nmi_watchdog", "0\n");
  machine.write("proc/sys/kernel/soft_watchdog", "1\n");
  machine.write("proc/sys/kernel/watchdog_cpumask", "0,2-3\n");
  machine.write("sys/devices/system/cpu/nohz_full", "1\n");
  machine.write("proc/cmdline", "BOOT_IMAGE=/vmlinuz isolcpus=1 nohz_full=1 rcu_nocbs=1 irqaffinity=0\n");
  machine.write("proc/stat", "cpu0 900 0 0 0 0 0 0 0 0 0\ncpu1 100 0 0 0 0 0 0 0 0 0\n");
}

TEST(IsolatedRig, HasNoCulpritAndSawNone) {
  const Machine machine;
  make_rig(machine);
  EXPECT_EQ(names(standing(machine, kBound)), Names{});
  const std::vector<Delay> delays = seen(machine, kBound, [&] {
    machine.write(
        "proc/interrupts",
        std::string(kFourCpus) + "  24:     950000          4          0          0   PCI-MSI 0-edge      eth0\n");
    machine.thread(500, 501, "eha-loop", 80, 1, 20);
    machine.thread(600, 600, "eha-safe", 95, 0, 70);
    machine.thread(20, 20, "migration/1", 99, 1, 5, 2);
  });
  EXPECT_EQ(names(delays), Names{});
}

TEST(IsolatedRig, SawTheThreadOfHigherPriorityOnItsProcessor) {
  const Machine machine;
  make_rig(machine);
  machine.thread(700, 701, "hog (x) 1", 90, 1, 100);
  EXPECT_TRUE(says(standing(machine, kBound), "priority", "thread 701 \"hog (x) 1\" has real-time priority 90"));
  machine.thread(700, 702, "another", 90, 1, 100);
  EXPECT_EQ(standing(machine, kBound).size(), standing(machine, {.cpu = 1, .priority = 0, .process = 500}).size() + 1)
      << "one remedy helps a loop without a priority against all";
  const auto uses = [&](int priority, int cpu, int used) {
    return [&machine, priority, cpu, used] { machine.thread(700, 701, "hog (x) 1", priority, cpu, 100 + used); };
  };
  EXPECT_TRUE(says(seen(machine, kBound, uses(90, 1, 300)), "priority", "had CPU 1 for 3 s of 10 s; the loop has 80"));
  make_rig(machine);
  machine.thread(700, 701, "hog (x) 1", 90, 1, 100);
  EXPECT_EQ(names(seen(machine, kBound, uses(90, 0, 300))), Names{}) << "another processor";
  make_rig(machine);
  machine.thread(700, 701, "hog (x) 1", 50, 1, 100);
  EXPECT_EQ(names(seen(machine, kBound, uses(50, 1, 300))), Names{}) << "the loop comes first";
}

TEST(IsolatedRig, LeavesTheServicesOwnLoopItsPriority) {
  const Machine machine;
  make_rig(machine);
  machine.thread(700, 701, "eha-loop", 80, 1, 100);
  EXPECT_EQ(names(standing(machine, kBound)), Names{});
  const auto delays = seen(machine, kBound, [&] { machine.thread(700, 701, "eha-loop", 80, 1, 400); });
  ASSERT_EQ(delays.size(), 1U);
  EXPECT_NE(delays[0].remedy.find("[realtime] of one rig file"), std::string::npos) << delays[0].remedy;
}

TEST(IsolatedRig, ShowsThreadsThatANameMayHideAsPrintable) {
  const Machine machine;
  make_rig(machine);
  machine.thread(700, 701, "\x1b[2J\xff)", 90, 1, 100);
  EXPECT_TRUE(says(standing(machine, kBound), "priority", "thread 701 \"?[2J?)\" has"));
}

TEST(IsolatedRig, SawThreadsThatAServiceMayNotSee) {
  const Machine machine;
  make_rig(machine);
  LoopThread loop = kBound;
  loop.preemptions = 4;
  EXPECT_TRUE(says(seen(machine, loop, [] {}), "priority", "took the loop's place 4 times"));
}

TEST(Throttling, IsNamedWhenAThreadBelowTheLoopUsesTheShareOfAll) {
  const Machine machine;
  make_rig(machine);
  machine.thread(700, 701, "control", 40, 1, 100);
  const auto happens = [&] { machine.thread(700, 701, "control", 40, 1, 100 + 940); };
  const std::vector<Delay> delays = seen(machine, kBound, happens);
  EXPECT_EQ(names(delays), Names{"throttling"});
  EXPECT_TRUE(says(delays, "throttling", "used 94 % of CPU 1, where the kernel stops them all"));
  make_rig(machine);
  machine.thread(700, 701, "control", 40, 1, 100);
  machine.write("proc/sys/kernel/sched_rt_runtime_us", "-1\n");
  EXPECT_EQ(names(seen(machine, kBound, happens)), Names{}) << "no limit";
  machine.write("proc/sys/kernel/sched_rt_runtime_us", "100000\n");
  EXPECT_TRUE(says(standing(machine, kBound), "throttling", "may use 10 % of a CPU"));
}

/// Sleeps deeply, and its firmware takes the processors away.
void make_laptop(const Machine& machine) {
  machine.common();
  machine.write("proc/stat", "cpu0 0 0 0 0 0 0 0 0 0 0\ncpu1 0 0 0 0 0 0 0 0 0 0\n");
  machine.write("proc/interrupts",
                "           CPU0       CPU1\nTRM:          3          3   Thermal event interrupts\n");
  for (int cpu : {0, 1}) {
    machine.smi(cpu, 411);
    machine.sleep_state(cpu, 0, "POLL", 0, 5);
    machine.sleep_state(cpu, 1, "C1E", 10, 1000);
    machine.sleep_state(cpu, 2, "C8", 200, 50000);
  }
}

TEST(Laptop, SawDeepSleepFirmwareAndHeat) {
  const Machine machine;
  make_laptop(machine);
  EXPECT_TRUE(says(standing(machine, kAnywhere), "firmware", "411 system management interrupts since boot"));
  const std::vector<Delay> delays = seen(machine, kAnywhere, [&] {
    machine.smi(0, 413);
    machine.smi(1, 413);
    machine.sleep_state(1, 1, "C1E", 10, 90000);
    machine.sleep_state(1, 2, "C8", 200, 50120);
    machine.write("proc/interrupts",
                  "           CPU0       CPU1\nTRM:          3          4   Thermal event interrupts\n");
  });
  EXPECT_EQ(names(delays), (Names{"interrupts", "firmware", "sleep"}));
  EXPECT_TRUE(says(delays, "interrupts", "CPU 1 was throttled for its heat"));
  EXPECT_TRUE(says(delays, "firmware", "2 system management interrupts: the firmware"));
  EXPECT_TRUE(says(delays, "sleep", "CPU 1 slept in state C8 12 times a second; waking up takes 200 us"));
}

TEST(VirtualMachine, SawItsHostAndItsPackets) {
  const Machine machine;
  machine.common();
  machine.write("proc/cpuinfo", "processor\t: 0\nflags\t\t: fpu hypervisor lm\n");
  machine.write("proc/stat", "cpu0 0 0 0 0 0 0 0 5 0 0\ncpu1 0 0 0 0 0 0 0 7 0 0\n");
  machine.write("proc/softirqs", "                    CPU0       CPU1       \n      NET_RX:     100000      10000\n");
  EXPECT_EQ(names(standing(machine, kAnywhere)), Names{"host"});
  const std::vector<Delay> delays = seen(machine, kAnywhere, [&] {
    machine.write("proc/stat", "cpu0 0 0 0 0 0 0 0 5 0 0\ncpu1 0 0 0 0 0 0 0 87 0 0\n");
    machine.write("proc/softirqs", "                    CPU0       CPU1       \n      NET_RX:     100000     110000\n");
  });
  EXPECT_EQ(names(delays), (Names{"host", "softirqs"}));
  EXPECT_TRUE(says(delays, "host", "took CPU 1 away for 0.8 s of 10 s"));
  EXPECT_TRUE(says(delays, "softirqs", "network packets kept CPU 1 10000 times a second"));
}

TEST(EmptyMachine, NamesNothingAndSurvivesWhatIsNoKernelsFile) {
  const Machine machine;
  EXPECT_EQ(names(standing(machine, kAnywhere)), Names{});
  machine.write("proc/uptime", "x\n");
  machine.write("proc/stat", "cpu\ncpux 1\ncpu0 1 2\n");
  machine.write("proc/interrupts", "CPU0 nonsense\n:\n 1: 2 3 4\nLOC\n  :9\n");
  machine.write("proc/softirqs", "");
  machine.write("proc/7/task/7/stat", "7 (x");
  machine.write("proc/8/task/8/stat", "8 (x) S 1");
  machine.write("proc/9/task/9/stat", ")(");
  machine.write("dev/cpu/0/msr", "short");
  EXPECT_EQ(names(standing(machine, kAnywhere)), Names{});
  EXPECT_EQ(names(seen(machine, kBound, [] {})), Names{});
}

}  // namespace
}  // namespace eha::delays
