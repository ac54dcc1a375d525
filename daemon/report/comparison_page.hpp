// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "daemon/identify/comparison.hpp"
#include "daemon/report/change_causes.hpp"
#include "daemon/report/page.hpp"
#include "ident/model/model.hpp"
#include "ident/validation/parameter_change.hpp"

namespace eha::report {

/// One of the compared runs or models.
struct ComparedSubject {
  std::string label;  ///< "runs/before"
  ident::Model model;
  std::optional<ident::PlantChange> change = {};  ///< from the first one to this one; none for the first
  identify::LeftOver left_over = {};              ///< the same, of two records
  bool judges_left_over = true;                   ///< another input moves another error
  double first_model_error = 0.0;                 ///< rms, of the first model on this record; 0: not known
  bool first_model_holds = true;                  ///< as identify::first_model_holds()
  bool has_other_input = false;                   ///< than the first, and `cannot_tell` says so
  std::string cannot_tell = {};  ///< why a difference is not shown to be a change of the plant; empty: it is
  std::optional<identify::Unfit> unfit = {};  ///< as of identify::ComparedRun, beside the first
  /// "on slip the error jumps by 0.3 in at about 12.3 s", where it does on one of the two records, which `cannot_tell`
  /// says too, and how to cut that record; empty: it does not.
  std::string jumps = {};
  std::string cut_beside_jump = {};
  std::string drift = {};                  ///< that a drift was taken out of a record, as of identify::ComparedRun
  std::string noise = {};                  ///< that the output's noise changed, and where to look; empty: not shown
  bool is_tight = false;                   ///< by the valve sheets beside both runs
  MapCause map_cause = MapCause::unknown;  ///< of another map, as the records show it
  /// Least and greatest input that the record has; none without a record.
  std::optional<std::pair<double, double>> input_range = {};
  /// How the rig of its record is reached, for a page; none: as findings.rig.
  std::optional<suggest::RigAccess> rig = {};
  // The record and the model on it, of one length; empty for a model alone.
  Eigen::VectorXd time_s = {};
  Eigen::VectorXd measured = {};
  Eigen::VectorXd simulated = {};
  /// The first run's model on this record; empty: not of runs, or the first.
  ident::OutputOfModel of_first_model = {};
};

/// The same of what the model leaves over.
[[nodiscard]] std::string left_over_word(const ComparedSubject& subject);

/// Whether what the model leaves over is shown to have changed.
[[nodiscard]] bool leaves_other(const ComparedSubject& subject);

/// Whether a parameter changed, in a word: "yes", "differs" where that is no change of the plant, or "not shown".
[[nodiscard]] std::string change_word(const ComparedSubject& subject, bool changed);

/// What may be the cause where no parameter is shown to have changed and the first model does not hold: the parameter
/// that is nearest to a change, and friction where the rigs are tight. Empty otherwise.
[[nodiscard]] std::string cause_sentence(const ComparedSubject& subject);

/// What the comparison with the first run found: the heading of the page and the first line on the terminal. Without a
/// point: "The plant changed: half dead band 0.149 to 0.311 V (+0.162 +- 0.009 V)", "The same plant, as far as these
/// records show: no parameter changed, and the first model holds".
/// @param first, subject  of two records
[[nodiscard]] std::string outcome(const ComparedSubject& first, const ComparedSubject& subject);

/// The outcomes of several, what matters most first: a change, then a model that does not fit or hold, then what is not
/// shown; at most three, and none that is alike beside another. With more than one subject beside the first their
/// labels stand before them. @param subjects  at least two
[[nodiscard]] std::string outcome_of_all(const std::vector<ComparedSubject>& subjects);

/// What to do about the outcome.
[[nodiscard]] std::string to_do_of(const ComparedSubject& subject);

/// Whether the outcome is that nothing differs.
[[nodiscard]] bool is_alike(const ComparedSubject& subject);

/// "io_valve does not fit mm_sat: its map lets the input through in one direction only. Its parameters say nothing of
/// the plant, and no change of them is claimed." @param subject  with `unfit`
[[nodiscard]] std::string unfit_sentence(const ComparedSubject& first, const ComparedSubject& subject);

/// "What the model leaves over changed by a factor of 2.4, from 0.00078 in rms on base to 0.00189 in."
[[nodiscard]] std::string left_over_sentence(const ComparedSubject& first, const ComparedSubject& subject);

/// "The model of base errs by 0.12 in rms on friction, 6 times the 0.02 in of the model fitted there: it does not
/// hold."
[[nodiscard]] std::string first_model_sentence(const ComparedSubject& first, const ComparedSubject& subject);

/// "holds" or "does not hold", for the tables.
[[nodiscard]] std::string first_model_word(const ComparedSubject& subject);

/// "Tested: null, dead_band, K, a1. Not tested: what these do not describe, as friction, leaks or noise.", without what
/// the subjects name as found. @param change  of one of them
[[nodiscard]] std::string tested_sentence(const ident::PlantChange& change, std::span<const ComparedSubject> subjects);

/// Result of a comparison.
struct ComparisonFindings {
  std::string title;    ///< "Comparison of before and after"
  std::string heading;  ///< as of outcome_of_all()
  bool is_alike = false;
  bool is_one_record = false;  ///< models on one record, whose output is drawn once
  bool is_one_plant = false;   ///< models of one record, on it or alone: where they differ, the models do
  std::vector<std::string> sentences = {};
  std::string to_do = {};                      ///< beside that of the changes; empty: nothing to say
  std::vector<std::string> sources = {};       ///< what is compared, with when it was written and its hash
  std::optional<suggest::RigAccess> rig = {};  ///< of what is said of all together; none: of models alone
};

/// Returns distinct short names of runs, records and model files: a run's folder, a file's name without its ending,
/// with the folder above it if two are alike. Follows a link.
[[nodiscard]] std::vector<std::string> titles_of(const std::vector<std::string>& paths);

/// Renders the before/after report: findings, parameters with joint intervals, valves, steps, records and Bode plots
/// over one another.
/// @param subjects  at least one; values in the displayed unit. Cost as assembled()
[[nodiscard]] Page comparison_page(const ComparisonFindings& findings, const std::vector<ComparedSubject>& subjects);

}  // namespace eha::report
