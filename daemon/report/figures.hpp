// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "daemon/identify/fit_table.hpp"
#include "daemon/plot/figure.hpp"
#include "daemon/record/number_table.hpp"
#include "daemon/report/subject.hpp"
#include "ident/record.hpp"

// The figures of a report, which `eha plot` draws too. Long signals become envelopes of their least and greatest
// values.

namespace eha::report {

inline constexpr std::size_t kMostCurves = 2;                       ///< models in one figure
inline constexpr double kDegrees = 180.0 / 3.14159265358979323846;  ///< of a radian

/// "voltage [V]".
[[nodiscard]] std::string axis_label(const ident::Channel& channel);

/// Input and output over time.
[[nodiscard]] plot::Figure record_figure(const ident::Record& record, const std::string& title);

/// Measured output with the named models, their errors, and the input.
/// @param models   names of columns of the table; those without one are left out
/// @param split_s  where the part begins that did not estimate; a rule is drawn there
[[nodiscard]] plot::Figure fit_figure(const identify::FitTable& table, const std::vector<std::string>& models,
                                      const std::optional<double>& split_s, const std::string& title);

/// Gain and phase of the first models with their 95 % bounds, over the measured response with its 95 % bars, the noise
/// and the distortion; the usable band of the first model shaded. @param response  may be null
[[nodiscard]] plot::Figure bode_figure(const std::vector<const ReportedModel*>& models,
                                       const record::NumberTable* response, const std::string& title);

/// A correlation function as stems, with its 95 % and 99 % bounds.
[[nodiscard]] plot::Panel correlation_panel(const ident::Correlation& correlation, const std::string& y_label);

/// Values of a correlation outside its 99 % bound, at lags from `first_lag` on.
[[nodiscard]] std::size_t outside99(const ident::Correlation& correlation, int first_lag);

/// Poles in the plane of w = s^q with the unstable sector |arg w| <= q pi/2; angles are true, radii logarithmic.
[[nodiscard]] plot::Figure pole_figure(const ident::Model& model);

}  // namespace eha::report
