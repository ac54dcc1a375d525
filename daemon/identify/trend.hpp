// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
#include <string>

#include "daemon/identify/identification.hpp"

namespace eha::identify {

/// The straight line that is left beside a plant: the drift of a sensor, or of what the plant rests on.
struct Trend {
  double per_s = 0.0;       ///< [output unit/s]
  double half_width = 0.0;  ///< of its 95 % interval
};

/// Finds the line beside a plant of two poles: fits the line, then that plant and the line in turn until the line
/// stays. Its interval is that of the line alone, by what is left over, whitened.
/// @returns none where the record does not show one: its interval holds half of it, or the plant cannot be fitted
/// Cost: some five local fits of one structure.
[[nodiscard]] std::optional<Trend> trend_of(const IdentificationTask& task);

/// Takes the straight line out of a record's output where one shows and a plant of two poles errs clearly less without
/// it, and does not integrate over the record: such a plant makes the line of a constant input.
/// @returns that it was taken out, for the user; empty: none was
/// Cost: trend_of() and two fits of that plant.
[[nodiscard]] std::string take_trend_out(Source& source);

/// A record without its trend, and what is identified from it.
struct WithoutTrend {
  ident::Record record;
  std::string trend;     ///< for IdentificationTask::trend
  std::string sentence;  ///< for the user
  Identification identification;
};

/// Fits again to the output less its trend where a drift keeps every model from being recommended, or the recommended
/// one errs more on unseen data or leaves a drift over; then that fit has to err clearly less there.
/// @returns none where that fit recommends no model either, one that takes in a drift, or one that integrates over the
///          record: such a plant makes the line of a constant input
/// Cost: none without such a drift, else trend_of() and the same fit once more.
[[nodiscard]] std::optional<WithoutTrend> without_trend(const IdentificationTask& task,
                                                        const Identification& identification, const FitTask& fit);

}  // namespace eha::identify
