// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/control/protocol.hpp"

#include <gtest/gtest.h>

#include <string>
#include <variant>

namespace eha::control {
namespace {

template <typename T>
T call_of(const std::string& line) {
  const auto parsed = parse_request(line);
  if (const auto* refusal = std::get_if<Refusal>(&parsed)) {
    ADD_FAILURE() << line << ": " << refusal->message;
    return {};
  }
  return std::get<T>(std::get<Request>(parsed).call);
}

Refusal refusal_of(const std::string& line) {
  const auto parsed = parse_request(line);
  if (const auto* refusal = std::get_if<Refusal>(&parsed)) return *refusal;
  ADD_FAILURE() << line << " is accepted";
  return {};
}

TEST(Protocol, ReadsEachMethodWithItsParameters) {
  call_of<StatusCall>(R"({"id":0,"method":"status"})");
  EXPECT_EQ(call_of<ArmCall>(R"({"id":1,"method":"arm","params":{}})").ruler_in, std::nullopt);
  EXPECT_EQ(call_of<ArmCall>(R"({"id":1,"method":"arm","params":{"ruler_in":2.9}})").ruler_in, 2.9);
  EXPECT_EQ(call_of<ArmCall>(R"({"id":1,"method":"arm","params":{"take_from":65534}})").take_from, 65534);
  EXPECT_EQ(call_of<StopCall>(R"({"id":1,"method":"stop"})").entry, std::nullopt);
  EXPECT_EQ(call_of<StopCall>(R"({"id":1,"method":"stop","params":{"entry":3}})").entry, 3);
  EXPECT_EQ(call_of<StopCall>(R"({"id":1,"method":"stop","params":{"entry":3,"signal":15}})").signal, 15);
  EXPECT_EQ(call_of<ReleaseCall>(R"({"id":1,"method":"release"})").entry, std::nullopt);
  EXPECT_EQ(call_of<ReleaseCall>(R"({"id":1,"method":"release","params":{"entry":3}})").entry, 3);
  EXPECT_EQ(call_of<CancelCall>(R"({"id":1,"method":"cancel","params":{"entry":9}})").entry, 9);
  EXPECT_EQ(call_of<WatchCall>(R"({"id":1,"method":"watch","params":{"rate_Hz":25}})").rate_Hz, 25.0);
  EXPECT_FALSE(call_of<WatchCall>(R"({"id":1,"method":"watch"})").samples);
  EXPECT_TRUE(call_of<WatchCall>(R"({"id":1,"method":"watch","params":{"samples":true}})").samples);
  const auto submit =
      call_of<SubmitCall>(R"({"id":1,"method":"submit","params":{"experiment":"a\nb","name":"\u00e4\n","fast":true}})");
  ASSERT_EQ(submit.experiments.size(), 1U);
  EXPECT_EQ(submit.experiments[0].text, "a\nb");
  EXPECT_EQ(submit.experiments[0].name, "???");  // for logs and messages: printable only
  EXPECT_TRUE(submit.fast);
  EXPECT_FALSE(submit.is_list);
  EXPECT_FALSE(submit.detach);
  EXPECT_TRUE(call_of<SubmitCall>(R"({"id":1,"method":"submit","params":{"experiment":"a","detach":true}})").detach);
  EXPECT_FALSE(call_of<QueueCall>(R"({"id":1,"method":"queue"})").over);
  EXPECT_EQ(call_of<QueueCall>(R"({"id":1,"method":"queue","params":{"over":0}})").over, 0);
  EXPECT_EQ(call_of<HoldCall>(R"({"id":1,"method":"hold","params":{"entry":4}})").entry, 4);
  const auto move = call_of<MoveCall>(R"({"id":1,"method":"move","params":{"entry":4,"by":-1}})");
  EXPECT_EQ(move.entry, 4);
  EXPECT_EQ(move.by, -1);
}

TEST(Protocol, ReadsSeveralExperimentsOfOneSubmission) {
  const auto submit = call_of<SubmitCall>(
      R"({"id":1,"method":"submit","params":{"experiments":[{"experiment":"a","name":"a.toml"},{"experiment":"b"}]}})");
  ASSERT_EQ(submit.experiments.size(), 2U);
  EXPECT_TRUE(submit.is_list);
  EXPECT_EQ(submit.experiments[0].name, "a.toml");
  EXPECT_EQ(submit.experiments[1].text, "b");
  const auto refused = [](const std::string& list) {
    return refusal_of(R"({"id":1,"method":"submit","params":{"experiments":)" + list + "}}").message;
  };
  EXPECT_NE(refused("[]").find("1 to 20"), std::string::npos);
  EXPECT_NE(refused("[1]").find("params.experiments[0]"), std::string::npos);
  EXPECT_NE(refused(R"([{"experiment":"a"},{"nam":"b"}])").find("params.experiments[1].experiment"), std::string::npos);
  EXPECT_NE(refused(R"([{"experiment":"a","nam":"b"}])").find("did you mean \"name\""), std::string::npos);
}

TEST(Protocol, RefusesWhatItDoesNotKnowAndNamesTheNearest) {
  EXPECT_NE(refusal_of(R"({"id":1,"method":"statu"})").message.find("did you mean \"status\""), std::string::npos);
  EXPECT_NE(refusal_of(R"({"id":1,"method":"cancel","params":{"entri":1}})").message.find("params.entry"),
            std::string::npos);
  EXPECT_NE(refusal_of(R"({"id":1,"method":"watch","params":{"rate_hz":1}})").message.find("rate_Hz"),
            std::string::npos);
  EXPECT_NE(refusal_of(R"({"id":1,"method":"disarm","params":{"uid":0}})").message.find("takes no parameters"),
            std::string::npos);
  EXPECT_NE(refusal_of(R"({"id":1,"method":"arm","uid":0})").message.find("uid"), std::string::npos);
}

TEST(Protocol, RefusesAKeyThatIsThereTwice) {
  EXPECT_NE(refusal_of(R"({"id":1,"method":"status","method":"stop"})").message.find("method: the key is there twice"),
            std::string::npos);
  EXPECT_NE(refusal_of(R"({"id":1,"method":"cancel","params":{"entry":1,"entry":2}})").message.find("entry"),
            std::string::npos);
  // Equal keys of different objects are not the same key.
  EXPECT_EQ(call_of<CancelCall>(R"({"id":1,"params":{"entry":9},"method":"cancel"})").entry, 9);
}

TEST(Protocol, KeepsTheIdOfARequestThatItRefuses) {
  EXPECT_EQ(refusal_of(R"({"id":7,"method":"no"})").id, 7);
  EXPECT_EQ(refusal_of(R"({"id":"7","method":"arm"})").id, nullptr);
  EXPECT_EQ(refusal_of(R"({"id":-1,"method":"arm"})").id, nullptr);
  EXPECT_EQ(refusal_of(R"({"id":18446744073709551615,"method":"arm"})").id, nullptr);
  EXPECT_EQ(refusal_of(R"({"id":1.5,"method":"arm"})").id, nullptr);
  EXPECT_EQ(refusal_of("garbage").id, nullptr);
  EXPECT_EQ(refusal_of("[]").id, nullptr);
}

TEST(Protocol, RefusesValuesOfAnotherKindOrOutOfRange) {
  for (const char* params : {R"({"entry":0})", R"({"entry":1.5})", R"({"entry":"1"})", R"({"entry":1e300})", "{}"}) {
    refusal_of(std::string(R"({"id":1,"method":"cancel","params":)") + params + "}");
  }
  for (const char* params : {R"({"entry":1})", R"({"entry":1,"to":0})", R"({"entry":1,"to":1,"by":1})",
                             R"({"entry":1,"by":1e9})", R"({"to":1})"}) {
    refusal_of(std::string(R"({"id":1,"method":"move","params":)") + params + "}");
  }
  for (const char* params : {R"({"rate_Hz":0})", R"({"rate_Hz":25.1})", R"({"rate_Hz":"5"})"}) {
    refusal_of(std::string(R"({"id":1,"method":"watch","params":)") + params + "}");
  }
  refusal_of(R"({"id":1,"method":"submit","params":{}})");
  refusal_of(R"({"id":1,"method":"submit","params":{"experiment":1}})");
  refusal_of(R"({"id":1,"method":"submit","params":{"experiment":"","fast":1}})");
  refusal_of(R"({"id":1,"method":"arm","params":[]})");
  const std::string longest(kLongestExperiment, 'x');
  EXPECT_EQ(call_of<SubmitCall>(R"({"id":1,"method":"submit","params":{"experiment":")" + longest + "\"}}")
                .experiments.at(0)
                .text,
            longest);
  refusal_of(R"({"id":1,"method":"submit","params":{"experiment":"x)" + longest + "\"}}");
}

