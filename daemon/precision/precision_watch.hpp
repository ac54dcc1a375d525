// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "config/experiment_config.hpp"
#include "config/rig_config.hpp"
#include "daemon/play/early_end.hpp"
#include "daemon/worker/worker_process.hpp"

namespace eha::precision {

/// Folder within a run for the model of the rows so far.
inline constexpr const char* kPrecisionFolder = "precision";

/// No run ends before as many repetitions: a gain may be known from one, but its models cannot be judged.
inline constexpr int kLeastRepetitions = 3;

/// Returns half of the 95 % interval of K in the model of a run's rows so far, as a share of K [%]; infinite if the run
/// has no such model, or the model no interval.
/// @throws ConfigError, IoError, PermissionError  as ident::model_from_text, os::read_file
[[nodiscard]] double gain_percent(const std::filesystem::path& run);

/// Fits integrator_lag behind the valve's map to the repetitions so far, in a separate process at the lowest priority
/// and off the loop's CPU. It is reached when the gain is as precise as [precision] requires. A failed fit counts as
/// imprecise. The model is RUN/precision/integrator_lag_valve.json, equal to that of
/// `eha fit RUN --model integrator_lag --input-map valve --split 1 --to SECONDS` after the run.
class PrecisionWatch final : public play::EarlyEnd {
 public:
  /// Receives a sentence about a repetition.
  using Say = std::function<void(const std::string& sentence)>;

  /// @param experiment  with [precision]   @param run  its folder
  /// @throws DeviceError  the programs are not there
  PrecisionWatch(const config::ExperimentConfig& experiment, const config::RigConfig& rig, std::filesystem::path run,
                 Say say);

  void note(int repetitions) override;

 private:
  /// @param message  of the fit's process
  void conclude(const std::string& message);
  void start(int repetitions);

  double wanted_percent_;
  double repetition_s_;
  double row_s_;
  std::optional<int> avoided_cpu_;
  std::filesystem::path run_;
  Say say_;
  worker::WorkerPrograms programs_;
  std::unique_ptr<worker::WorkerProcess> process_;
  int fitted_repetitions_ = 0;
};

/// Returns a watch for an experiment with [precision], else none. @throws DeviceError  as PrecisionWatch
[[nodiscard]] std::unique_ptr<PrecisionWatch> watch_of(const config::ExperimentConfig& experiment,
                                                       const config::RigConfig& rig, const std::filesystem::path& run,
                                                       PrecisionWatch::Say say);

}  // namespace eha::precision
