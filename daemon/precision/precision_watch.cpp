// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/precision/precision_watch.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "core/error.hpp"
#include "core/os/files.hpp"
#include "core/program_path.hpp"
#include "ident/model/model_file.hpp"

namespace eha::precision {
namespace {

constexpr const char* kModel = "integrator_lag";
constexpr const char* kModelFile = "integrator_lag_valve.json";
constexpr std::chrono::seconds kPatience{120};

std::filesystem::path program(const char* name) {
  std::filesystem::path path = find_program(name);
  if (path.empty())
    throw DeviceError(fmt::format("{}: not found beside this program; install the whole package", name));
  return path;
}

}  // namespace

double gain_percent(const std::filesystem::path& run) {
  const std::filesystem::path model_file = run / kPrecisionFolder / kModelFile;
  std::error_code ignored;
  if (!std::filesystem::exists(model_file, ignored)) return std::numeric_limits<double>::infinity();
  const ident::Model model = ident::model_from_text(os::read_file(model_file), model_file.string());
  for (const ident::ParameterEstimate& parameter : model.parameters) {
    if (parameter.name != "K") continue;
    const double half = 0.5 * (parameter.upper95 - parameter.lower95);
    if (half > 0.0 && parameter.value != 0.0) return 100.0 * half / std::abs(parameter.value);
  }
  return std::numeric_limits<double>::infinity();
}

PrecisionWatch::PrecisionWatch(const config::ExperimentConfig& experiment, const config::RigConfig& rig,
                               std::filesystem::path run, Say say)
    : wanted_percent_(experiment.played()->precision->gain_percent),
      repetition_s_(experiment.duration_s),
      row_s_(rig.realtime.sample_period_s),
      avoided_cpu_(rig.realtime.cpu),
      run_(std::move(run)),
      say_(std::move(say)),
      programs_{program("eha-worker"), program("eha")} {}

void PrecisionWatch::note(int repetitions) {
  if (is_reached() || judged() == std::numeric_limits<int>::max()) return;
  if (repetitions < kLeastRepetitions) {
    judged_.store(repetitions, std::memory_order_release);  // a run on the virtual clock waits for that
    return;
  }
  try {
    if (process_) {
      const std::optional<worker::WorkerEnd> end = process_->poll();
      if (!end) return;
      process_.reset();
      conclude(end->text);
    }
    if (!is_reached() && repetitions > judged()) start(repetitions);
  } catch (const std::exception& error) {
    process_.reset();
    say_(
        fmt::format("the precision of the rows so far is not known, and every repetition is played: {}", error.what()));
    give_up();
  }
}

void PrecisionWatch::start(int repetitions) {
  fitted_repetitions_ = repetitions;
  std::filesystem::remove(run_ / kPrecisionFolder / kModelFile);  // of fewer repetitions
  // Half a row before the repetition's end: the row at it belongs to the next one.
  const double to_s = repetition_s_ * repetitions - 0.5 * row_s_;
  worker::WorkerLimits limits;
  limits.cpu_time = limits.wall_time = kPatience;
  limits.avoided_cpu = avoided_cpu_;
  process_ = std::make_unique<worker::WorkerProcess>(
      programs_,
      std::vector<std::string>{"fit", run_.string(), "--model", kModel, "--input-map", "valve", "--split", "1", "--to",
                               fmt::format("{:.6f}", to_s), "-o", (run_ / kPrecisionFolder).string(), "--quiet",
                               "--no-progress"},
      limits);
}

void PrecisionWatch::conclude(const std::string& message) {
  const double percent = gain_percent(run_);
  const std::string after =
      fmt::format("after {} repetition{}", fitted_repetitions_, fitted_repetitions_ == 1 ? "" : "s");
  if (std::isfinite(percent)) {
    say_(fmt::format("{} the gain is known to +-{:.2g} %, by {}_valve fitted to them; {:.2g} % are wanted", after,
                     percent, kModel, wanted_percent_));
  } else {
    say_(fmt::format("{} the gain is not known yet{}", after, message.empty() ? "" : ": " + message));
  }
  if (percent <= wanted_percent_) is_reached_.store(true, std::memory_order_release);
  judged_.store(fitted_repetitions_, std::memory_order_release);
}

std::unique_ptr<PrecisionWatch> watch_of(const config::ExperimentConfig& experiment, const config::RigConfig& rig,
                                         const std::filesystem::path& run, PrecisionWatch::Say say) {
  const config::Played* played = experiment.played();
  if (played == nullptr || !played->precision) return nullptr;
  return std::make_unique<PrecisionWatch>(experiment, rig, run, std::move(say));
}

}  // namespace eha::precision
