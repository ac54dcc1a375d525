// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <complex>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "daemon/record/run_header.hpp"
#include "ident/signal/frequency_response.hpp"
#include "ident/signal/valve_map.hpp"

namespace eha::web {

/// The periods of an experiment and its frequencies.
struct PeriodPlan {
  std::size_t period = 0;        ///< rows; 0: the experiment is not periodic
  bool is_fitted = true;         ///< models are fitted to the run: no move, valve sheet or trial
  std::vector<double> lines_Hz;  ///< excited frequencies; empty: found in the record by the input's spectrum
  std::size_t discard = 0;       ///< rows at the start
  std::size_t rows = 0;          ///< of the whole experiment
  double step_s = 0.0;
  std::optional<ident::ValveMap> valve = {};  ///< of the rig's [following]
  std::size_t thinning = 1;                   ///< interval of the measured rows, after a filter that passes the lines
};

/// @throws DataError, ConfigError  the header's experiment cannot be read
[[nodiscard]] PeriodPlan plan_periods(const record::RunHeader& header, const std::string& source);

/// Frequency response of a run so far.
struct LiveResponse {
  std::size_t rows = 0;     ///< of the experiment, in the journal
  std::size_t periods = 0;  ///< whole ones after the discarded time, 0 or at least 2
  std::vector<ident::LineResponse> lines;
  /// Response of the valve's dead band at each line, V/V; empty if the rig file has no [following].
  std::vector<std::complex<double>> valve;
  std::string refusal;  ///< reason why there is no response, one sentence; empty otherwise
};

/// Measures the response of a run from its journal, which may be growing, with ident::measure_frequency_response.
/// Filters and thins rows by plan.thinning while reading, equally for input and output, which does not change their
/// ratio. Memory: some 100 bytes for each of rows / thinning, at most kMostRows of them.
/// @throws DataError, IoError, PermissionError  the journal cannot be read
/// Cost O(rows).
[[nodiscard]] LiveResponse measure_live_response(const std::filesystem::path& journal, const PeriodPlan& plan);

/// Standard error below which a gain counts as known: its 95 % interval is 1 dB wide on either side [dB].
inline constexpr double kKnownStd_dB = 0.5;
inline constexpr std::size_t kMostRows = 150'000;  ///< measured after thinning

/// The answer to /api/response as text.
/// @param rows  of the experiment so far, as known by now   @param is_over  there will be no more
[[nodiscard]] std::string describe(const std::string& run, const PeriodPlan& plan, const LiveResponse& response,
                                   std::size_t rows, bool is_over = false);

}  // namespace eha::web
