// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/json_text.hpp"

#include <gtest/gtest.h>

#include <string>

using eha::kDeepestJson;
using eha::parse_json_text;
using nlohmann::json;

namespace {

std::string nested(int levels) {
  const auto count = static_cast<std::size_t>(levels);
  return std::string(count, '[') + std::string(count, ']');
}

}  // namespace

TEST(JsonText, ReadsADocument) { EXPECT_EQ(parse_json_text<json>(R"({"a": [1, {"b": null}]})")["a"][0], 1); }

TEST(JsonText, DiscardsWhatIsNoJson) {
  for (const char* text : {"", "{", "{\"a\": 1} x", "nan"}) {
    EXPECT_TRUE(parse_json_text<json>(text).is_discarded()) << text;
  }
}

TEST(JsonText, DiscardsADocumentThatNestsTooDeeply) {
  EXPECT_TRUE(parse_json_text<json>(nested(kDeepestJson)).is_array());
  EXPECT_TRUE(parse_json_text<json>(nested(kDeepestJson + 2)).is_discarded());
  // Walked by recursion it would end the process.
  EXPECT_TRUE(parse_json_text<nlohmann::ordered_json>(nested(3'000'000)).is_discarded());
  EXPECT_TRUE(parse_json_text<json>("{\"deep\": " + nested(3'000'000) + "}").is_discarded());
}
