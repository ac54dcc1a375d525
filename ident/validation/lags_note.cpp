// SPDX-License-Identifier: GPL-3.0-or-later
#include "ident/validation/lags_note.hpp"

#include <fmt/format.h>

#include <cmath>
#include <cstddef>

#include "ident/model/parameter_text.hpp"
#include "ident/validation/error_cause.hpp"
#include "ident/validation/verdict.hpp"

namespace eha::ident {
namespace {

constexpr double kByChance = 0.05;    // of the lags outside the 99 % bound: five times what noise puts there
constexpr double kByChance95 = 0.20;  // and of the 95 % bound: four times

bool is_outside(const Correlation& correlation, int first_lag) {
  std::size_t lags = 0;
  std::size_t outside = 0;
  std::size_t outside95 = 0;
  for (std::size_t i = 0; i < correlation.lags.size(); ++i) {
    if (correlation.lags[i] < first_lag) continue;
    ++lags;
    outside += std::abs(correlation.values[i]) > correlation.bound99 ? 1 : 0;
    outside95 += std::abs(correlation.values[i]) > correlation.bound95 ? 1 : 0;
  }
  return static_cast<double>(outside) > kByChance * static_cast<double>(lags) ||
         static_cast<double>(outside95) > kByChance95 * static_cast<double>(lags);
}

/// "0.0012 in rms, 0.15 % of the output's standard deviation"
std::string scatter_text(const Model& model) {
  const Score& score = model.validation->score;
  return fmt::format("{} rms, {} % of the output's standard deviation",
                     error_text(std::sqrt(score.mse), model.output_unit), figure_text(100.0 - score.fit_percent));
}

}  // namespace

std::string lags_note(const Model& model, const Verdict& verdict) {
  using Kind = CriterionKind;
  if (!model.validation) return {};
  const bool with_input = is_outside(model.validation->ccf, 0);
  if (!with_input && fails_any(verdict, {Kind::residual_input})) {
    return "No more lags of the correlation with the input are outside their bound than chance puts there, and yet the "
           "test of all lags together finds that the input moves what is left: two tests. A single lag's bound is wide "
           "where the residual is not white; the test of all together allows for that, and gives the verdict.";
  }
  if (!with_input && !is_outside(model.validation->acf, 1)) return {};
  const std::string outside = "Lags outside the bounds: ";
  if (!verdict.accepted) {
    return outside + "the error is more than white noise; why the model is rejected, its reasons say.";
  }
  if (fails_any(verdict, {Kind::residual_input, Kind::nonlinearity, Kind::error_over_noise})) {
    constexpr double kSmall_percent = 5.0;  // of the output's standard deviation
    const bool is_small = 100.0 - model.validation->score.fit_percent <= kSmall_percent;
    return fmt::format(
        "{}the error is more than white noise, {}. They lower the verdict to {} and do not reject it{}: {}.", outside,
        is_rather_nonlinear(model, verdict) ? "as the plant is not linear as the model is"
                                            : "the model lacks a part of the plant",
        text(verdict.grade), is_small ? ", since the error is small" : ", though the error is not small",
        scatter_text(model));
  }
  if (!with_input) {
    return fmt::format(
        "{}what is left, {}, is more than white noise, as a load, hum or drift make it; the input has no part in it.",
        outside, scatter_text(model));
  }
  return fmt::format(
      "{}single lags say little, as neighbours move together; the test of all together, which gives the verdict, finds "
      "no part of the plant in what is left, {}.",
      outside, scatter_text(model));
}

}  // namespace eha::ident
