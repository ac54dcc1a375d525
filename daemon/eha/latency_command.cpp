// SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <string>
#include <vector>

#include "daemon/delays/run_delays.hpp"
#include "daemon/doctor/latency.hpp"
#include "daemon/doctor/load_threads.hpp"
#include "daemon/eha/command.hpp"
#include "daemon/eha/command_list.hpp"
#include "daemon/eha/option_values.hpp"
#include "daemon/eha/rig_source.hpp"
#include "daemon/eha/stop_on_signals.hpp"
#include "daemon/eha/terminal_table.hpp"
#include "daemon/record/report_json.hpp"

namespace eha::cli {
namespace {

using acquisition::Histogram;
using Json = nlohmann::ordered_json;

constexpr const char* kRoot = "/";

constexpr const char* kLatencyFooter = R"(
Runs the tick loop on the simulated rig in real time and shows how late ticks wake up and how long they take [us].
Passes when 99.9 % wake up within 50 us and all within 150 us, no tick takes over 300 us, and none is skipped. Else it
names what held the loop up: threads of higher priority, interrupts, the other half of the core, the host, the firmware.
--rig takes period, priority and CPU of the loop from a rig file; its card is not touched.
Exit code 0: passed; 12: missed.

Examples:
  eha latency
  eha latency --duration 3600 --load)";

struct LatencyCommand {
  double duration_s = 60.0;
  bool load = false;  ///< keep every CPU busy meanwhile
  std::optional<std::string> rig_file =
      {};  ///< rig file with the loop's period, priority and CPU; none: default_rig_file()
};

config::RealtimeOptions realtime_options(const std::optional<std::string>& rig_file) {
  if (!rig_file && !default_rig_file()) return {};
  return load_rig_or_default(rig_file).realtime;
}

std::vector<std::string> row(const char* name, const Histogram& histogram) {
  return {name,
          fmt::format("{:.0f}", histogram.percentile_us(0.5)),
          fmt::format("{:.0f}", histogram.percentile_us(0.99)),
          fmt::format("{:.0f}", histogram.percentile_us(0.999)),
          fmt::format("{:.1f}", static_cast<double>(histogram.maximum_ns()) * 1e-3),
          fmt::format("{:.3f}", static_cast<double>(histogram.maximum_at_ns()) * 1e-9)};
}

/// The number of values between neighbouring edges [us]; the last interval is open.
std::string bars(const Histogram& histogram) {
  constexpr std::size_t kEdges[] = {0, 10, 20, 50, 100, 150, 300, 500, 1000};
  constexpr std::size_t kCount = std::size(kEdges);
  std::string text;
  for (std::size_t i = 0; i < kCount; ++i) {
    const std::size_t end = i + 1 < kCount ? kEdges[i + 1] : Histogram::kBuckets;
    std::uint64_t count = 0;
    for (std::size_t bucket = kEdges[i]; bucket < end; ++bucket) count += histogram.buckets()[bucket];
    const std::string range =
        i + 1 < kCount ? fmt::format("{}-{} us", kEdges[i], end) : fmt::format("{} us up", kEdges[i]);
    if (count > 0) text += fmt::format("  {:>12}  {}\n", range, count);
  }
  return text;
}

void show(const acquisition::RunReport& report, const std::vector<doctor::Gate>& gates, Console& console) {
  console.print(text_table({{"us", Align::left},
                            {"p50", Align::right},
                            {"p99", Align::right},
                            {"p99.9", Align::right},
                            {"max", Align::right},
                            {"max at s", Align::right}},
                           {row("wake-up latency", report.latency), row("execution", report.execution)}));
  console.print(fmt::format("\nwake-up latency, ticks:\n{}", bars(report.latency)));
  const acquisition::LoopCounters& counters = report.counters;
  console.print(fmt::format("{} ticks, {} late, {} skipped; {} minor and {} major page faults, {} preemptions",
                            counters.ticks, counters.late, counters.skipped, counters.minor_faults,
                            counters.major_faults, counters.involuntary_switches));
  for (const doctor::Gate& gate : gates) {
    console.print(fmt::format("{:<6}  {:<17} {:>9.1f}, at most {:.0f}", gate.met() ? "met" : "missed", gate.name,
                              gate.value, gate.limit));
  }
}

void show(const std::vector<delays::Delay>& seen, const Console& console) {
  console.print(seen.empty() ? "the counters of the kernel name no cause" : "what held the loop up meanwhile:");
  for (const delays::Delay& delay : seen) {
    console.print(fmt::format("  {:<10}  {}\n{:<12}-> {}", delay.name, delay.found, "", delay.remedy));
  }
}

ExitCode execute(const LatencyCommand& command, Console& console) {
  const config::RealtimeOptions realtime = realtime_options(command.rig_file);
  console.info(fmt::format("the tick loop on the simulated rig for {:g} s, a tick every {:g} s{}", command.duration_s,
                           realtime.sample_period_s, command.load ? ", every CPU under load" : ""));
  StopOnSignals stop;
  std::optional<doctor::LoadThreads> load;
  if (command.load) load.emplace();
  const delays::Counters before = delays::read_counters(kRoot);
  const acquisition::RunReport report =
      doctor::measure_latency(command.duration_s, realtime, stop.request(), [&](const acquisition::Snapshot& now) {
        console.progress(static_cast<double>(now.experiment_row) / std::max(1U, now.experiment_rows),
                         fmt::format("{:.0f} of {:g} s, latency max {:.0f} us, {} late",
                                     now.experiment_row * realtime.sample_period_s, command.duration_s,
                                     static_cast<double>(now.latency_max_ns) * 1e-3, now.counters.late));
      });
  const std::vector<delays::Delay> seen = delays::delays_of_run(before, realtime, report);
  load.reset();
  console.end_progress();
  for (const std::string& sentence : report.realtime.refused) console.warning(sentence);
  if (!report.realtime.fifo)
    console.warning("measured on ordinary scheduling; a rig that moves needs real-time scheduling");

  const std::vector<doctor::Gate> gates = doctor::gates(report);
  const bool passed = std::all_of(gates.begin(), gates.end(), [](const doctor::Gate& gate) { return gate.met(); });
  ExitCode code = acquisition::exit_code(report);
  if (code == ExitCode::ok && !passed) code = ExitCode::deadline;

  Json document{{"schema", "eha-latency/1"},
                {"duration_s", command.duration_s},
                {"sample_period_s", realtime.sample_period_s},
                {"load", command.load},
                {"passed", passed},
                {"gates", Json::array()},
                {"delays", Json::array()},
                {"report", record::describe_report(report)},
                {"exit_code", static_cast<int>(code)}};
  for (const delays::Delay& delay : seen) document["delays"].push_back(delays::to_json(delay));
  for (const doctor::Gate& gate : gates) {
    document["gates"].push_back(
        {{"name", gate.name}, {"value", gate.value}, {"limit", gate.limit}, {"met", gate.met()}});
  }
  console.print_json(document);
  show(report, gates, console);
  if (!passed) show(seen, console);
  if (report.outcome != acquisition::Outcome::completed) console.error(acquisition::describe(report));
  console.print(passed ? "PASSED: fit for a rig" : "MISSED: `eha doctor` lists remedies");
  return code;
}

}  // namespace

void add_latency(CLI::App& app, ParsedLine& line) {
  CLI::App* sub = app.add_subcommand("latency", "Measure how well the tick loop keeps time on this machine");
  sub->footer(kLatencyFooter);
  auto& latency = options_of<LatencyCommand>(*sub, line);
  sub->add_option("--duration", latency.duration_s, "How long to measure, 0.1 to 65535 s (default 60)")
      ->type_name("SECONDS")
      ->check(finite_number("seconds from 0.1 to 65535", [](double s) {
        return s >= doctor::kShortestMeasurement_s && s <= doctor::kLongestMeasurement_s;
      }));
  sub->add_flag("--load", latency.load, "Keep every CPU and the memory busy meanwhile");
  sub->add_option("--rig", latency.rig_file, "Rig file whose period, priority and CPU apply")->type_name("RIG");
}

}  // namespace eha::cli
