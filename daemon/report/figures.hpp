// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <utility>
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

/// Draws input and output over time.
[[nodiscard]] plot::Figure record_figure(const ident::Record& record, const std::string& title);

/// Draws the measured output with the named models, their errors on one scale, each in a panel of its own, as a dense
/// curve would hide the other one, and the input.
/// @param models   names of columns of the table; those without a column are left out
/// @param split_s  end of the estimating part, marked by a rule
[[nodiscard]] plot::Figure fit_figure(const identify::FitTable& table, const std::vector<std::string>& models,
                                      const std::optional<double>& split_s, const std::string& title);

/// Draws a trial of a controller that ended early: rod and reference, the error and the command, as read.
/// @param rows  the rod as measured, and the one column "reference"
[[nodiscard]] plot::Figure ended_trial_figure(const identify::FitTable& rows, const std::string& title);

/// Draws a fit's table alone: the two models of least error. The title says so.
[[nodiscard]] plot::Figure fit_table_figure(const identify::FitTable& table, const std::string& title);

/// The same with each value held until the next, as an input is played.
[[nodiscard]] plot::Series held(const plot::Series& series);

/// Draws gain and phase of the first models with their 95 % bounds, over the measured response with its 95 % bars, the
/// noise and the distortion; shades the usable band of the first model, and draws lines beyond it faint. Because the
/// bars are small beside three decades of gain, a panel below has the measured gain over that of the first model. Of a
/// first model behind a valve's map its response with the map is drawn at the lines, too, and compared with the
/// measured one: the map passes less than G.
/// @param response  may be null   @param fit  rows whose input the map is linearised for; null: G alone is drawn
[[nodiscard]] plot::Figure bode_figure(const std::vector<const ReportedModel*>& models,
                                       const record::NumberTable* response, const std::string& title,
                                       const identify::FitTable* fit = nullptr);

/// Gain and phase of a model at the lines of a measured response, with its valve's map where it has one and `fit` shows
/// the input; without what bode_figure() needs for it, of G.
[[nodiscard]] ident::BodeCurve curve_at_lines(const ident::Model& model, const record::NumberTable& response,
                                              const identify::FitTable* fit);

/// Whether curve_at_lines() includes the map.
[[nodiscard]] bool shows_map(const ident::Model& model, const record::NumberTable* response,
                             const identify::FitTable* fit);

/// Draws the measured response of frequency_response.csv alone, with the two nearest models of its columns.
/// @param unit  of the gain, "in/V"; empty: not known
[[nodiscard]] plot::Figure response_figure(const record::NumberTable& response, const std::string& unit,
                                           const std::string& title);

/// Draws output and speed after a step of one input unit behind the valve, long enough for the lags within the usable
/// band. Hatches the times that are faster than the band. @param models  at least one
/// @throws ConfigError  a transfer function cannot be simulated. Cost O(N^2) for unstable models, N = 400
[[nodiscard]] plot::Figure step_figure(const std::vector<const ident::Model*>& models, const std::string& title);

/// "a step of 1 V behind the valve", or "at the input" of a model without a valve.
[[nodiscard]] std::string step_text(const ident::Model& model);
/// Describes the first model's step of step_figure() in one sentence: its final speed or value, and the time at which
/// 63 % are reached.
[[nodiscard]] std::string step_sentence(const ident::Model& model);

/// Draws the static maps of the models that have one, over the inputs from low to high, beside a valve without a dead
/// band; marks dead band and null of the last one.
[[nodiscard]] plot::Panel valve_panel(const std::vector<const ident::Model*>& models, double low, double high);

/// Marks where a fault ended the run, and goes on a little beyond it.
/// @param trip_s  on the time axis of the figure
void mark_trip(plot::Figure& figure, double trip_s);

/// Says at the time axis of a run's fit_figure() that its first rows, in which the rod settles, are left out.
void name_left_out(const Subject& subject, plot::Figure& figure);

/// Adds the rig's travel limits that lie near what was measured to the panel of the output.
/// @param span_s  first and last time of the panel   @param unit  of the panel
void draw_limits(const Subject& subject, std::pair<double, double> span_s, std::span<const double> measured,
                 const std::string& unit, plot::Panel& output);

/// Adds the rows of a record behind the last one of a fit_figure(), which a decimation leaves out.
void add_rest(plot::Figure& figure, const identify::FitTable& table, const ident::Record& record);

/// Draws a correlation function as stems, with its 95 % and 99 % bounds.
[[nodiscard]] plot::Panel correlation_panel(const ident::Correlation& correlation, const std::string& y_label);

/// Counts the values of a correlation outside its 99 % bound, at lags from `first_lag` on.
[[nodiscard]] std::size_t outside99(const ident::Correlation& correlation, int first_lag);

/// Draws the poles in the plane of w = s^q with the unstable sector |arg w| <= q pi/2; angles are true, radii
/// logarithmic and given as natural frequencies |w|^(1/q) / 2 pi [Hz]. A pole is labelled with f0 and damping, or with
/// the time constant.
[[nodiscard]] plot::Figure pole_figure(const ident::Model& model);

}  // namespace eha::report
