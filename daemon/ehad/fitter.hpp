// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <chrono>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include "core/error.hpp"
#include "daemon/ehad/queue.hpp"
#include "daemon/worker/worker_process.hpp"

namespace eha::service {

/// A worker that has ended.
struct EndedFit {
  EntryId entry = 0;
  worker::WorkerEnd end;
};

/// The identification process and its time-outs; one at a time. Not thread-safe: belongs to the main thread; the
/// process dies when that thread ends.
class Fitter {
 public:
  explicit Fitter(worker::WorkerPrograms programs) : programs_(std::move(programs)) {}

  /// The experiment whose run is being fitted.
  [[nodiscard]] std::optional<EntryId> entry() const noexcept;

  /// Returns the elapsed time of the worker, and its processor time [s]; only while one runs.
  struct Spent {
    double elapsed_s = 0.0;
    double cpu_s = 0.0;
  };
  [[nodiscard]] Spent spent() const noexcept;

  /// Starts `eha fit RUN`. Call only while no worker runs. @returns the process
  /// @throws IoError  the process cannot be started
  pid_t start(EntryId entry, const std::filesystem::path& run, const worker::WorkerLimits& limits);

  /// Returns the worker once it has ended; kills it when it exceeds its time. Call on SIGCHLD and about every second.
  [[nodiscard]] std::optional<EndedFit> poll();

  /// Kills the worker, if there is one.
  void end() noexcept { process_.reset(); }

 private:
  worker::WorkerPrograms programs_;
  EntryId entry_ = 0;
  std::chrono::steady_clock::time_point begun_ = {};
  std::unique_ptr<worker::WorkerProcess> process_;
};

/// Result of an ended worker, for its run and for the queue.
struct FitConclusion {
  bool fitted = false;           ///< `eha fit` ran to its end, whether or not it accepted a model
  ExitCode code = ExitCode::ok;  ///< exit code of `eha run`
  Json models = Json::array();   ///< as in the manifest
  std::string note;              ///< reason for which it was not fitted; empty otherwise
  std::string manifest_error;    ///< reason for which a run without a fit could not be marked; empty otherwise
};

/// Reads a fitted run's models from its manifest, or writes the error into the manifest of a run that was not fitted.
/// Blocks on the disk.
[[nodiscard]] FitConclusion conclude_fit(const std::filesystem::path& run, const worker::WorkerEnd& end);

}  // namespace eha::service
