// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "core/display_unit.hpp"
#include "daemon/batch/batch_folder.hpp"

namespace eha::batch {

/// Probability that a batch reports an outlier although there is none, for all records and parameters together; also
/// that of a false trend.
inline constexpr double kOutlierLevel = 0.01;

/// Fewest records for a comparison of their values.
inline constexpr std::size_t kFewestForOutliers = 5;

/// A parameter of one record that deviates from those of the others.
struct Outlier {
  std::string parameter;
  double value = 0.0;
  double median = 0.0;      ///< of all records
  double half_width = 0.0;  ///< of the joint interval around the median
  std::string unit = {};    ///< empty for a ratio or an order
};

/// Figures of a record's recommended model; empty without one.
struct RowFigures {
  std::string fit_percent;  ///< on unseen data
  std::string error;        ///< greatest on unseen data, with its unit
  std::string form;         ///< "K = 0.148 in/(V s), integrating; T = 0.0056 s"
};

/// One record in the table.
struct Row {
  Record record;
  int exit_code = 0;
  bool judged = false;
  std::string reason;                      ///< reason for which it was not judged
  nlohmann::ordered_json fit;              ///< of Result: models and recommendation; null if it was not judged
  std::string recommended;                 ///< model; "none" without one
  std::vector<Outlier> outliers;           ///< of the table's common model
  std::vector<std::string> warnings = {};  ///< of `eha fit`, one sentence each
  RowFigures figures = {};
  std::string rig = {};    ///< of a run; empty of a file
  std::string label = {};  ///< the record's name among the others, for people: labels_of()
};

/// A parameter that rises or falls with the order of the records.
struct Trend {
  std::string parameter;
  double change = 0.0;    ///< from the first record to the last
  std::string unit = {};  ///< empty for a ratio or an order
};

/// Smallest change of a parameter that these records can show.
struct Resolution {
  std::string parameter;
  double change = 0.0;         ///< distance from the median above which a record is reported; the least of all records
  std::size_t change_row = 0;  ///< the record that it is of
  double furthest_change = 0.0;  ///< the same distance of the record furthest from the median
  std::size_t furthest_row = 0;  ///< of the record furthest from the median, reported or not
  double furthest = 0.0;         ///< its value
  double median = 0.0;
  std::string unit = {};  ///< empty for a ratio or an order
};

/// A kind of warning, as several records have it with other figures.
struct WarningKind {
  std::string text;               ///< that of the first record
  std::vector<std::size_t> rows;  ///< the records that have it, in the order of the table
};

struct Table {
  std::vector<Row> rows;      ///< in the list's order
  std::string common_model;   ///< the model that most records recommend, or the first that all have; may be empty
  std::vector<Trend> trends;  ///< of the common model
  std::vector<Resolution> resolutions;  ///< of the common model's parameters; none with fewer than kFewestForOutliers
  std::size_t judged = 0;
  std::size_t missing = 0;  ///< without a result
};

/// Estimate of a parameter by one record.
struct Estimate {
  std::size_t row = 0;  ///< in Table::rows
  double value = 0.0;
  double std = 0.0;
  double lower95 = 0.0;
  double upper95 = 0.0;
  /// Distance from the median from which on the record is an outlier; 0 with fewer than kFewestForOutliers.
  double half_width = 0.0;
};

/// A parameter of one model, over the records.
struct Parameter {
  std::string name;
  std::string unit;                 ///< empty for a ratio or an order
  std::vector<Estimate> estimates;  ///< in the order of the rows
  double median = 0.0;
};

/// Returns the free parameters of a model, without those of the record's start, in the model's order; where all
/// records' models come to rest, K/a0 and the time constant T of one pole in their place (ident::figure_at_rest).
/// Leaves out records whose model of this name is rejected, and those in other units than the first one.
[[nodiscard]] std::vector<Parameter> parameters_of(const std::vector<Row>& rows, const std::string& model);

/// Returns the records with an accepted model of this name in other units than those of the first: an inch and a
/// millimetre are not compared.
[[nodiscard]] std::vector<std::size_t> rows_in_other_units(const std::vector<Row>& rows, const std::string& model);

/// A judged record that takes no part in the comparison by a model, or not by each parameter.
struct NotCompared {
  std::size_t row = 0;
  std::string reason;    ///< "io is rejected: The rod stands ..."
  bool in_part = false;  ///< its model lacks a parameter that two thirds of the others have
};

/// Returns the judged records without an accepted model of this name, then those whose model lacks a parameter, each
/// with the reason.
[[nodiscard]] std::vector<NotCompared> not_compared(const std::vector<Row>& rows, const std::string& model);

/// The verdict's grade of the recommended model; empty without one.
[[nodiscard]] std::string grade_of(const Row& row);

/// The warnings of all records, each kind once, in the order of the first record of each.
[[nodiscard]] std::vector<WarningKind> warning_kinds(const Table& table);

/// The table of the results so far. It depends only on the results, not on machine or time.
///
/// A value is an outlier if its distance from the median of the records exceeds t max(std, 1.4826 MAD): std is its own
/// standard error, MAD the median absolute deviation of the records, and t Student's quantile at kOutlierLevel, shared
/// among all records and parameters (Bonferroni). At least five records are needed.
///
/// A trend is reported by Mann and Kendall's test at kOutlierLevel, shared among the parameters; its size is that of
/// Theil and Sen's line. At least ten records are needed.
/// @param unit  of lengths; by default that of each record
/// @throws as BatchFolder::result
[[nodiscard]] Table table_of(const BatchFolder& folder, const DisplayUnit& unit = {});

/// Unit of lengths of the rig whose runs the batch has; empty without a run, or if they differ.
[[nodiscard]] std::string rig_units_of(const BatchFolder& folder);

/// One row a record and model: record, source, verdict, validation, and each parameter with its interval.
[[nodiscard]] std::string to_csv(const Table& table);

/// The same as a document of schema eha-batch-table/1.
[[nodiscard]] nlohmann::ordered_json to_json(const Table& table);

/// Writes table.csv and table.json into the batch's folder. @returns their paths
std::vector<std::filesystem::path> write_table(const BatchFolder& folder, const Table& table);

}  // namespace eha::batch
