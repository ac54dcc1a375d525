// SPDX-License-Identifier: GPL-3.0-or-later
#include "ident/validation/nonlinear_effects.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "ident/model/model_output.hpp"
#include "ident/signal/decimation.hpp"
#include "tests/unit/ident/synthetic_record.hpp"

namespace eha::ident {
namespace {

using namespace synthetic;

TEST(NonlinearEffects, OfALongRecordAreThoseOfEachOfItsRows) {
  constexpr Eigen::Index kRows = 1'000'100;  // averaged over blocks
  constexpr std::size_t kEvery = 40;
  const Model plant = fractional(0.3, 2.0, 1.0, 0.8, 1.0);
  Record record;
  record.step_s = 0.001;
  record.input.resize(kRows);
  for (Eigen::Index k = 0; k < kRows; ++k) {
    const double t = static_cast<double>(k) * record.step_s;
    record.input[k] = std::cos(0.2 * t) + 0.7 * std::cos(3.0 * t + 1.0) + 0.5 * std::cos(20.0 * t + 2.0);
  }
  record.output = Eigen::VectorXd::Zero(kRows);
  const Comparison comparison = compare_every(static_cast<std::size_t>(kRows), kEvery, 0);
  OutputOnRecord outputs(record, comparison);
  constexpr std::size_t kFirst = 4;
  const auto effects = nonlinear_effects(plant, outputs, kFirst);
  ASSERT_EQ(effects.front().kind, NonlinearKind::level);

  const Eigen::VectorXd v = record.input.array() - record.input.mean();
  Eigen::VectorXd odd = v.cwiseProduct(v.cwiseAbs());
  odd.array() -= odd.mean();
  const Eigen::VectorXd exact = outputs.response(plant.transfer_function, odd);
  const Eigen::VectorXd compared = exact.tail(exact.size() - static_cast<Eigen::Index>(kFirst));
  EXPECT_LT((effects.front().columns.col(kOddLevel) - compared).norm(), 1e-3 * compared.norm());
}

}  // namespace
}  // namespace eha::ident
