// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/identify/standing_output.hpp"

#include <fmt/format.h>

#include <set>

#include "ident/model/parameter_text.hpp"
#include "ident/signal/kept_values.hpp"

namespace eha::identify {
namespace {

constexpr double kStandingShare = 0.9;  // of the rows
constexpr std::size_t kFewValues = 10;

}  // namespace

std::optional<StandingOutput> standing_output(const ident::Record& record) {
  const Eigen::VectorXd& y = record.output;
  if (y.size() == 0) return std::nullopt;
  const double least = y.minCoeff();
  const double greatest = y.maxCoeff();
  std::set<double> values;
  Eigen::Index moving = 0;
  for (const double place : y) {
    if (values.size() <= kFewValues) values.insert(place);
    if (!ident::is_same_value(place, least) && !ident::is_same_value(place, greatest)) ++moving;
  }
  const auto rows = static_cast<double>(y.size());
  if (values.size() > kFewValues || static_cast<double>(moving) > (1.0 - kStandingShare) * rows) return std::nullopt;
  const double moving_s = static_cast<double>(moving) * record.step_s;
  const double enough_s = (1.0 - kStandingShare) * rows * record.step_s;
  return StandingOutput{
      fmt::format("the output stands at {:.6g} or {:.6g}{} for all but {:.3g} s of the record, with {} values in all: "
                  "any model follows that, with any gain; record several motions of many steps of the sensor",
                  least, greatest, ident::after_number(record.output_channel.unit), moving_s, values.size()),
      {.length_s = moving_s, .enough_s = enough_s, .is_too_little = true}};
}

}  // namespace eha::identify
