// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "daemon/identify/progress.hpp"
#include "daemon/identify/source.hpp"
#include "ident/estimation/fit.hpp"
#include "ident/validation/parameter_change.hpp"
#include "ident/validation/record_findings.hpp"

namespace eha::identify {

/// What the models leave over of two records: noise, friction and whatever else they do not describe.
struct LeftOver {
  double before = 0.0;  ///< rms error [output unit]
  double after = 0.0;
  bool changed = false;  ///< by more than kOtherLeftOver
};

/// From this factor on the errors on two records of one experiment are unlike.
inline constexpr double kOtherLeftOver = 1.5;

/// Why one of two models, each fitted to its own record, says nothing of the plant.
struct Unfit {
  bool is_first = false;  ///< the first run's model; else that of the other run
  std::string why;        ///< "its map lets the input through in one direction only"
};

/// One run compared with the first.
struct ComparedRun {
  ident::FitResult fit;                      ///< the model has a verdict, with its usable band
  std::optional<ident::PlantChange> change;  ///< from the first run to this one; none for the first
  LeftOver left_over = {};                   ///< the same
  double first_model_error = 0.0;            ///< rms, of the first run's model on this run [output unit]; 0: the first
  ident::OutputOfModel of_first_model = {};  ///< on this run's record; empty: the first
  bool has_other_input = false;              ///< than the first, which alone can change the parameters
  /// By how much null and dead band of a map that does not fit its own record, as with a leak, may be off the valve's
  /// [input unit], on which run, and whether that explains what changed of them. None: both maps fit.
  struct BentMap {
    double shift = 0.0;
    bool is_first = false;
    bool explains = false;
    bool appeared = false;  ///< on the other run at least twice as great as on the first
  };
  std::optional<BentMap> bent_map = {};
  /// A sudden lasting change of the error of a model on its own record, of one of the two: a sensor that slipped makes
  /// one, and no plant does. Nothing is shown then.
  struct SuddenError {
    ident::ErrorJump jump;
    ident::CutBeside cut;
    bool is_first = false;  ///< on the first run's record; else on this one
  };
  std::optional<SuddenError> sudden = {};
  /// That a drift was taken out of its record or the first's: "d.csv: the output drifts by ..."; empty: of neither.
  std::string drift = {};
  std::string cannot_tell = {};  ///< why the plant may be the same although parameters differ; empty: it tells
  /// One of the two models does not describe its own record: `change` then claims nothing. Where the first model errs
  /// as little as the other one it is set only if no change is shown and one of them leaves so much over that a change
  /// may hide there.
  std::optional<Unfit> unfit = {};
};

/// Whether the first run's model describes a run: errs at most ident::kGreatestErrorOverRefit times as much as the one
/// fitted to that run, and no model of the two is unfit.
[[nodiscard]] bool first_model_holds(const ComparedRun& run);

/// Returns which of two models, each fitted to its own record, does not describe it: rejected for more than parameters
/// that its record does not need, with a valve map that is one-way, with a gain of the other sign, or with a fit that
/// is far worse than the other's. None where both do.
[[nodiscard]] std::optional<Unfit> unfit_of(const ident::Model& before, const ident::Model& after);

struct RunComparison {
  /// The model fitted to every run: "io_valve"; "io" where a valve map is not known; "io1" or "io" with a dead time
  std::string structure;
  bool has_dead_time = false;      ///< that model's is estimated
  std::vector<ComparedRun> runs;   ///< in the order given
  std::vector<std::string> notes;  ///< limits of the comparison, one sentence each
};

/// Fits one structure to the whole of every record, on samples of the same step and with the same discarded start, and
/// compares the parameters of each with the first's. Lengths are converted to the first record's unit. Each record is
/// decimated to one step: the first's by its experiment, or the longest step of the rows. The structure is the
/// integer-order model behind a valve map; if one record does not excite both sides of the valve, or does not determine
/// the map, all are fitted without a map. Where no dead band shows, and a model of one pole or of two with a dead time
/// describes all records better, that is compared.
/// @param sources  at least two
/// @throws DataError  records differ in units that are no lengths, or have rows whose steps are no multiples of one
/// another, or as ident::fit; ConfigError as ident::fit
[[nodiscard]] RunComparison compare_runs(const std::vector<Source>& sources, const Progress& progress = {});

}  // namespace eha::identify
