// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/record/report_json.hpp"

#include <cmath>
#include <cstddef>
#include <utility>

namespace eha::record {
namespace {

using Json = nlohmann::ordered_json;

Json describe_histogram(const acquisition::Histogram& histogram) {
  Json buckets = Json::array();
  Json counts = Json::array();
  for (std::size_t i = 0; i < acquisition::Histogram::kBuckets; ++i) {
    if (histogram.buckets()[i] == 0) continue;
    buckets.push_back(i);
    counts.push_back(histogram.buckets()[i]);
  }
  return {{"count", histogram.count()},
          {"p50_us", histogram.percentile_us(0.5)},
          {"p99_us", histogram.percentile_us(0.99)},
          {"p99_9_us", histogram.percentile_us(0.999)},
          {"max_us", static_cast<double>(histogram.maximum_ns()) / 1e3},
          {"max_at_s", static_cast<double>(histogram.maximum_at_ns()) / 1e9},
          {"bucket_us", std::move(buckets)},
          {"counts", std::move(counts)}};
}

Json describe_margin(const acquisition::RunReport& report, const acquisition::Margin& margin) {
  return {{"percent", 100.0 * margin.share},
          {"at_s", acquisition::record_s(report, margin.at_ns)},
          {"warning", margin.share > acquisition::kWarningShare}};
}

Json describe_fault(const acquisition::RunReport& report) {
  const acquisition::FaultReport& fault = report.fault;
  if (fault.fault == acquisition::Fault::none) return nullptr;
  const auto number = [](double value) { return std::isfinite(value) ? Json(value) : Json(nullptr); };
  Json described{{"cause", acquisition::to_text(fault.fault)},
                 {"at_s", acquisition::record_s(report, fault.at_ns)},
                 {"value", number(fault.value)},
                 {"limit", number(fault.limit)},
                 {"status", acquisition::to_text(fault.status)}};
  if (fault.has_jumped) described["has_jumped"] = true;
  if (fault.driven_s > 0.0) {
    described["driven_V"] = fault.driven_V;
    described["driven_s"] = fault.driven_s;
  }
  return described;
}

}  // namespace

Json describe_report(const acquisition::RunReport& report, const DisplayUnit& unit) {
  const acquisition::LoopCounters& counters = report.counters;
  return {
      {"description", acquisition::describe(report, unit)},
      {"fault", describe_fault(report)},
      {"final_state", acquisition::to_text(report.final_state)},
      {"safe_confirmed", report.safe_confirmed},
      {"stops", report.stops_seen},
      {"margins",
       {{"travel", describe_margin(report, report.travel)}, {"velocity", describe_margin(report, report.velocity)}}},
      {"counters",
       {{"ticks", counters.ticks},
        {"experiment_rows", counters.experiment_rows},
        {"late", counters.late},
        {"skipped", counters.skipped},
        {"timeouts", counters.timeouts},
        {"clamped", counters.clamped},
        {"slew_limited", counters.slew_limited},
        {"dropped", counters.dropped},
        {"queue_peak", counters.queue_peak},
        {"minor_faults", counters.minor_faults},
        {"major_faults", counters.major_faults},
        {"involuntary_switches", counters.involuntary_switches}}},
      {"latency", describe_histogram(report.latency)},
      {"execution", describe_histogram(report.execution)},
      {"realtime",
       {{"fifo", report.realtime.fifo},
        {"memory_locked", report.realtime.memory_locked},
        {"cpu_bound", report.realtime.cpu_bound},
        {"c_states_held", report.realtime.c_states_held},
        {"refused", report.realtime.refused}}}};
}

Json describe_end(const acquisition::RunReport& report) {
  return {{"outcome", acquisition::to_text(report.outcome)},
          {"fault", describe_fault(report)},
          {"safe_confirmed", report.safe_confirmed},
          {"ticks", report.counters.ticks},
          {"experiment_rows", report.counters.experiment_rows},
          {"late", report.counters.late},
          {"skipped", report.counters.skipped}};
}

}  // namespace eha::record
