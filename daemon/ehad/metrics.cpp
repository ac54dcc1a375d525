// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/ehad/metrics.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <string_view>

namespace eha::service {
namespace {

using acquisition::State;

constexpr std::array kMetricStates{State::faulted, State::idle,     State::armed,    State::ramp_in,
                                   State::running, State::ramp_out, State::safe_stop};

class Text {
 public:
  void begin(std::string_view name, std::string_view type, std::string_view help) {
    fmt::format_to(std::back_inserter(text_), "# HELP {} {}\n# TYPE {} {}\n", name, help, name, type);
  }
  template <typename Value>
  void line(std::string_view name, Value value) {
    fmt::format_to(std::back_inserter(text_), "{} {}\n", name, value);
  }
  template <typename Value>
  void one(std::string_view name, std::string_view type, std::string_view help, Value value) {
    begin(name, type, help);
    line(name, value);
  }
  [[nodiscard]] std::string take() { return std::move(text_); }

 private:
  std::string text_;
};

}  // namespace

void Totals::add(const acquisition::RunReport& report) {
  ticks += report.counters.ticks;
  late += report.counters.late;
  skipped += report.counters.skipped;
  dropped += report.counters.dropped;
  latency_max_ns = std::max(latency_max_ns, report.latency.maximum_ns());
  ++runs[static_cast<std::size_t>(report.outcome)];
}

std::string metrics_text(const Totals& totals, const MetricsFacts& facts) {
  Totals now = totals;
  if (facts.snapshot) {
    now.ticks += facts.snapshot->counters.ticks;
    now.late += facts.snapshot->counters.late;
    now.skipped += facts.snapshot->counters.skipped;
    now.dropped += facts.snapshot->counters.dropped;
    now.latency_max_ns = std::max(now.latency_max_ns, facts.snapshot->latency_max_ns);
  }
  Text text;
  text.one("ehad_ticks_total", "counter", "Ticks that ran.", now.ticks);
  text.one("ehad_late_ticks_total", "counter", "Ticks that began more than half a period late.", now.late);
  text.one("ehad_skipped_ticks_total", "counter", "Ticks that never ran.", now.skipped);
  text.one("ehad_dropped_records_total", "counter", "Records lost because the writer was too slow.", now.dropped);
  text.one("ehad_latency_max_seconds", "gauge", "Greatest lateness of a tick since the service started.",
           static_cast<double>(now.latency_max_ns) * 1e-9);
  text.begin("ehad_runs_total", "counter", "Runs since the service started, by how they ended.");
  for (const auto& [name, outcome] : acquisition::kOutcomes) {
    text.line(fmt::format("ehad_runs_total{{outcome=\"{}\"}}", name), now.runs[static_cast<std::size_t>(outcome)]);
  }
  text.one("ehad_queue_length", "gauge", "Experiments that wait, held ones included.", facts.waiting);
  text.one("ehad_queue_held", "gauge", "Experiments that wait for their release.", facts.held);
  text.begin("ehad_state", "gauge", "1 for the state that the rig is in.");
  for (const State state : kMetricStates) {
    text.line(fmt::format("ehad_state{{state=\"{}\"}}", acquisition::to_text(state)), state == facts.state ? 1 : 0);
  }
  text.one("ehad_lease_held", "gauge", "Whether somebody holds the lease.", facts.lease_remaining_s ? 1 : 0);
  text.one("ehad_lease_remaining_seconds", "gauge", "Until the lease expires.", facts.lease_remaining_s.value_or(0.0));
  text.one("ehad_worker_busy", "gauge", "Whether a run is being fitted.", facts.worker_busy ? 1 : 0);
  text.one("ehad_worker_failures_total", "counter", "Identifications that crashed, hung or were killed.",
           now.worker_failures);
  return text.take();
}

}  // namespace eha::service
