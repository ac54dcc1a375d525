// SPDX-License-Identifier: GPL-3.0-or-later
//
// The ladder on plants of drawn parameters. Arguments, both optional: the seed of the first record, and how many
// records of each kind.
#include "tests/unit/ident/estimation/random_plants.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <cstdlib>
#include <iostream>
#include <sstream>
#include <thread>

#include "ident/estimation/ladder.hpp"

namespace eha::ident {
namespace {

using namespace random_plants;

std::uint64_t first_seed = 1;
int records_of_a_kind = 20;

constexpr double kPeak = 3.0;

struct Outcome {
  std::string line;
  bool found = false;      ///< within 1 %, or 3 times the error of the truth's own structure
  bool lost = false;       ///< the truth's own structure is rejected
  bool too_good = false;   ///< good, and far off on a fresh input
  bool warned = false;     ///< a residual test of a model that is right failed
  bool misjudged = false;  ///< of fractional order for a truth of integer order
};

const Model* named(const Climb& climbed, const std::string& name) {
  for (const ClimbedModel& m : climbed.models) {
    if (m.result.model.name == name) return &m.result.model;
  }
  return nullptr;
}

bool fails_a_test(const Model& model) {
  return std::any_of(model.verdict->criteria.begin(), model.verdict->criteria.end(), [](const Criterion& c) {
    using Kind = CriterionKind;
    const bool tests = c.kind == Kind::nonlinearity || c.kind == Kind::future_input || c.kind == Kind::predicted_error;
    return has_failed(c) && (tests || name_of(c).starts_with("residual"));
  });
}

/// @param number  of the record, which seeds it
Outcome outcome_of(const std::string& kind, bool is_inside, std::uint64_t number) {
  Draw draw(number);
  const Truth truth = is_inside ? inside(kind, draw) : outside(kind, kPeak, draw);
  const Input shape = !is_inside || uniform(draw) < 0.7 ? Input::levels : Input::tones;
  const auto rows = static_cast<Eigen::Index>(log_between(300.0, 3000.0, draw));
  const Noise noise = uniform(draw) < 0.7 ? Noise::white : Noise::coloured;
  const double share = log_between(0.001, 0.02, draw);
  const Record record = record_of(truth.plant, input(shape, kPeak, rows, draw), noise, share, draw);
  const PreparedRecord prepared(record, {});
  const Climb climbed =
      climb(prepared, {}, {}, {},
            [&](const StructureOptions& asked, const FitOptions& options, const std::vector<Model>& known) {
              return fit(prepared, asked, options, run_in_order, known);
            });
  const Eigen::VectorXd fresh = input(shape, kPeak, rows, draw);
  const auto error = [&](const Model* model, double scale) {
    return model == nullptr ? INFINITY : error_percent(*model, truth.plant, scale * fresh);
  };
  const Model* recommended = named(climbed, climbed.recommendation.model);
  const Model* own = named(climbed, truth.family);
  Outcome outcome;
  const double same = error(recommended, 1.0);
  const double half = error(recommended, 0.5);
  outcome.found = same <= std::max(1.0, 3.0 * (own != nullptr ? error(own, 1.0) : 0.0));
  outcome.lost = own != nullptr && !own->verdict->accepted && noise == Noise::white;
  outcome.warned = outcome.found && recommended != nullptr && fails_a_test(*recommended);
  outcome.too_good =
      recommended != nullptr && recommended->verdict->grade == Grade::good && (same > 5.0 || half > 10.0);
  outcome.misjudged = recommended != nullptr && has_estimated_order(*recommended) && truth.family != "fo" &&
                      truth.family != "lag" && is_inside;
  std::ostringstream line;
  line << kind << ", record " << number << (noise == Noise::white ? ", white " : ", AR(1) ") << 100.0 * share << " %, "
       << rows << " rows: " << (recommended != nullptr ? recommended->name : "none") << " "
       << (recommended != nullptr ? text(recommended->verdict->grade) : "") << ", errs by " << same << " and " << half
       << " %";
  if (own != nullptr && own != recommended) {
    line << "; " << truth.family << " " << text(own->verdict->grade) << " errs by " << error(own, 1.0) << " %";
  }
  if (recommended == nullptr) line << "; " << climbed.recommendation.reason;
  if (recommended != nullptr) {
    for (const std::string& reason : recommended->verdict->reasons) line << "\n    " << reason;
  }
  outcome.line = line.str();
  return outcome;
}

std::vector<Outcome> outcomes(const std::vector<std::string>& kinds, bool are_inside) {
  const std::size_t all = kinds.size() * static_cast<std::size_t>(records_of_a_kind);
  std::vector<Outcome> found(all);
  std::atomic<std::size_t> next{0};
  std::vector<std::jthread> threads;
  for (unsigned t = 0; t < std::max(1U, std::thread::hardware_concurrency()); ++t) {
    threads.emplace_back([&] {
      for (std::size_t k = next++; k < all; k = next++) {
        const std::string& kind = kinds[k % kinds.size()];
        found[k] = outcome_of(kind, are_inside, 1000 * first_seed + k);
      }
    });
  }
  threads.clear();
  return found;
}

double share_of(const std::vector<Outcome>& all, bool Outcome::*is) {
  return static_cast<double>(std::count_if(all.begin(), all.end(), [&](const Outcome& o) { return o.*is; })) /
         static_cast<double>(all.size());
}

TEST(RandomPlants, OnTheLadderAreFound) {
  const std::vector<Outcome> all = outcomes(kinds_inside(), true);
  for (const Outcome& o : all) {
    if (!o.found || o.lost || o.warned || o.misjudged) std::cout << o.line << "\n";
  }
  std::cout << all.size() << " records: found " << 100.0 * share_of(all, &Outcome::found)
            << " %, own structure rejected " << 100.0 * share_of(all, &Outcome::lost) << " %, warned "
            << 100.0 * share_of(all, &Outcome::warned) << " %, fractional for integer "
            << 100.0 * share_of(all, &Outcome::misjudged) << " %\n";
  EXPECT_GE(share_of(all, &Outcome::found), 0.95);
  EXPECT_LE(share_of(all, &Outcome::lost), 0.03);
  EXPECT_LE(share_of(all, &Outcome::warned), 0.03);
  EXPECT_LE(share_of(all, &Outcome::misjudged), 0.01);
}

TEST(RandomPlants, OutsideTheLadderAreNotGood) {
  const std::vector<Outcome> all = outcomes(kinds_outside(), false);
  for (const Outcome& o : all) {
    if (o.too_good) std::cout << o.line << "\n";
  }
  std::cout << all.size() << " records: good and far off " << 100.0 * share_of(all, &Outcome::too_good) << " %\n";
  EXPECT_EQ(share_of(all, &Outcome::too_good), 0.0);
}

}  // namespace

void set_first_seed(std::uint64_t seed) { first_seed = seed; }
void set_records_of_a_kind(int records) { records_of_a_kind = records; }

}  // namespace eha::ident

int main(int argc, char** argv) {
  testing::InitGoogleTest(&argc, argv);
  if (argc > 1) eha::ident::set_first_seed(std::strtoull(argv[1], nullptr, 10));
  if (argc > 2) eha::ident::set_records_of_a_kind(std::atoi(argv[2]));
  return RUN_ALL_TESTS();
}
