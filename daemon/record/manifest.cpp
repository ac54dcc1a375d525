// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/record/manifest.hpp"

#include <fmt/chrono.h>
#include <hdf5.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <boost/version.hpp>
#include <chrono>
#include <cmath>
#include <ctime>
#include <optional>
#include <vector>

#include "core/error.hpp"
#include "core/os/files.hpp"
#include "daemon/acquisition/realtime.hpp"
#include "daemon/record/config_json.hpp"
#include "daemon/record/run_folder.hpp"
#include "daemon/record/sha256.hpp"
#include "hal/backend.hpp"

namespace eha::record {
namespace {

using Json = nlohmann::ordered_json;

Json versions() {
  unsigned major = 0;
  unsigned minor = 0;
  unsigned release = 0;
  H5get_libversion(&major, &minor, &release);
  return {{"ehad", EHA_VERSION},
          {"hdf5", fmt::format("{}.{}.{}", major, minor, release)},
          {"boost", BOOST_LIB_VERSION},
          {"nlohmann_json", fmt::format("{}.{}.{}", NLOHMANN_JSON_VERSION_MAJOR, NLOHMANN_JSON_VERSION_MINOR,
                                        NLOHMANN_JSON_VERSION_PATCH)},
          {"compiler", __VERSION__}};
}

Json kernel() {
  const acquisition::KernelFacts facts = acquisition::kernel_facts();
  return {{"release", facts.release}, {"version", facts.version}, {"preempt_rt", facts.preempt_rt}};
}

std::string host() {
  std::array<char, 256> name{};
  if (::gethostname(name.data(), name.size() - 1) != 0) name.front() = '\0';
  return name.data();
}

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

Json describe_fault(const acquisition::FaultReport& fault) {
  if (fault.fault == acquisition::Fault::none) return nullptr;
  const auto number = [](double value) { return std::isfinite(value) ? Json(value) : Json(nullptr); };
  return {{"cause", acquisition::to_text(fault.fault)},
          {"at_s", static_cast<double>(fault.at_ns) / 1e9},
          {"value", number(fault.value)},
          {"limit", number(fault.limit)},
          {"status", acquisition::to_text(fault.status)}};
}

/// What the manifest already says about a file of the record proper, which never changes once its run is over: hashing
/// it again would cover up a change.
const Json* find_raw_entry(const Json& manifest, const std::string& path) {
  if (!manifest.contains("files") || !manifest["files"].is_array()) return nullptr;
  for (const Json& entry : manifest["files"]) {
    if (entry.value("path", "") == path && (path == kRawFile || path == kJournalFile)) return &entry;
  }
  return nullptr;
}

}  // namespace

Json describe_run(const hal::RigCapabilities& rig, const RunDescription& run) {
  const config::ExperimentConfig& experiment = run.experiment;
  const bool is_virtual = run.time_base == acquisition::TimeBase::virtual_time;
  const std::optional<std::uint64_t> excitation_seed = ident::seed_of(experiment.excitation);
  const std::optional<std::uint64_t> noise_seed = hal::seed_of(run.rig.backend);
  Json header{{"schema", "eha-journal/1"},
              {"name", experiment.name},
              {"time_base", is_virtual ? "virtual" : "monotonic"},
              {"sample_period_s", run.rig.realtime.sample_period_s},
              {"samples_per_repetition", run.samples_per_repetition},
              {"repetitions", experiment.repetitions},
              {"seed",
               {{"excitation", excitation_seed ? Json(*excitation_seed) : Json(nullptr)},
                {"identification", experiment.fit.seed},
                {"sensor_noise", noise_seed ? Json(*noise_seed) : Json(nullptr)}}},
              {"device",
               {{"backend", rig.backend},
                {"device", rig.device},
                {"board", rig.board},
                {"driver", rig.driver},
                {"command_range_V", {rig.command_min_V, rig.command_max_V}},
                {"command_lsb_V", rig.command_lsb_V},
                {"feedback_range_V", {rig.feedback_min_V, rig.feedback_max_V}},
                {"feedback_lsb_V", rig.feedback_lsb_V},
                {"emergency_stop", rig.has_emergency_stop},
                {"enable", rig.has_enable},
                {"heartbeat", rig.has_heartbeat}}},
              {"rig", to_json(run.rig)},
              {"experiment", to_json(experiment)},
              {"versions", versions()}};
  if (!is_virtual) {
    header["utc_start"] = run.utc_start;
    header["host"] = host();
    header["kernel"] = kernel();
  }
  return header;
}

Json describe_report(const acquisition::RunReport& report) {
  const acquisition::LoopCounters& counters = report.counters;
  return {{"description", acquisition::describe(report)},
          {"fault", describe_fault(report.fault)},
          {"final_state", acquisition::to_text(report.final_state)},
          {"safe_confirmed", report.safe_confirmed},
          {"stops", report.stops_seen},
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
          {"fault", describe_fault(report.fault)},
          {"safe_confirmed", report.safe_confirmed},
          {"ticks", report.counters.ticks},
          {"experiment_rows", report.counters.experiment_rows},
          {"late", report.counters.late},
          {"skipped", report.counters.skipped}};
}

Json manifest_from_header(const Json& header) {
  Json manifest{{"schema", "eha-run/1"}, {"outcome", kInProgress}, {"utc_start", nullptr}, {"utc_end", nullptr}};
  for (const auto& [key, value] : header.items()) {
    if (key != "schema") manifest[key] = value;
  }
  for (const char* key : {"host", "kernel", "files", "report", "identification"}) {
    if (!manifest.contains(key)) manifest[key] = nullptr;
  }
  return manifest;
}

Json new_manifest(const Json& header, const std::string& utc_start) {
  Json manifest = manifest_from_header(header);
  manifest["utc_start"] = utc_start;
  manifest["host"] = host();
  manifest["kernel"] = kernel();
  return manifest;
}

void write_manifest(const std::filesystem::path& folder, Json& manifest) {
  std::vector<std::filesystem::path> files;
  try {
    for (const auto& entry : std::filesystem::recursive_directory_iterator(folder)) {
      const std::filesystem::path relative = entry.path().lexically_relative(folder);
      if (entry.is_regular_file() && relative != kManifestFile && relative.extension() != ".tmp") {
        files.push_back(relative);
      }
    }
  } catch (const std::filesystem::filesystem_error& error) {
    os::throw_system_error("list", folder, error.code().value());
  }
  std::sort(files.begin(), files.end());
  Json list = Json::array();
  for (const std::filesystem::path& file : files) {
    const std::filesystem::path path = folder / file;
    if (const Json* known = find_raw_entry(manifest, file.generic_string())) {
      list.push_back(*known);
      continue;
    }
    list.push_back({{"path", file.generic_string()},
                    {"bytes", std::filesystem::file_size(path)},
                    {"sha256", sha256_of_file(path)}});
  }
  manifest["files"] = std::move(list);
  os::write_file_atomically(folder / kManifestFile,
                            manifest.dump(2, ' ', false, Json::error_handler_t::replace) + "\n");
}

std::string utc_now() {
  const std::time_t now = std::chrono::system_clock::to_time_t(std::chrono::system_clock::now());
  return fmt::format("{:%Y-%m-%dT%H:%M:%SZ}", fmt::gmtime(now));
}

acquisition::Outcome outcome_from_text(std::string_view name, const std::string& source) {
  if (const auto outcome = value_in(acquisition::kOutcomes, name)) return *outcome;
  throw DataError(source + ": \"" + std::string(name) + "\" is no outcome of a run");
}

}  // namespace eha::record
