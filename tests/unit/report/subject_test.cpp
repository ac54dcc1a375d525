// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/report/subject.hpp"

#include <gtest/gtest.h>

#include <string>

#include "core/error.hpp"
#include "daemon/report/display.hpp"
#include "daemon/report/report.hpp"
#include "ident/model/model_file.hpp"
#include "tests/unit/report/subjects.hpp"
#include "tests/unit/temporary_folder.hpp"

namespace eha::report {
namespace {

using eha::test::TemporaryFolder;

TEST(InUnit, ShowsTheOutputInMillimetres) {
  Subject subject = subject_of("run", ident::Grade::good);
  subject.response = record::NumberTable{{"frequency_Hz", "gain", "gain_dB", "io_gain_std_dB", "noise_dB"},
                                         {{1.0}, {0.5}, {-6.0}, {0.1}, {-40.0}}};
  const double measured = subject.fit.measured[7];
  const Subject shown = in_unit(subject, DisplayUnit("mm"));
  EXPECT_EQ(shown.fit.output.unit, "mm");
  EXPECT_DOUBLE_EQ(shown.fit.measured[7], 25.4 * measured);
  EXPECT_DOUBLE_EQ(shown.models[0].model.transfer_function.numerator[0].coefficient, 25.4 * 0.13);
  EXPECT_DOUBLE_EQ(shown.response->columns[1][0], 25.4 * 0.5);
  EXPECT_NEAR(shown.response->columns[2][0], -6.0 + 28.0967, 1e-3);
  EXPECT_DOUBLE_EQ(shown.response->columns[3][0], 0.1);
  EXPECT_DOUBLE_EQ(shown.response->columns[4][0], -40.0);
  const std::string html = page_of(shown).html;
  EXPECT_NE(html.find("displacement [mm]"), std::string::npos);
  EXPECT_EQ(html.find(" in<"), std::string::npos);
}

TEST(LoadModels, TakesTheTableOfTheirFolder) {
  const TemporaryFolder folder;
  const auto file = folder.write("io.json", ident::to_text(model_named("io", ident::Grade::good, 99.0)));
  folder.write("fit.csv",
               "time_s,voltage_V,displacement_in,io_in,io_residual_in,fo_in,fo_residual_in\n"
               "0,1,2,2.5,-0.5,2,0\n0.1,1,2,2.5,-0.5,2,0\n");
  const Subject subject = load_models({file});
  ASSERT_EQ(subject.fit.models.size(), 1U);
  EXPECT_EQ(subject.fit.models[0].simulated[1], 2.5);
}

TEST(LoadModels, NamesManyModelsByTheirRecordNotByTheFolder) {
  const TemporaryFolder folder;
  std::vector<std::filesystem::path> files;
  for (const char* name : {"a", "b", "c", "d"}) {
    ident::Model model = model_named(name, ident::Grade::good, 99.0);
    model.provenance["record"] = "records/bench-17.csv";
    files.push_back(folder.write(std::string(name) + ".json", ident::to_text(model)));
  }
  EXPECT_EQ(load_models(files).name, "4 models of bench-17.csv");
}

TEST(LoadModels, NamesTheRecordAndTheDate) {
  const TemporaryFolder folder;
  ident::Model model = model_named("io", ident::Grade::good, 99.0);
  model.provenance["record"] = "bench-17.csv";
  const Subject subject = load_models({folder.write("io.json", ident::to_text(model))});
  ASSERT_EQ(subject.written.size(), 16U) << subject.written;
  EXPECT_NE(page_of(subject).html.find("From model files of the record bench-17.csv, written " + subject.written),
            std::string::npos);
}

/// A model of the record "bench.csv".
ident::Model of_bench(const std::string& name, ident::Grade grade) {
  ident::Model model = model_named(name, grade, 99.0);
  model.provenance["record"] = "bench.csv";
  model.estimation->information = ident::InformationCriteria{};
  return model;
}

TEST(LoadModels, SpeaksOfOneModel) {
  const TemporaryFolder folder;
  const auto fo = folder.write("fo.json", ident::to_text(of_bench("fo", ident::Grade::rejected)));
  EXPECT_FALSE(load_models({fo}).beside);
  const auto io = folder.write("io.json", ident::to_text(of_bench("io", ident::Grade::usable)));
  folder.write("none.json", "{");
  ident::Model other = of_bench("lag", ident::Grade::usable);
  other.provenance["record"] = "other.csv";
  folder.write("other.json", ident::to_text(other));
  const std::string html = page_of(load_models({fo})).html;
  EXPECT_NE(html.find("<h2>This model, fo, is rejected</h2>"), std::string::npos);
  EXPECT_EQ(html.find("No model can be used"), std::string::npos);
  EXPECT_FALSE(load_models({fo, io}).beside);
}

TEST(LoadModels, CallsAModelByTheWordOfTheTables) {
  const TemporaryFolder folder;
  ident::Model model = of_bench("io_valve", ident::Grade::rejected);
  model.verdict->criteria = {{ident::CriterionKind::coefficient_interval, "a0", 0.0, 0.0, false, true}};
  model.verdict->error_over_recommended = 1.2;
  const Subject subject = load_models({folder.write("io_valve.json", ident::to_text(model))});
  EXPECT_NE(page_of(subject).html.find("<h2>This model, io_valve, is not needed</h2>"), std::string::npos);
}

TEST(LoadModels, KnowsTheLevelThatTheRecordShows) {
  const TemporaryFolder folder;
  ident::Model model = model_named("io", ident::Grade::good, 99.0);
  model.initial_output = 2.93924;
  model.estimation->score.mse = 1e-6;
  model.estimation->score.error_max = 0.003;  // a file does not hold it
  model.parameters.push_back({.name = "initial_output",
                              .value = 2.93924,
                              .std = 0.0006,
                              .lower95 = 2.93804,
                              .upper95 = 2.94045,
                              .role = ident::ParameterRole::initial_output});
  const Subject subject = load_models({folder.write("io.json", ident::to_text(model))});
  EXPECT_NE(page_of(subject).html.find("initial output 2.9392 in"), std::string::npos);
  model.parameters.back().upper95 = 4.0;
  EXPECT_NE(
      page_of(load_models({folder.write("io.json", ident::to_text(model))})).html.find("the record does not show"),
      std::string::npos);
}

TEST(LoadModels, PutsTheBestModelFirst) {
  const TemporaryFolder folder;
  const auto bad = folder.write("a.json", ident::to_text(model_named("a", ident::Grade::rejected, 99.9)));
  const auto usable = folder.write("b.json", ident::to_text(model_named("b", ident::Grade::usable, 95.0)));
  ident::Model less_error = model_named("c", ident::Grade::usable, 97.0);
  less_error.validation->score.mse = 5e-5;
  const auto better = folder.write("c.json", ident::to_text(less_error));
  const Subject subject = load_models({bad, usable, better});
  EXPECT_EQ(subject.models[0].model.name, "c");
  EXPECT_EQ(subject.models[2].model.name, "a");
}

TEST(LoadRun, RefusesAFolderThatIsNone) {
  const TemporaryFolder folder;
  EXPECT_THROW(static_cast<void>(load_run(folder.path())), DataError);
}

}  // namespace
}  // namespace eha::report
