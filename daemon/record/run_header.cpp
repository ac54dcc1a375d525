// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/record/run_header.hpp"

#include <H5public.h>
#include <fmt/format.h>
#include <unistd.h>

#include <array>
#include <boost/version.hpp>
#include <cstdint>
#include <optional>

#include "core/error.hpp"
#include "daemon/acquisition/realtime.hpp"
#include "daemon/record/config_json.hpp"
#include "hal/backends/backend.hpp"
#include "ident/excitation/excitation.hpp"

namespace eha::record {
namespace {

using Json = nlohmann::ordered_json;

constexpr const char* kJournalSchema = "eha-journal/1";

Json versions() {
  return {{"ehad", EHA_VERSION},
          {"hdf5", fmt::format("{}.{}.{}", H5_VERS_MAJOR, H5_VERS_MINOR, H5_VERS_RELEASE)},
          {"boost", BOOST_LIB_VERSION},
          {"nlohmann_json", fmt::format("{}.{}.{}", NLOHMANN_JSON_VERSION_MAJOR, NLOHMANN_JSON_VERSION_MINOR,
                                        NLOHMANN_JSON_VERSION_PATCH)},
          {"compiler", __VERSION__}};
}

std::size_t positive_count(const Json& document, const char* key, const std::string& source) {
  const Json& count = document.at(key);
  if (!count.is_number_unsigned() || count == 0U) throw DataError(source + ": " + key + ": expected a number above 0");
  return count;
}

}  // namespace

std::string host_name() {
  std::array<char, 256> name{};
  if (::gethostname(name.data(), name.size() - 1) != 0) name.front() = '\0';
  return name.data();
}

Json describe_kernel() {
  const acquisition::KernelFacts facts = acquisition::kernel_facts();
  return {{"release", facts.release}, {"version", facts.version}, {"preempt_rt", facts.preempt_rt}};
}

Json describe_run(const hal::RigCapabilities& rig, const RunDescription& run) {
  const config::ExperimentConfig& experiment = run.experiment;
  const bool is_virtual = run.time_base == acquisition::TimeBase::virtual_time;
  const config::Played* played = experiment.played();
  const auto excitation_seed = played != nullptr ? ident::seed_of(played->excitation) : std::nullopt;
  const std::optional<std::uint64_t> noise_seed = hal::seed_of(run.rig.backend);
  Json header{{"schema", kJournalSchema},
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
                {"heartbeat", rig.has_heartbeat},
                {"enable_contact", rig.has_enable_contact}}},
              {"rig", to_json(run.rig)},
              {"experiment", to_json(experiment)},
              {"versions", versions()}};
  if (!is_virtual) {
    header["utc_start"] = run.utc_start;
    header["host"] = host_name();
    header["kernel"] = describe_kernel();
  }
  return header;
}

Json header_from_manifest(const Json& manifest) {
  Json header{{"schema", kJournalSchema}};
  const bool is_virtual = manifest.value("time_base", "") == "virtual";
  for (const auto& [key, value] : manifest.items()) {
    const bool is_of_the_end = key == "outcome" || key == "utc_end" || key == "files" || key == "report" ||
                               key == "identification" || key == "recovery" || key == "played_by";
    const bool is_of_the_clock = key == "utc_start" || key == "host" || key == "kernel";
    if (key == "schema" || is_of_the_end || value.is_null() || (is_virtual && is_of_the_clock)) continue;
    header[key] = value;
  }
  return header;
}

RunHeader read_run_header(const Json& document, const std::string& source) {
  try {
    RunHeader header;
    header.sample_period_s = document.at("sample_period_s");
    if (!(header.sample_period_s > 0.0)) throw DataError(source + ": sample_period_s: expected a time");
    header.samples_per_repetition = positive_count(document, "samples_per_repetition", source);
    header.repetitions = positive_count(document, "repetitions", source);
    const Json& experiment = document.at("experiment");
    header.decimation = positive_count(experiment.at("record"), "decimation", source);
    header.discard_s = experiment.at("record").at("discard_s");
    header.experiment_text = experiment.at("text");
    header.rig_text = document.at("rig").at("text");
    return header;
  } catch (const Json::exception& error) {
    throw DataError(source + ": " + error.what());
  }
}

std::string rig_units(const Json& manifest) {
  const auto rig = manifest.find("rig");
  if (rig == manifest.end() || !rig->is_object()) return {};
  const auto units = rig->find("units");
  return units != rig->end() && units->is_string() ? units->get<std::string>() : std::string();
}

}  // namespace eha::record
