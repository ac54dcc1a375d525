// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/json_text.hpp"

#include <gtest/gtest.h>

#include <string>

using eha::json_shape;
using eha::JsonBounds;
using eha::JsonFault;
using eha::JsonKeys;
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
  EXPECT_TRUE(parse_json_text<json>(nested(JsonBounds{}.depth)).is_array());
  EXPECT_TRUE(parse_json_text<json>(nested(JsonBounds{}.depth + 1)).is_discarded());
  // Walked by recursion it would end the process.
  EXPECT_TRUE(parse_json_text<nlohmann::ordered_json>(nested(3'000'000)).is_discarded());
  EXPECT_TRUE(parse_json_text<json>("{\"deep\": " + nested(3'000'000) + "}").is_discarded());
}

TEST(JsonText, DiscardsADocumentThatItsReadersWouldSearchForMinutes) {
  std::string keys = R"("a":1)";
  for (int i = 0; i < 1000; ++i) keys += ",\"" + std::to_string(i) + "\":1";
  EXPECT_TRUE(parse_json_text<nlohmann::ordered_json>("{" + keys + "}").is_discarded());
  const JsonBounds few{.depth = 3, .values = 4, .keys_of_object = 2};
  EXPECT_EQ(json_shape("[1,2,3]", few).fault, JsonFault::none);
  EXPECT_EQ(json_shape("[1,2,3,4]", few).fault, JsonFault::too_many_values);
  EXPECT_EQ(json_shape(R"({"a":1,"b":1,"c":1})", few).fault, JsonFault::too_many_keys);
  EXPECT_EQ(json_shape(R"([{"a":1},{"a":1}])", few, JsonKeys::unique).fault, JsonFault::too_many_values);
  EXPECT_EQ(json_shape(R"({"a":1,"a":1})", few, JsonKeys::unique).key, "a");
  EXPECT_EQ(json_shape("[1,", few).fault, JsonFault::syntax);
}

TEST(JsonText, ReadsManyEmptyObjectsInTheirOwnTime) {
  // With a callback the library looks through all members of an array after each: quadratic, minutes for these.
  std::string objects = "[{}";
  for (int i = 0; i < 500'000; ++i) objects += ",{}";
  EXPECT_EQ(parse_json_text<json>(objects + "]").size(), 500'001U);
}
