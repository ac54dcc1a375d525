// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/code_text.hpp"

#include <gtest/gtest.h>

#include <string>

namespace eha {
namespace {

TEST(CodeText, NamesAFunctionSoThatEveryLanguageTakesIt) {
  EXPECT_EQ(identifier("io_valve"), "io_valve");
  EXPECT_EQ(identifier("3 poles"), "model_3_poles");
  EXPECT_EQ(identifier("a-b.c"), "a_b_c");
  EXPECT_EQ(identifier(""), "model_");
  EXPECT_EQ(identifier("for"), "for_model");
  EXPECT_EQ(identifier("Function"), "Function_model");
  EXPECT_EQ(identifier("sections"), "sections_model");
  EXPECT_EQ(identifier(std::string(1000, 'x')).size(), 63U);
  EXPECT_EQ(identifier(std::string(1000, '9')).size(), 63U);
}

TEST(CodeText, KeepsSentencesAndUnitsAsTheyAre) {
  const std::string sentence = "The model's R2 is 41.2 % (limit 60 %); |e| = 3e-4 in/s^2, n2 = 2.1 +- 0.3: [a, b] ~ c";
  EXPECT_EQ(code_text(sentence, 200), sentence);
  EXPECT_EQ(code_text(sentence, 9), "The model...");
}

TEST(CodeText, LetsNoOtherByteThrough) {
  for (int c = 0; c < 256; ++c) {
    const std::string text(3, static_cast<char>(c));
    const std::string kept = code_text(text, 3);
    EXPECT_TRUE(kept == text || kept == "___") << c;
  }
  EXPECT_EQ(code_text("*/ *\\ \"\"\" ?\?/ {@#$`!<>&}\n\t", 40), "_/ __ ___ __/ " + std::string(12, '_'));
}

}  // namespace
}  // namespace eha