TEST(Protocol, DoesNotFollowANestOfBrackets) {
  const std::string deep(100'000, '[');
  refusal_of(deep);
  EXPECT_NE(refusal_of(R"({"id":1,"params":)" + deep).message.find("nests"), std::string::npos);
}

TEST(Protocol, KeepsNoRequestOfManyValues) {
  std::string values = "{}";
  for (int i = 0; i < 80'000; ++i) values += ",{}";
  EXPECT_NE(refusal_of(R"({"id":1,"method":"status","params":{"a":[)" + values + "]}}").message.find("1000 values"),
            std::string::npos);
  std::string keys = R"("a":1)";
  for (int i = 0; i < 20'000; ++i) keys += ",\"" + std::to_string(i) + "\":1";
  EXPECT_NE(refusal_of(R"({"id":1,"params":{)" + keys + "}}").message.find("100 keys"), std::string::npos);
}

TEST(Protocol, AnswersInOneLineWhateverTheText) {
  EXPECT_EQ(error_line(nullptr, ExitCode::permission, "two\nlines \xff"),
            "{\"id\":null,\"error\":{\"code\":77,\"message\":\"two\\nlines \xEF\xBF\xBD\"}}\n");
  EXPECT_EQ(result_line(3, {{"a", 1}}), "{\"id\":3,\"result\":{\"a\":1}}\n");
  EXPECT_EQ(Json::parse(greeting_line()).at("protocol"), 1);
}

}  // namespace
}  // namespace eha::control
