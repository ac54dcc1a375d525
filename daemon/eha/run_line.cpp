// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/eha/run_line.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <ctime>

#include "config/characterisation.hpp"
#include "daemon/eha/rod_text.hpp"

namespace eha::cli {
namespace {

using Json = nlohmann::ordered_json;

constexpr int kBarWidth = 13;
/// A shorter way to the start is not mentioned.
constexpr double kShown_s = 1.0;
constexpr std::uint64_t kFewestLost = 50;  // ticks

double number_in(const Json& object, const char* key) {
  const auto found = object.find(key);
  return found != object.end() && found->is_number() ? found->get<double>() : 0.0;
}

std::string clock_text(std::chrono::system_clock::time_point when) {
  const std::time_t seconds = std::chrono::system_clock::to_time_t(when);
  std::tm local{};
  localtime_r(&seconds, &local);
  return fmt::format("{:02}:{:02}:{:02}", local.tm_hour, local.tm_min, local.tm_sec);
}

}  // namespace

std::string duration_text(double seconds) {
  if (seconds < 99.95) return fmt::format("{:.1f} s", seconds);
  const auto whole = static_cast<std::int64_t>(std::llround(seconds));
  if (whole < 3600) return fmt::format("{}:{:02} min", whole / 60, whole % 60);
  return fmt::format("{}:{:02} h", whole / 3600, whole / 60 % 60);
}

RunProgress progress_of(const acquisition::Snapshot& now, const config::RigConfig& rig) {
  const double step_s = rig.realtime.sample_period_s;
  return {.played_s = now.experiment_row * step_s,
          .total_s = now.experiment_rows * step_s,
          .elapsed_s = static_cast<double>(now.elapsed_ns) * 1e-9,
          .displacement_in = now.displacement_in,
          .applied_V = now.applied_V,
          .travel_min_in = rig.limits.travel_min_in,
          .travel_max_in = rig.limits.travel_max_in,
          .travel_percent = 100.0 * now.travel_share,
          .velocity_percent = 100.0 * now.velocity_share,
          .latency_max_us = static_cast<double>(now.latency_max_ns) * 1e-3,
          .late = now.counters.late,
          .skipped = now.counters.skipped,
          .lost_percent = acquisition::lost_percent(now)};
}

RunProgress progress_of(const Json& status) {
  const Json& run = status.at("run");
  RunProgress progress{.played_s = number_in(run, "experiment_s"),
                       .total_s = number_in(run, "experiment_total_s"),
                       .elapsed_s = number_in(run, "elapsed_s"),
                       .displacement_in = number_in(run, "displacement_in"),
                       .applied_V = number_in(run, "applied_V"),
                       .travel_percent = number_in(run, "travel_percent"),
                       .velocity_percent = number_in(run, "velocity_percent"),
                       .latency_max_us = number_in(run, "latency_max_us"),
                       .late = run.value("late", std::uint64_t{0}),
                       .skipped = run.value("skipped", std::uint64_t{0}),
                       .lost_percent = number_in(run, "lost_percent"),
                       .is_real_time = !run.value("fast", false),
                       .exploring_at_most_s = number_in(run, "exploring_at_most_s"),
                       .is_placing = run.value("only_places", false)};
  if (const Json rod = status.value("rod", Json()); rod.is_object()) {
    progress.travel_min_in = number_in(rod, "travel_min_in");
    progress.travel_max_in = number_in(rod, "travel_max_in");
    if (const Json found = run.value("rehearsal", Json()); found.is_object()) {
      progress.margin_in = std::min(number_in(found, "lowest_in") - progress.travel_min_in,
                                    progress.travel_max_in - number_in(found, "highest_in"));
    }
  }
  return progress;
}

std::string run_line(const RunProgress& progress, const DisplayUnit& unit, std::chrono::system_clock::time_point now) {
  // Nothing is known before the first tick.
  if (!(progress.total_s > 0.0)) return "about to begin";
  const double factor = unit.factor("in");
  const std::string length = unit.of("in");
  std::string line;
  if (progress.travel_percent > 100.0 * acquisition::kWarningShare) {
    line += fmt::format("NEAR A LIMIT: {:.0f} % of travel  ", progress.travel_percent);
  }
  if (progress.velocity_percent > 100.0 * acquisition::kWarningShare) {
    line += fmt::format("NEAR A LIMIT: {:.0f} % of velocity  ", progress.velocity_percent);
  }
  // Of the first rows one is much.
  if (!progress.is_placing && progress.skipped >= kFewestLost && progress.lost_percent > config::kMostLostRows_percent)
    line += fmt::format("ROWS LOST: {:.2g} % so far  ", progress.lost_percent);
  const double left_s = std::max(0.0, progress.total_s - progress.played_s);
  if (progress.exploring_at_most_s > 0.0) {
    const double most_s = std::max(0.0, progress.exploring_at_most_s - progress.elapsed_s);
    line += fmt::format("exploring, {} at most, then {}", duration_text(most_s), duration_text(left_s));
  } else if (!progress.is_placing && progress.played_s <= 0.0 && progress.elapsed_s >= kShown_s) {
    line += fmt::format("preparing for {}, then {}", duration_text(progress.elapsed_s), duration_text(left_s));
  } else {
    line += duration_text(left_s) + (progress.is_placing ? " at most" : " left");
  }
  if (progress.is_real_time && !progress.is_placing && progress.played_s > 0.0) {
    const auto left = std::chrono::duration_cast<std::chrono::system_clock::duration>(
        std::chrono::duration<double>(std::ceil(left_s)));
    line += ", end " + clock_text(now + left);
  }
  line += fmt::format("  {:.3f} {}", factor * progress.displacement_in, length);
  if (progress.margin_in) line += fmt::format(", margin {:.2f} {}", factor * *progress.margin_in, length);
  line += fmt::format("  {:+.2f} V", progress.applied_V);
  if (progress.travel_max_in > progress.travel_min_in) {
    line += "  " + short_bar(progress.displacement_in, progress.travel_min_in, progress.travel_max_in, kBarWidth);
  }
  // Last: a narrow terminal cuts the counters of ticks, not the rod. The report of the run has them whole.
  line += fmt::format("  {} late", progress.late);
  if (progress.skipped > 0) line += fmt::format(", {} skipped", progress.skipped);
  return line;
}

std::string loop_line(const RunProgress& progress) {
  return fmt::format("latency at most {:.0f} us, {} late, {} skipped", progress.latency_max_us, progress.late,
                     progress.skipped);
}

}  // namespace eha::cli
