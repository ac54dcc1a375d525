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

/// Of a fit's table alone: the two models of least error. The title says so.
[[nodiscard]] plot::Figure fit_table_figure(const identify::FitTable& table, const std::string& title);

/// The same with each value held until the next, as an input is played.
[[nodiscard]] plot::Series held(const plot::Series& series);

/// Gain and phase of the first models with their 95 % bounds, over the measured response with its 95 % bars, the noise
/// and the distortion; the usable band of the first model shaded. Bars are small beside three decades of gain: below,
/// the measured gain over that of the first model has a scale of its own. @param response  may be null
[[nodiscard]] plot::Figure bode_figure(const std::vector<const ReportedModel*>& models,
                                       const record::NumberTable* response, const std::string& title);

/// The measured response of frequency_response.csv alone, with the two models of its columns that are nearest.
/// @param unit  of the gain, "in/V"; empty: not known
[[nodiscard]] plot::Figure response_figure(const record::NumberTable& response, const std::string& unit,
                                           const std::string& title);

/// Output and speed after a step of one input unit behind the valve, long enough for the lags that the usable band
/// reaches. What is faster than the band is shaded. @param models  at least one
/// @throws ConfigError  a transfer function cannot be simulated. Cost O(N^2) for unstable models, N = 400
[[nodiscard]] plot::Figure step_figure(const std::vector<const ident::Model*>& models, const std::string& title);

/// "a step of 1 V behind the valve", or "at the input" of a model without a valve.
[[nodiscard]] std::string step_text(const ident::Model& model);
/// One sentence of the first model's step in step_figure(): its final speed or value, and when 63 % are reached.
[[nodiscard]] std::string step_sentence(const ident::Model& model);

/// The static maps of the models that have one, over the inputs from low to high, beside a valve without a dead band;
/// dead band and null of the last one are marked.
[[nodiscard]] plot::Panel valve_panel(const std::vector<const ident::Model*>& models, double low, double high);

/// A correlation function as stems, with its 95 % and 99 % bounds.
[[nodiscard]] plot::Panel correlation_panel(const ident::Correlation& correlation, const std::string& y_label);

/// Values of a correlation outside its 99 % bound, at lags from `first_lag` on.
[[nodiscard]] std::size_t outside99(const ident::Correlation& correlation, int first_lag);

/// Poles in the plane of w = s^q with the unstable sector |arg w| <= q pi/2; angles are true, radii logarithmic and
/// given as natural frequencies |w|^(1/q) / 2 pi [Hz]. Beside a pole stand f0 and damping, or the time constant.
[[nodiscard]] plot::Figure pole_figure(const ident::Model& model);

}  // namespace eha::report
