// SPDX-License-Identifier: GPL-3.0-or-later
// `eha study published` as a user meets it.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

#include "tests/system/program.hpp"
#include "tests/unit/temporary_folder.hpp"

namespace eha::test {
namespace {

using nlohmann::json;

/// A record in the form of SID_demo2: a lag, 1600 rows of input and output without a header.
std::string made_up_record() {
  std::string text;
  double y = 0.0;
  for (int k = 0; k < 1600; ++k) {
    const double u = std::sin(0.05 * k) + std::sin(0.013 * k * std::sqrt(2.0));
    text += fmt::format("{:.9g},{:.9g}\n", u, y + 0.01 * std::sin(1000.0 * k));
    y += 0.05 * (u - y);
  }
  return text;
}

json set_of(const json& document, const std::string& name) {
  for (const json& set : document.at("sets")) {
    if (set.at("name") == name) return set;
  }
  return {};
}

TEST(StudyPublished, ListsTheSetsThatAreNotThere) {
  const TemporaryFolder folder;
  const Ended ended = run_eha({"study", "published", ".", "-o", "study"}, folder.path());
  EXPECT_EQ(ended.code, 10) << ended.err;
  EXPECT_NE(ended.out.find("emps: DATA_EMPS.mat, DATA_EMPS_PULSES.mat; from nonlinearbenchmark.org"), std::string::npos)
      << ended.out;
  EXPECT_NE(ended.err.find("no file of a published set is below it"), std::string::npos) << ended.err;
  EXPECT_FALSE(std::filesystem::exists(folder.path() / "study"));
}

TEST(StudyPublished, PutsItsScoreAmongThePublishedOnes) {
  const TemporaryFolder folder;
  std::filesystem::create_directory(folder.path() / "fetched");
  folder.write("fetched/sid_demo2.csv", made_up_record());
  const Ended ended = run_eha({"study", "published", "fetched", "-o", "study", "--json"}, folder.path());
  ASSERT_EQ(ended.code, 0) << ended.err;
  const json document = json::parse(ended.out);
  const json set = set_of(document, "sid-demo");
  EXPECT_TRUE(set.at("failure").is_null()) << set;
  const json test = set.at("tests").at(0);
  EXPECT_EQ(test.at("rows"), 800);
  EXPECT_LT(test.at("score").get<double>(), 0.05);
  EXPECT_EQ(test.at("place"), 1);  // below the noise of the published record
  EXPECT_FALSE(set_of(document, "emps").at("missing_files").empty());
  const std::string text = content_of(folder.path() / "study/study.txt");
  EXPECT_NE(text.find("\n>  "), std::string::npos) << text;
  EXPECT_NE(text.find("the noise alone"), std::string::npos) << text;
  EXPECT_NE(content_of(folder.path() / "study/report.html").find("<svg"), std::string::npos);
}

}  // namespace
}  // namespace eha::test
