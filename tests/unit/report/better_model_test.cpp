// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/report/better_model.hpp"

#include <gtest/gtest.h>

namespace eha::report {
namespace {

TEST(BetterModel, IsTheOneWithTheLessErrorAndSaysByHowMuch) {
  EXPECT_EQ(better_model({{"b", 0.0213, 5}, {"a", 0.000872, 5}}, "in"),
            "use a: rms error 0.000872 in, b 0.0213 in, 24 times as much");
}

TEST(BetterModel, OfModelsWithLikeErrorsIsTheSmallest) {
  EXPECT_EQ(better_model({{"fo", 0.00080, 7}, {"io", 0.00087, 5}, {"lag", 0.002, 4}}, "in"),
            "use io: rms error 0.00087 in with 5 parameters, fo 0.0008 in with 7 parameters: errors within 1.5 times "
            "are alike, and it has the fewest parameters; the next, lag 0.002 in, 2.3 times as much");
}

TEST(BetterModel, IsNoneThatIsRejectedOrOfAnotherPlant) {
  EXPECT_EQ(better_model({{"a", 0.01, 5}, {"fo", 0.001, 5, "rejected"}, {"c", 0.3, 5, "of another plant"}}, "mm"),
            "use a: rms error 0.01 mm; fo (0.001 mm) is rejected; c (0.3 mm) is of another plant");
  EXPECT_EQ(better_model({{"fo", 0.001, 5, "rejected"}}, ""), "use none of them; fo (0.001) is rejected");
}

}  // namespace
}  // namespace eha::report
