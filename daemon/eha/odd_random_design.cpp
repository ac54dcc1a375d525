// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/eha/odd_random_design.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string>

#include "config/start_section.hpp"
#include "core/os/files.hpp"
#include "core/shell_word.hpp"
#include "core/toml_text.hpp"
#include "daemon/eha/console.hpp"
#include "daemon/eha/design_command.hpp"
#include "daemon/eha/excitation_room.hpp"
#include "daemon/eha/next_command.hpp"
#include "daemon/eha/rig_source.hpp"
#include "ident/excitation/excitation.hpp"

namespace eha::cli {
namespace {

constexpr int kPeriodsOfEach = ident::OddRandomMultisine::kFewestPeriods;

/// Peaks of an excitation of 1 V.
struct UnitPeaks {
  double slew_per_s = 0.0;
  double travel_in_per_V = 0.0;  ///< of a rod that integrates, about its middle
  double rms = 0.0;
};

UnitPeaks peaks_of(const Eigen::VectorXd& table, double step_s, double gain_in_per_V_s) {
  UnitPeaks peaks;
  const Eigen::Index rest = table.size() - 1;
  peaks.slew_per_s = (table.tail(rest) - table.head(rest)).cwiseAbs().maxCoeff() / step_s;
  peaks.rms = std::sqrt(table.squaredNorm() / static_cast<double>(table.size()));
  const double mean = table.mean();
  double place = 0.0;
  double lowest = 0.0;
  double highest = 0.0;
  for (const double volts : table) {
    place += gain_in_per_V_s * step_s * (volts - mean);
    lowest = std::min(lowest, place);
    highest = std::max(highest, place);
  }
  peaks.travel_in_per_V = 0.5 * (highest - lowest);
  return peaks;
}

}  // namespace

ExitCode design_odd_random(const DesignCommand& command, Console& console) {
  struct Limit {
    const char* name;
    double amplitude_V;
  };
  const config::RigConfig rig = load_rig_or_default(command.rig_file);
  const ExcitationRoom room = excitation_room(rig);
  const DisplayUnit unit_of_rig = console.unit(rig.units);
  const auto [low_Hz, high_Hz] = *command.band;
  const int realisations = *command.realisations;
  const double step_s = rig.realtime.sample_period_s;
  const auto period = static_cast<std::size_t>(std::llround(command.period_s / step_s));
  const double period_s = static_cast<double>(period) * step_s;
  const std::size_t samples = period * static_cast<std::size_t>(realisations) * kPeriodsOfEach;
  const ident::Excitation unit{
      .kind = ident::OddRandomMultisine{
          .amplitude_V = 1.0, .band = {low_Hz, high_Hz}, .realisations = realisations, .periods = kPeriodsOfEach}};
  const Eigen::VectorXd table = ident::excitation(unit, step_s, samples);
  const UnitPeaks peaks = peaks_of(table, step_s, room.gain_in_per_V_s);
  const std::array limits{Limit{"voltage", room.peak_V}, Limit{"slew", room.slew_V_per_s / peaks.slew_per_s},
                          Limit{"travel", room.travel_in / peaks.travel_in_per_V}};
  const Limit binding = *std::min_element(limits.begin(), limits.end(),
                                          [](const Limit& a, const Limit& b) { return a.amplitude_V < b.amplitude_V; });
  const double amplitude_V = std::floor(binding.amplitude_V * 1e4) / 1e4;
  const std::vector<double> lines_Hz = ident::excited_lines(unit, step_s, samples);
  const std::string remark = fmt::format(
      "{} odd lines, {:.6g} to {:.6g} Hz (one in four is drawn to stay silent, which shows distortion), {} "
      "realisations "
      "of {} periods, peak {:.3g} V, +-{:.3g} {}; the {} limit binds",
      lines_Hz.size(), lines_Hz.front(), lines_Hz.back(), realisations, kPeriodsOfEach, amplitude_V,
      unit_of_rig.factor("in") * amplitude_V * peaks.travel_in_per_V, unit_of_rig.of("in"), binding.name);
  const std::filesystem::path file = command.output.value_or("band.toml");
  const int decimation = compared_ticks(lines_Hz.back(), step_s);
  const std::string text = fmt::format(
      "# Made by `eha design --band {0:g}:{1:g} --period {2:g} --odd-random --realisations {3}` for \"{4}\".\n"
      "# {5}\n"
      "schema = 1\nname = \"odd-random\"\nduration_s = {6:.3f}\n\n{7}\n\n[hold]\n\n"
      "[excitation]\nkind = \"odd_random_multisine\"\noffset_V = {8:.3f}\namplitude_V = {9:.4f}\n"
      "frequency_min_Hz = {0:.6f}\nfrequency_max_Hz = {1:.6f}\nrealisations = {3}\nperiods = {10}\n\n"
      "[record]\ndiscard_s = {2:.3f}\ndecimation = {11}\n",
      low_Hz, high_Hz, period_s, realisations, toml_comment(rig.name), remark, static_cast<double>(samples) * step_s,
      config::start_at_middle(rig), room.null_V, amplitude_V, kPeriodsOfEach, decimation);
  os::write_file_atomically(file, text);
  const double rms_V = amplitude_V * peaks.rms;
  console.print(remark);
  warn_of_dead_band(rms_V, room, console);
  console.print_json({{"schema", "eha-design/1"},
                      {"file", file.string()},
                      {"lines", lines_Hz.size()},
                      {"realisations", realisations},
                      {"periods", kPeriodsOfEach},
                      {"duration_s", static_cast<double>(samples) * step_s},
                      {"amplitude_V", amplitude_V},
                      {"rms_V", rms_V},
                      {"binding", binding.name}});
  console.print(written_for(file, command, rig));
  console.next_step(suggest::run(access_of_design(command, rig), {file.string()}));
  return ExitCode::ok;
}

}  // namespace eha::cli
