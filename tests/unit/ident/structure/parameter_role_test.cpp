// SPDX-License-Identifier: GPL-3.0-or-later
#include "ident/structure/parameter_role.hpp"

#include <gtest/gtest.h>

#include <vector>

namespace eha::ident {
namespace {

TEST(ParameterKeys, ComeBackFromTheirNames) {
  const std::vector<ParameterKey> beside_one = {
      coefficient_key(10),  order_key(2),     numerator_key(0, 1), numerator_order_key(0, 1), base_order_key(),
      delay_key(),          input_bias_key(), valve_null_key(),    dead_band_key(),           negative_gain_ratio_key(),
      initial_output_key(), state_key(3),     past_input_key(7)};
  for (const ParameterKey& key : beside_one) {
    const ParameterKey read = key_of(key.name, 1);
    EXPECT_EQ(read.role, key.role) << key.name;
    EXPECT_EQ(read.index, key.index) << key.name;
  }
  for (const ParameterKey& key : {numerator_key(1, 3), numerator_order_key(2, 3)}) {
    EXPECT_EQ(key_of(key.name, 3).role, key.role) << key.name;
    EXPECT_EQ(key_of(key.name, 3).index, key.index) << key.name;
  }
}

TEST(ParameterKeys, CallBZeroAnOrderBesideOneNumeratorTermOnly) {
  EXPECT_EQ(key_of("b0", 1).role, ParameterRole::numerator_order);
  EXPECT_EQ(key_of("b0", 2).role, ParameterRole::numerator_coefficient);
}

TEST(ParameterKeys, TakeAnUnknownNameForACoefficient) {
  for (const char* name : {"", "n", "nx", "n-1", "n2 ", "nul"}) {
    EXPECT_EQ(key_of(name, 1).role, ParameterRole::denominator_coefficient) << name;
  }
}

}  // namespace
}  // namespace eha::ident
