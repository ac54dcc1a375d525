// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <span>
#include <string_view>
#include <vector>

#include "ident/model/model.hpp"

namespace eha::published {

/// Consecutive rows of a file as its publisher distributes it.
struct Part {
  /// Names of the file, one for each form of distribution; one with a folder ("data/train.h5") is the end of a path.
  std::vector<std::string_view> files;
  std::string_view input;   ///< name of the column, or its number from 1
  std::string_view output;  ///< the same
  std::size_t first = 0;
  std::size_t rows = 0;  ///< 0: to the end
};

/// A measure of the error that publications of a set use.
struct Measure {
  std::string_view name;
  bool greater_is_better = false;
  double (*value)(const ident::Score& score) = nullptr;  ///< [output unit], or [%]
};
[[nodiscard]] const Measure& rmse();
[[nodiscard]] const Measure& fit_percent();

/// A published result of a test by others.
struct Figure {
  std::string_view method;
  double value = 0.0;  ///< [unit of the test]
  std::string_view source;
};

/// Start of a test's simulation.
enum class Begin {
  anew,       ///< at the test's first row, from a state estimated from the first `start_rows` rows
  continued,  ///< at the estimating part's first row; the test is a later part of the same record, or that part
};

struct Test {
  std::string_view name;
  Part part;
  Begin begin = Begin::anew;
  std::size_t start_rows = 0;  ///< rows for the initial state, which are not scored; 0: the test begins at rest
  const Measure& measure;
  double factor = 1.0;         ///< converts the measure from the output's unit to `unit`
  std::string_view unit = {};  ///< empty: that of the file, which does not state it
  std::vector<Figure> figures = {};
};

/// A published set of records, with the split and the score that its publications use.
struct PublishedSet {
  std::string_view name;   ///< "emps"
  std::string_view title;  ///< displayed name
  std::string_view what;   ///< one sentence
  std::string_view fetch;  ///< where it is distributed
  double period_s = 0.0;   ///< [s]
  int decimation = 1;      ///< of the fit; tests are scored at every row
  Part estimation;
  std::vector<Test> tests;  ///< at least one
};

/// Returns the sets that `eha study published` has, one a row; no other code depends on a set's name.
[[nodiscard]] std::span<const PublishedSet> published_sets();

}  // namespace eha::published
