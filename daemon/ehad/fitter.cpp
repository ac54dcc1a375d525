// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/ehad/fitter.hpp"

#include <ctime>
#include <exception>
#include <string_view>
#include <utility>
#include <vector>

#include "daemon/ehad/recovery.hpp"
#include "daemon/record/manifest.hpp"

namespace eha::service {
namespace {

/// Whether an exit code of `eha fit` means that it ran to its end.
bool is_verdict(int exit_code) {
  const auto code = static_cast<ExitCode>(exit_code);
  return code == ExitCode::ok || code == ExitCode::model_rejected || code == ExitCode::not_converged;
}

}  // namespace

std::optional<EntryId> Fitter::entry() const noexcept {
  return process_ ? std::optional<EntryId>(entry_) : std::nullopt;
}

Fitter::Spent Fitter::spent() const noexcept {
  if (!process_) return {};
  Spent spent{.elapsed_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - begun_).count()};
  clockid_t clock{};
  timespec used{};
  if (clock_getcpuclockid(process_->pid(), &clock) == 0 && clock_gettime(clock, &used) == 0) {
    spent.cpu_s = static_cast<double>(used.tv_sec) + 1e-9 * static_cast<double>(used.tv_nsec);
  }
  return spent;
}

pid_t Fitter::start(EntryId entry, const std::filesystem::path& run, const worker::WorkerLimits& limits) {
  process_ = std::make_unique<worker::WorkerProcess>(
      programs_, std::vector<std::string>{"fit", run.string(), "--quiet", "--no-progress"}, limits);
  entry_ = entry;
  begun_ = std::chrono::steady_clock::now();
  return process_->pid();
}

std::optional<EndedFit> Fitter::poll() {
  if (!process_) return std::nullopt;
  std::optional<worker::WorkerEnd> end = process_->poll();
  if (!end) return std::nullopt;
  process_.reset();
  return EndedFit{entry_, std::move(*end)};
}

FitConclusion conclude_fit(const std::filesystem::path& run, const worker::WorkerEnd& end) {
  FitConclusion conclusion;
  conclusion.fitted = end.exit_code && is_verdict(*end.exit_code);
  conclusion.code = end.exit_code ? static_cast<ExitCode>(*end.exit_code) : ExitCode::not_converged;
  if (!conclusion.fitted) {
    // Whoever shows the note says himself that it is an error.
    constexpr std::string_view kPrefix = "eha: error: ";
    conclusion.note = end.text.starts_with(kPrefix) ? end.text.substr(kPrefix.size()) : end.text;
    try {
      record::write_identification(run, {.models = {}, .error = conclusion.note});
    } catch (const std::exception& error) {
      conclusion.manifest_error = error.what();
    }
  }
  conclusion.models = models_of(run);
  return conclusion;
}

}  // namespace eha::service
