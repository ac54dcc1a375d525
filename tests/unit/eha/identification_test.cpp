// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/eha/identification.hpp"

#include <gtest/gtest.h>

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "daemon/record/run_folder.hpp"
#include "tests/unit/temporary_folder.hpp"

namespace eha::cli {
namespace {

namespace fs = std::filesystem;
using test::content_of;
using test::TemporaryFolder;

enum class Came { accepted, rejected, unconverged };

/// A model as a fit would leave it: 0.5 / (2 s^1.75 + 1).
IdentifiedModel model_that(Came came, const std::string& name = "fo") {
  IdentifiedModel identified;
  identified.structure.name = name;
  identified.structure.structure = ident::structures::fo();
  ident::Model& model = identified.result.model;
  model.name = name;
  model.transfer_function = {.numerator = {{0.5, 0.0}}, .denominator = {{2.0, 1.75}, {1.0, 0.0}}, .delay_s = 0.0};
  model.parameters = {{.name = "n2",
                       .value = 1.7512,
                       .std = 0.0107,
                       .lower95 = 1.73,
                       .upper95 = 1.77,
                       .fixed = false,
                       .role = ident::ParameterRole::denominator_order},
                      {.name = "n0",
                       .value = 0.0,
                       .std = 0.0,
                       .lower95 = 0.0,
                       .upper95 = 0.0,
                       .fixed = true,
                       .role = ident::ParameterRole::denominator_order}};
  model.estimation.emplace();
  model.estimation->converged = came != Came::unconverged;
  model.estimation->score.r2_percent = 99.5;
  model.validation.emplace();
  model.validation->score.r2_percent = 98.25;
  model.validation->offset_reestimated.emplace().r2_percent = 98.75;
  model.stability.emplace().stable = true;
  model.verdict = ident::Verdict{came == Came::accepted, {"A sentence about it."}};
  return identified;
}

TEST(ExitCodeOfModels, TellsAcceptedRejectedAndUnconverged) {
  EXPECT_EQ(exit_code({model_that(Came::rejected), model_that(Came::accepted)}), ExitCode::ok);
  EXPECT_EQ(exit_code({model_that(Came::rejected), model_that(Came::unconverged)}), ExitCode::model_rejected);
  EXPECT_EQ(exit_code({model_that(Came::unconverged)}), ExitCode::not_converged);
}

TEST(SizeReservation, NamesADecimationForARecordThatTakesMinutes) {
  EXPECT_FALSE(size_reservation(1'000'000, 1));
  EXPECT_FALSE(size_reservation(10'000'000, 10));
  const auto sentence = size_reservation(10'000'000, 2);
  ASSERT_TRUE(sentence);
  EXPECT_NE(sentence->find("5000000 rows"), std::string::npos) << *sentence;
  EXPECT_NE(sentence->find("--decimate 10 "), std::string::npos) << *sentence;
}

TEST(Report, ShowsOrdersWithTheDigitsThatTheirErrorsLeave) {
  const std::string text = report({model_that(Came::accepted)}, {model_that(Came::rejected)});
  EXPECT_NE(text.find("n2 1.751 +- 0.011, n0 0"), std::string::npos) << text;
  EXPECT_NE(text.find("fo (paper)"), std::string::npos) << text;
  EXPECT_NE(text.find("98.25"), std::string::npos) << text;
  EXPECT_NE(text.find("98.75"), std::string::npos) << text;
  EXPECT_NE(text.find("(0.5) / (2 s^1.75 + 1)"), std::string::npos) << text;
  EXPECT_NE(text.find("A sentence about it."), std::string::npos) << text;
}

TEST(WriteModels, MakesTheFolderAndOneFileForEachModel) {
  const TemporaryFolder folder;
  const auto written =
      write_models({model_that(Came::accepted, "io"), model_that(Came::rejected, "fo")}, folder.path() / "a" / "b");
  EXPECT_EQ(written,
            (std::vector<fs::path>{folder.path() / "a" / "b" / "io.json", folder.path() / "a" / "b" / "fo.json"}));
  EXPECT_EQ(nlohmann::json::parse(content_of(written[0])).at("name"), "io");
}

class PublishModels : public testing::Test {
 protected:
  PublishModels() : run_(record::create_run_folder(folder_.path(), "test")) {
    folder_.write(fs::relative(run_ / "run.json", folder_.path()),
                  R"({"schema": "eha-run/1", "outcome": "completed"})");
  }
  [[nodiscard]] bool has(const char* file) const { return fs::exists(run_ / file); }

  TemporaryFolder folder_;
  fs::path run_;
};

TEST_F(PublishModels, PutsAcceptedModelsInPlaceAndMovesLatest) {
  publish_models(run_, {model_that(Came::accepted, "io"), model_that(Came::rejected, "fo")}, {});
  EXPECT_TRUE(has("models/io.json"));
  EXPECT_FALSE(has("models/fo.json"));
  EXPECT_TRUE(has("models/rejected/fo.json"));
  EXPECT_EQ(fs::canonical(folder_.path() / "latest"), fs::canonical(run_));
  const auto identification = nlohmann::json::parse(content_of(run_ / "run.json")).at("identification");
  EXPECT_EQ(identification.at("accepted"), true);
  EXPECT_EQ(identification.at("models").at(1).at("file"), "models/rejected/fo.json");
}

TEST_F(PublishModels, LeavesLatestAloneWhenAllAreRejected) {
  publish_models(run_, {model_that(Came::rejected)}, {});
  EXPECT_FALSE(fs::exists(fs::symlink_status(folder_.path() / "latest")));
  EXPECT_TRUE(has("models/rejected/fo.json"));
}

TEST_F(PublishModels, TakesBackAModelThatALaterFitRejects) {
  publish_models(run_, {model_that(Came::accepted)}, {});
  publish_models(run_, {model_that(Came::rejected)}, {});
  EXPECT_FALSE(has("models/fo.json"));
  EXPECT_TRUE(has("models/rejected/fo.json"));
}

}  // namespace
}  // namespace eha::cli
