// SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>

#include <filesystem>
#include <iostream>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "core/error.hpp"
#include "daemon/identify/thread_executor.hpp"
#include "daemon/importer/import.hpp"
#include "ident/estimation/fit.hpp"
#include "tests/unit/ident/synthetic_record.hpp"
#include "tests/unit/identify/twin_source.hpp"
#include "tests/unit/shared_data.hpp"

namespace eha::identify {
namespace {

using ident::FitOptions;
using ident::Record;
using ident::StructureOptions;

constexpr double kWorse = 1e-3;  // of the mean square error
// Third order, servohydraulic_mts.csv: without the map, and its bias held at 0, a narrow optimum errs 1.4 % less than
// the one that all searches behind the map end in.
constexpr double kWorseBehindValve = 2e-2;

struct Data {
  std::string name;
  Record record;
  int decimation = 1;
  double discard_s = 0.0;
};

/// The made-up records, and the measured ones where they are beside the repository.
std::vector<Data> records() {
  using namespace ident::synthetic;
  std::vector<Data> all;
  all.push_back({"fractional", record_of(fractional(0.5, 1.7, 0.85, 0.3, 1.0), 0.05, 0.01, 3)});
  ident::Model integer = fractional(0.2, 2.0, 1.0, 0.7, 1.0);
  integer.transfer_function.delay_s = 0.1;
  all.push_back({"integer with a delay", record_of(integer, 0.05, 0.01, 4)});
  const Source rig = test::source_of(test::seeded(1));
  all.push_back({"simulated rig", rig.record, rig.experiment->fit.decimation, rig.experiment->fit.discard_s});
  const std::map<std::string, int> decimations = {
      {"hair_dryer.csv", 1}, {"eha_pump.csv", 31}, {"servohydraulic_mts.csv", 40}};
  for (const auto& [file, decimation] : decimations) {
    const std::filesystem::path path = eha::test::shared("data/" + file);
    if (std::filesystem::exists(path))
      all.push_back({file, importer::import_record(path.string(), {}).record, decimation});
  }
  return all;
}

StructureOptions asked(const std::string& name, ident::Structure structure,
                       std::vector<ident::ParameterRequest> parameters = {}) {
  // At rest: an initial state is no part of a fractional model.
  return {.name = name,
          .structure = std::move(structure),
          .initial_state = ident::InitialState::none,
          .parameters = std::move(parameters)};
}

ident::Structure with_delay(ident::Structure structure) {
  structure.delay.freedom = ident::Freedom::free;
  return structure;
}

/// Structures by name, and which lies inside which.
std::vector<StructureOptions> structures_to_fit() {
  using namespace ident::structures;
  const std::vector<ident::ParameterRequest> free_b0 = {{"b0", false, {}, {}, {}}};
  std::vector<StructureOptions> all = {asked("integrator_lag", integrator_lag()),
                                       asked("io1", io1()),
                                       asked("io", io()),
                                       asked("io3", io3()),
                                       asked("io3 with a zero", io3(1)),
                                       asked("io with a delay", with_delay(io())),
                                       asked("lag", lag()),
                                       asked("fo", fo()),
                                       asked("fo with b0", fo(), free_b0),
                                       asked("fo with a delay", with_delay(fo())),
                                       asked("fo with both", with_delay(fo()), free_b0),
                                       asked("commensurate 2/0", commensurate({2, 0})),
                                       asked("commensurate 3/1", commensurate({3, 1}))};
  const std::size_t linear = all.size();
  for (std::size_t k = 0; k < linear; ++k) {
    if (all[k].structure.numerator.size() > 1 || all[k].structure.delay.freedom == ident::Freedom::free) continue;
    all.push_back(all[k]);
    all.back().name += " behind a valve";
    all.back().structure = behind_valve(all.back().structure);
  }
  return all;
}

const std::vector<std::pair<std::string, std::string>> kInside = {{"integrator_lag", "io"},
                                                                  {"io1", "io"},
                                                                  {"io", "io3"},
                                                                  {"io3", "io3 with a zero"},
                                                                  {"io", "io with a delay"},
                                                                  {"io1", "lag"},
                                                                  {"lag", "fo"},
                                                                  {"io", "fo"},
                                                                  {"fo", "fo with b0"},
                                                                  {"fo", "fo with a delay"},
                                                                  {"fo", "fo with both"},
                                                                  {"fo with b0", "fo with both"},
                                                                  {"fo with a delay", "fo with both"},
                                                                  {"io with a delay", "fo with a delay"},
                                                                  {"io", "commensurate 2/0"},
                                                                  {"io3 with a zero", "commensurate 3/1"},
                                                                  {"commensurate 2/0", "commensurate 3/1"}};

TEST(NestedFits, AreNeverWorseThanThoseInsideThem) {
  std::size_t compared = 0;
  for (const Data& data : records()) {
    std::map<std::string, double> error;
    FitOptions options;
    options.decimation = data.decimation;
    options.discard_s = data.discard_s;
    options.intervals = ident::IntervalMethod::straight;
    for (const StructureOptions& structure : structures_to_fit()) {
      try {
        const ident::FitResult fitted = ident::fit(data.record, structure, options, thread_executor());
        error[structure.name] = fitted.model.estimation->score.mse;
      } catch (const DataError& refusal) {
        std::cout << data.name << ": " << refusal.what() << "\n";
      }
    }
    const auto compare = [&](const std::string& smaller, const std::string& larger, double worse) {
      if (!error.contains(smaller) || !error.contains(larger)) return;
      ++compared;
      EXPECT_LE(error[larger], (1.0 + worse) * error[smaller]) << data.name << ": " << smaller << " in " << larger;
    };
    for (const auto& [smaller, larger] : kInside) {
      compare(smaller, larger, kWorse);
      compare(smaller + " behind a valve", larger + " behind a valve", kWorse);
    }
    for (const StructureOptions& structure : structures_to_fit()) {
      compare(structure.name, structure.name + " behind a valve", kWorseBehindValve);
    }
  }
  EXPECT_GE(compared, 50U);
}

}  // namespace
}  // namespace eha::identify
