// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/study/paper_study.hpp"

#include <algorithm>
#include <mutex>
#include <utility>

#include "core/error.hpp"
#include "ident/estimation/fit.hpp"
#include "ident/estimation/paper_procedure.hpp"
#include "ident/structure/parameter_role.hpp"

namespace eha::study {
namespace {

struct TreatmentText {
  std::string_view name;
  std::string_view title;
};
constexpr std::array<TreatmentText, kTreatments.size()> kTexts{{{"published", "paper's procedure"},
                                                                {"bias", "bias removed"},
                                                                {"history", "history kept"},
                                                                {"both", "both: default procedure"}}};

ident::StructureOptions structure(bool fractional) {
  ident::StructureOptions asked;
  if (fractional) {
    asked.name = "fo";
    asked.structure = ident::structures::fo();
  }
  return asked;
}

ident::FitOptions options_of(ident::Procedure procedure) {
  ident::FitOptions options;
  options.procedure = procedure;
  options.intervals = ident::IntervalMethod::straight;
  options.decimation = 40;
  options.discard_s = 10.0;
  return options;
}

FittedModel summary(const ident::FitResult& result) {
  const ident::Model& model = result.model;
  FittedModel fitted;
  fitted.estimation_r2_percent = model.estimation->score.r2_percent;
  fitted.converged = model.estimation->converged;
  if (model.validation) {
    fitted.validation_r2_percent = model.validation->score.r2_percent;
    fitted.validation_mse = model.validation->score.mse;
  }
  fitted.stable = model.stability && model.stability->stable;
  fitted.highest_order = highest_order(model.transfer_function.denominator);
  fitted.input_bias_V = model.input_bias;
  return fitted;
}

FittedModel by_paper(const ident::Record& record, bool fractional) {
  return summary(ident::fit_by_paper(record, structure(fractional), options_of(ident::Procedure::paper)));
}

FittedModel by_default(const ident::Record& record, bool fractional, bool with_bias) {
  ident::StructureOptions asked = structure(fractional);
  if (!with_bias) {
    // An initial state could replace the bias.
    asked.initial_state = ident::InitialState::none;
    asked.parameters.push_back({ident::input_bias_key().name, true, 0.0, {}, {}});
  }
  return summary(ident::fit(record, asked, options_of(ident::Procedure::standard)));
}

/// Models fitted to one record, and the reasons for missing ones.
struct Treated {
  std::vector<StudyRow> rows = {};
  std::vector<std::string> reasons = {};
};

/// Fits by the four treatments of one record. If one gives no model, the others are kept.
Treated treated(std::size_t plant, std::uint64_t seed) {
  const ident::Record record = plant_kinds()[plant].record(seed);
  Treated all;
  double bias_V = 0.0;
  const auto add = [&](Treatment treatment, const std::function<FittedModel(bool fractional)>& fitted) {
    try {
      all.rows.push_back(
          {.plant = plant, .seed = seed, .treatment = treatment, .io = fitted(false), .fo = fitted(true)});
      if (treatment == Treatment::both) bias_V = all.rows.back().io.input_bias_V;
    } catch (const Error& error) {
      all.reasons.push_back(std::string(title_of(treatment)) + ": " + error.what());
    }
  };
  add(Treatment::both, [&](bool fractional) { return by_default(record, fractional, true); });
  add(Treatment::history, [&](bool fractional) { return by_default(record, fractional, false); });
  add(Treatment::published, [&](bool fractional) { return by_paper(record, fractional); });
  ident::Record unbiased = record;
  unbiased.input.array() += bias_V;
  add(Treatment::bias, [&](bool fractional) { return by_paper(unbiased, fractional); });
  std::sort(all.rows.begin(), all.rows.end(),
            [](const StudyRow& x, const StudyRow& y) { return x.treatment < y.treatment; });
  return all;
}

}  // namespace

std::string_view name_of(Treatment treatment) { return kTexts[static_cast<std::size_t>(treatment)].name; }
std::string_view title_of(Treatment treatment) { return kTexts[static_cast<std::size_t>(treatment)].title; }

PaperStudy study_paper(int seeds, const ident::Executor& executor, const StudyProgress& progress) {
  const std::size_t per_plant = static_cast<std::size_t>(std::max(0, seeds));
  const std::size_t records = plant_kinds().size() * per_plant;
  std::vector<Treated> fitted(records);
  std::mutex mutex;
  std::size_t done = 0;
  executor(records, [&](std::size_t i) {
    try {
      fitted[i] = treated(i / per_plant, i % per_plant + 1);
    } catch (const Error& error) {
      fitted[i].reasons.emplace_back(error.what());
    }
    const std::scoped_lock lock(mutex);
    ++done;
    if (progress) progress(done, records);
  });
  PaperStudy study{.seeds = seeds, .rows = {}, .failures = {}};
  for (std::size_t i = 0; i < records; ++i) {
    study.rows.insert(study.rows.end(), fitted[i].rows.begin(), fitted[i].rows.end());
    for (std::string& reason : fitted[i].reasons) {
      study.failures.push_back({i / per_plant, i % per_plant + 1, std::move(reason)});
    }
  }
  return study;
}

}  // namespace eha::study
