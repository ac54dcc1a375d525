// SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <iterator>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "core/error.hpp"
#include "core/os/files.hpp"
#include "core/shell_word.hpp"
#include "daemon/eha/command.hpp"
#include "daemon/eha/command_list.hpp"
#include "daemon/eha/next_command.hpp"
#include "daemon/eha/option_values.hpp"
#include "daemon/eha/rig_source.hpp"
#include "daemon/eha/run_argument.hpp"
#include "daemon/eha/terminal_table.hpp"
#include "daemon/identify/source.hpp"
#include "daemon/identify/thread_executor.hpp"
#include "daemon/plot/envelope.hpp"
#include "daemon/plot/gnuplot.hpp"
#include "daemon/record/manifest.hpp"
#include "daemon/replay/replay.hpp"
#include "daemon/replay/twin_calibration.hpp"
#include "daemon/replay/twin_file.hpp"
#include "daemon/replay/twin_parameter.hpp"
#include "daemon/rig/calibration.hpp"
#include "daemon/tune/twin_draws.hpp"
#include "ident/model/parameter_text.hpp"
#include "ident/validation/score.hpp"

namespace eha::cli {
namespace {

using Json = nlohmann::ordered_json;

constexpr const char* kReplayFooter = R"(
Plays a record's voltages [V] through the simulated rig and scores it against the measured displacement [in, mm], from the
record's first position. --calibrate fits keys of [sim] in eha-rig(5) to the record and writes the rig file of the twin,
with null, dead band and gains of its valve in [following].
KEY=LOW:HIGH sets bounds (default a fifth to five times the rig file's value). Each value has a 95 % interval. A parameter
that the record does not determine, alone or apart from another one, is refused by name (exit code 10). Where more than
noise is left the values and [following] are doubtful, and Next: adds a key.

Examples:
  eha replay runs/latest -o overlay.svg
  eha replay record.csv --rig sim.toml --calibrate valve_null_offset_V valve_dead_band_V moving_mass_kg=5:60)";

struct ReplayCommand {
  std::string source;                        ///< run folder or record
  std::optional<std::string> rig_file = {};  ///< none: the run's own where it is simulated, else default_rig_file()
  std::vector<std::string> calibrate = {};   ///< KEY or KEY=LOW:HIGH
  std::optional<std::filesystem::path> twin = {};  ///< written when something is calibrated; none: a new twin.toml
  std::optional<std::filesystem::path> output = {};
};

std::optional<double> number(std::string_view text) {
  double value = 0.0;
  const char* const end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data(), end, value);
  return error == std::errc() && stop == end && std::isfinite(value) ? std::optional(value) : std::nullopt;
}

/// KEY or KEY=LOW:HIGH
replay::CalibrationRequest request_of(const std::string& text) {
  const std::size_t equals = text.find('=');
  if (equals == std::string::npos) return {text, {}};
  const std::string_view range = std::string_view(text).substr(equals + 1);
  const std::size_t colon = range.find(':');
  const auto low = number(range.substr(0, colon));
  const auto high = colon == std::string_view::npos ? std::nullopt : number(range.substr(colon + 1));
  if (!low || !high) {
    throw UsageError(fmt::format("--calibrate {}: expected KEY or KEY=LOW:HIGH with two numbers", text));
  }
  return {text.substr(0, equals), std::pair(*low, *high)};
}

/// The simulated rig that a run was played on, as the run keeps its file; none of a machine's run, and of a file.
std::optional<config::RigConfig> own_rig(const identify::Source& source) {
  if (!source.run_folder) return std::nullopt;
  const nlohmann::ordered_json other = record::read_manifest(*source.run_folder).other;
  const nlohmann::ordered_json::json_pointer text("/rig/text");
  if (!other.contains(text) || !other.at(text).is_string()) return std::nullopt;
  config::RigConfig rig = config::parse_rig(other.at(text).get<std::string>(),
                                            fmt::format("the rig file of {}", source.run_folder->string()));
  if (!std::holds_alternative<hal::SimOptions>(rig.backend)) return std::nullopt;
  return rig;
}

config::RigConfig simulated_rig(const std::optional<std::string>& rig_file, const identify::Source& source) {
  if (!rig_file) {
    if (auto own = own_rig(source)) return *std::move(own);
  }
  config::RigConfig rig = load_rig_or_default(rig_file);
  if (!std::holds_alternative<hal::SimOptions>(rig.backend)) {
    throw UsageError(
        fmt::format("{} drives a machine; a record is replayed on a simulated rig: --rig sim.toml", rig.file_name));
  }
  return rig;
}

void write_csv(const ident::Record& record, const Eigen::VectorXd& measured_in, const Eigen::VectorXd& replayed_in,
               const std::filesystem::path& path) {
  os::AtomicFile file(path);
  std::string text = "time_s,voltage_V,measured_in,replayed_in\n";
  for (Eigen::Index k = 0; k < measured_in.size(); ++k) {
    fmt::format_to(std::back_inserter(text), "{:.12g},{},{},{}\n",
                   record.start_s + record.step_s * static_cast<double>(k), record.input[k], measured_in[k],
                   replayed_in[k]);
    if (text.size() > 60000) {
      file.write(text);
      text.clear();
    }
  }
  file.write(text);
  file.commit();
}

/// @param measured, replayed  in `unit`
void draw_overlay(const ident::Record& record, const Eigen::VectorXd& measured, const Eigen::VectorXd& replayed,
                  const std::string& unit, const std::filesystem::path& path) {
  std::vector<double> time(static_cast<std::size_t>(measured.size()));
  for (std::size_t k = 0; k < time.size(); ++k) time[k] = record.start_s + record.step_s * static_cast<double>(k);
  const auto curve = [&](const std::string& label, const Eigen::VectorXd& values, int style) {
    const std::vector<double> y(values.begin(), values.end());
    const plot::Points points = plot::envelope(time, y);
    return plot::Series{.label = label, .x = points.x, .y = points.y, .style = style};
  };
  plot::Panel position{"", "displacement [" + unit + "]"};
  position.series = {curve("measured", measured, 0), curve("replayed", replayed, 1)};
  plot::Panel error{"time [s]", "error, measured - replayed [" + unit + "]"};
  error.series = {curve("", measured - replayed, 1)};
  const std::string ending = path.extension().string();
  const plot::Format format = ending == ".png"   ? plot::Format::png
                              : ending == ".pdf" ? plot::Format::pdf
                                                 : plot::Format::svg;
  os::write_file_atomically(path, plot::draw({"Record and simulated rig", {position, error}}, format));
}

/// Returns the text of a twin's rig file with null, dead band and gains of its valve in [following]: those of before
/// are of another one, for which no controller of the twin is played. Without [following], or where the new one is not
/// valid, it stays as it is.
std::string with_own_following(const std::string& text, const std::string& file) {
  try {
    const config::RigConfig twin = config::parse_rig(text, file);
    const auto* sim = std::get_if<hal::SimOptions>(&twin.backend);
    if (sim == nullptr || !twin.limits.following) return text;
    config::Following following = tune::following_of(*sim, *twin.limits.following);
    if (!twin.limits.following->measured_check) {  // no sums are written
      following.dead_band_uncertainty_V.reset();
      following.null_uncertainty_V.reset();
      following.gain_uncertainty_percent.reset();
    }
    return rig_text_with(twin, following);
  } catch (const ConfigError&) {
    return text;
  }
}

/// Whether more than noise is left: something that was not calibrated differs.
bool is_doubtful(const replay::Calibration& calibration) {
  return calibration.rms_error_in > replay::kMoreThanNoise * calibration.noise_in;
}

/// Keys that usually differ between rigs and were not calibrated, the first to add first. A key of value 0 has no
/// bounds.
std::vector<std::string> further_keys(const hal::SimOptions& options, const replay::Calibration& calibration) {
  std::vector<std::string> keys;
  for (const char* key :
       {"valve_null_offset_V", "valve_dead_band_V", "valve_rated_flow_L_per_min", "valve_natural_frequency_Hz",
        "moving_mass_kg", "leakage_cm3_per_s_per_bar", "coulomb_friction_N"}) {
    const bool is_calibrated = std::any_of(calibration.parameters.begin(), calibration.parameters.end(),
                                           [&](const auto& p) { return p.key == key; });
    if (!is_calibrated && replay::value_of(options, key) > 0.0) keys.emplace_back(key);
  }
  return keys;
}

/// The next command after a calibration whose error is more than noise.
std::string next_of_doubtful(const ReplayCommand& command, const std::string& twin,
                             const std::vector<std::string>& further) {
  std::string next = "eha replay " + shell_word(command.source);
  if (further.empty()) {
    return fmt::format("{} --rig {} -o {}", next, shell_word(twin), shell_word(free_name("overlay.svg")));
  }
  if (command.rig_file) next += " --rig " + shell_word(*command.rig_file);
  next += " --calibrate";
  for (const std::string& key : command.calibrate) next += " " + shell_word(key);
  return fmt::format("{} {} --twin {}", next, further.front(), shell_word(twin));
}

ExitCode execute(const ReplayCommand& command, Console& console) {
  std::vector<replay::CalibrationRequest> requests;
  for (const std::string& text : command.calibrate) requests.push_back(request_of(text));
  const identify::Source source = identify::load_source(command.source, {}, {}, console.progress_callback());
  console.end_progress();
  const config::RigConfig rig = simulated_rig(command.rig_file, source);
  for (const std::string& warning : identify::warnings(source)) console.warning(warning);
  const ident::Record& record = source.record;
  const Eigen::VectorXd measured = replay::measured_in(record);
  hal::SimOptions options = replay::starting_at(std::get<hal::SimOptions>(rig.backend), measured[0]);

  std::optional<replay::Calibration> calibration;
  if (!requests.empty()) {
    calibration = replay::calibrate(options, requests, record.input, measured, record.step_s,
                                    identify::thread_executor(), [&](double rms_in, int iteration) {
                                      console.progress(std::min(0.95, 0.1 * iteration),
                                                       fmt::format("calibrating, rms error {:.3g} in", rms_in));
                                    });
    console.end_progress();
    options = calibration->options;
  }
  const DisplayUnit unit = console.unit(source.units.empty() ? rig.units : source.units);
  const double factor = unit.factor("in");
  const Eigen::VectorXd replayed = replay::displacement_in(options, record.input, record.step_s);
  const ident::Score score = ident::score(measured, replayed);

  Json document{{"schema", "eha-replay/1"},
                {"source", source.name},
                {"rig", rig.file_name},
                {"samples", score.samples},
                {"r2_percent", score.r2_percent},
                {"fit_percent", score.fit_percent},
                {"rms_error_in", std::sqrt(score.mse)},
                {"error_min_in", score.error_min},
                {"error_max_in", score.error_max}};
  std::string text = fmt::format(
      "{0} on {1} ({8}): R2 {2} %, fit {3} %, rms error {4:.3g} {7}, error {5:.3g} .. {6:.3g} {7}\n", source.name,
      rig.name, ident::percent_text(score.r2_percent), ident::percent_text(score.fit_percent),
      factor * std::sqrt(score.mse), factor * score.error_min, factor * score.error_max, unit.of("in"), rig.file_name);
  std::vector<std::string> further;
  std::string twin_file;
  if (calibration) {
    std::vector<std::vector<std::string>> rows;
    Json parameters = Json::array();
    for (const replay::CalibratedParameter& p : calibration->parameters) {
      rows.push_back(
          {p.key, fmt::format("{:g}", p.before), fmt::format("{:.5g}", p.value), fmt::format("{:.2g}", p.half_width)});
      parameters.push_back({{"key", p.key},
                            {"before", p.before},
                            {"value", p.value},
                            {"std", p.std},
                            {"lower95", p.value - p.half_width},
                            {"upper95", p.value + p.half_width}});
    }
    text += text_table(
        {{"parameter"}, {"before", Align::right}, {"calibrated", Align::right}, {"+- (95 %)", Align::right}}, rows);
    if (!calibration->converged) console.warning("the calibration did not converge; narrow it with KEY=LOW:HIGH");
    if (is_doubtful(*calibration)) {
      further = further_keys(options, *calibration);
      console.warning(fmt::format(
          "the calibrated rig errs by {:.2g} {}, {:.2g} times what noise would leave: something that was not "
          "calibrated differs, too, the values make up for it, and their intervals may miss the truth; {}",
          factor * calibration->rms_error_in, unit.of("in"), calibration->rms_error_in / calibration->noise_in,
          further.empty() ? std::string("of the usual keys none is left to add: look at where it errs")
                          : fmt::format("add keys to it, one at a time (one that the record does not determine is "
                                        "refused by name): {}",
                                        fmt::join(further, ", "))));
    }
    const std::string calibrated = replay::twin_text(rig.text, *calibration, source.name);
    twin_file = command.twin ? command.twin->string() : free_name("twin.toml");
    const std::string twin = with_own_following(calibrated, twin_file);
    os::write_file_atomically(twin_file, twin);
    document["converged"] = calibration->converged;
    document["error_over_noise"] = calibration->rms_error_in / calibration->noise_in;
    document["parameters"] = std::move(parameters);
    document["twin"] = twin_file;
    const std::string_view kept = twin == calibrated          ? ""
                                  : is_doubtful(*calibration) ? ", whose [following] holds these doubtful numbers, too"
                                                              : ", with null, dead band and gains of its valve in "
                                                                "[following]";
    text += fmt::format("written: {}{}\n", twin_file, kept);
  }
  if (command.output) {
    if (command.output->extension() == ".csv") {
      write_csv(record, measured, replayed, *command.output);
    } else {
      draw_overlay(record, factor * measured, factor * replayed, unit.of("in"), *command.output);
    }
    document["file"] = command.output->string();
    text += fmt::format("written: {}\n", command.output->string());
  }
  console.print_json(document);
  console.print(text);
  if (calibration && !calibration->converged) return ExitCode::not_converged;
  if (calibration && is_doubtful(*calibration)) {
    console.next_step(next_of_doubtful(command, twin_file, further));
  } else if (calibration) {
    console.next_step(suggest::run(simulated_access(twin_file), {an_experiment()}));
  } else {
    console.next_step(
        fmt::format("eha replay {} --calibrate valve_null_offset_V valve_dead_band_V", shell_word(command.source)));
  }
  return ExitCode::ok;
}

}  // namespace

void add_replay(CLI::App& app, ParsedLine& line) {
  CLI::App* sub =
      app.add_subcommand("replay", "Play a record's voltages through the simulated rig, or fit the rig to the record");
  sub->footer(kReplayFooter);
  auto& command = options_of<ReplayCommand>(*sub, line);
  takes_run_name(sub->add_option("source", command.source, "Run folder or record"), line)
      ->required()
      ->type_name("RUN|FILE");
  sub->add_option("--rig", command.rig_file, "Rig file of a simulated rig (default the run's, else the shipped one)")
      ->type_name("RIG");
  CLI::Option* calibrate = sub->add_option("--calibrate", command.calibrate, "Fit these keys of [sim]; may be repeated")
                               ->type_name("KEY[=LOW:HIGH]");
  sub->add_option("--twin", command.twin,
                  "Rig file to write the calibrated values to (default twin.toml, or twin-2.toml where that is there)")
      ->type_name("FILE")
      ->needs(calibrate);
  sub->add_option("-o,--output", command.output, "Overlay to write: a picture (.svg, .png, .pdf) or .csv")
      ->type_name("FILE")
      ->check(ends_in({".svg", ".png", ".pdf", ".csv"}));
}

}  // namespace eha::cli
