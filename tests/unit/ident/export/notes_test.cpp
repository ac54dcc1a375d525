// SPDX-License-Identifier: GPL-3.0-or-later
// What the header of an exported model says of the model.
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <gtest/gtest.h>

#include <string>

#include "ident/export/model_formats.hpp"

namespace eha::ident {
namespace {

Model judged(Grade grade) {
  Model model;
  model.name = "io";
  model.transfer_function = {{{0.13, 0}}, {{0.013, 2}, {1, 1}, {0.0028, 0}}, 0.0};
  model.validation.emplace().score = {.error_min = -0.00359, .error_max = 0.001, .samples = 50};
  model.verdict = Verdict{.accepted = grade != Grade::rejected, .grade = grade};
  model.verdict->usable_band = FrequencyInterval{0.04, 0.644};
  model.provenance["record"] = "bench.csv";
  model.provenance["software"] = "eha 0.1.0";
  return model;
}

std::string notes_of(const Model& model) { return fmt::format("{}", fmt::join(notes(exported(model, {})), "\n")); }

TEST(ExportNotes, SayWhatAnAcceptedModelIsGoodForAndWhatItIsOf) {
  const std::string text = notes_of(judged(Grade::usable));
  EXPECT_NE(text.find("Verdict: usable; error on unseen data at most 0.00359 in; usable band 0.04 to 0.644 Hz."),
            std::string::npos)
      << text;
  EXPECT_NE(text.find("\nFitted to the record bench.csv\n"), std::string::npos) << text;
  EXPECT_NE(text.find("\nby eha 0.1.0\n"), std::string::npos) << text;
}

TEST(ExportNotes, HaveTheWordOfTheTables) {
  Model model = judged(Grade::rejected);
  model.verdict->reasons = {"The record does not need a0."};
  EXPECT_NE(notes_of(model).find("REJECTED: The record does not need a0."), std::string::npos);
  model.verdict->criteria = {{CriterionKind::coefficient_interval, "a0", 0.0, 0.0, false, true}};
  model.verdict->error_over_recommended = 1.2;
  const std::string text = notes_of(model);
  EXPECT_NE(text.find("NOT NEEDED: The record does not need a0."), std::string::npos) << text;
  EXPECT_EQ(text.find("REJECTED"), std::string::npos);
}

}  // namespace
}  // namespace eha::ident
