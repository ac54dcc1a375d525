// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <limits>
#include <span>

#include "daemon/acquisition/earlier_runs.hpp"
#include "daemon/acquisition/limit_monitor.hpp"
#include "hal/rig.hpp"

namespace eha::acquisition {

/// Longest run, in rows: a row's number fits in the record together with the rows before and after the experiment.
inline constexpr std::uint32_t kMostRows = std::numeric_limits<std::int32_t>::max();

/// Gives the requested voltage of each row of a run. The rig's range and slew limit are applied to it afterwards.
/// Real-time safe: every member is noexcept and neither allocates, locks nor logs. Used by the loop's thread only.
class CommandSource {
 public:
  CommandSource() = default;
  CommandSource(const CommandSource&) = delete;
  CommandSource& operator=(const CommandSource&) = delete;
  virtual ~CommandSource() = default;

  /// The run's next action that the source demands.
  enum class Stage {
    preparing,  ///< request row 0 again, until the source's condition holds: the rod in its place
    playing,    ///< play the rows
    over,       ///< end as after the last row
  };
  [[nodiscard]] virtual Stage stage() const noexcept { return Stage::playing; }

  /// Whether a rod beyond a travel limit may be moved inward; see LimitMonitor::allow_way_back(). Fixed during a run.
  [[nodiscard]] virtual bool brings_back() const noexcept { return false; }

  /// Returns the fault that must end the run, or none. Called in each tick of ramp_in and running.
  [[nodiscard]] virtual Breach breach() const noexcept { return {}; }

  /// What placings before left to this one; none is taken where nothing is placed. Before the first row.
  virtual void go_on_from(const LackingWay& /*lacking*/) noexcept {}
  /// What this one leaves; null where nothing is placed.
  [[nodiscard]] virtual const LackingWay* lacking() const noexcept { return nullptr; }

  /// Rows of the run, 1..kMostRows; fixed while it lasts.
  [[nodiscard]] virtual std::uint32_t rows() const noexcept = 0;

  /// Rows of one repetition, at least 1; fixed while the run lasts.
  [[nodiscard]] virtual std::uint32_t rows_per_repetition() const noexcept = 0;

  /// Returns the voltage requested in a row [V]. Called once for each tick, also for a tick that never ran, so that a
  /// source may count its time by calls; for row 0 in every tick of the ramp towards it. A voltage that is not finite
  /// is a fault.
  /// @param row   0..rows()-1, never decreasing
  /// @param last  the last good reading
  [[nodiscard]] virtual double voltage_V(std::uint32_t row, const hal::RigReading& last) noexcept = 0;
};

/// Plays a table of volts, repeated without gaps.
class TableSource final : public CommandSource {
 public:
  /// @param table_V      one repetition, one voltage a tick [V]; must outlive this
  /// @param repetitions  1..65535
  /// @throws ConfigError  an empty table, a voltage that is not finite, or more rows than kMostRows
  TableSource(std::span<const double> table_V, std::uint32_t repetitions);

  [[nodiscard]] std::uint32_t rows() const noexcept override {
    return static_cast<std::uint32_t>(table_V_.size()) * repetitions_;
  }
  [[nodiscard]] std::uint32_t rows_per_repetition() const noexcept override {
    return static_cast<std::uint32_t>(table_V_.size());
  }
  [[nodiscard]] double voltage_V(std::uint32_t row, const hal::RigReading&) noexcept override {
    return table_V_[row % table_V_.size()];
  }

 private:
  std::span<const double> table_V_;
  std::uint32_t repetitions_;
};

}  // namespace eha::acquisition
