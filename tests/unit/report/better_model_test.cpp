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

TEST(BetterModel, OfManyNamesTwoBesideIt) {
  EXPECT_EQ(better_model({{"a", 0.010, 5},
                          {"b", 0.011, 6},
                          {"c", 0.012, 6},
                          {"d", 0.013, 6},
                          {"e", 0.014, 6},
                          {"f", 0.1, 5, "rejected"},
                          {"g", 0.2, 5, "rejected"},
                          {"h", 0.3, 5, "rejected"}},
                         "mm"),
            "use a: rms error 0.01 mm with 5 parameters, b 0.011 mm with 6 parameters, c 0.012 mm with 6 parameters, 2 "
            "more: errors within 1.5 times are alike, and it has the fewest parameters; 3 of 8 are not to be used");
}

}  // namespace
}  // namespace eha::report
