// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <filesystem>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "daemon/published/published_set.hpp"
#include "ident/model/model.hpp"

namespace eha::published {

/// A test, scored with the model of the estimating part.
struct ScoredTest {
  const Test* test = nullptr;
  double score = 0.0;  ///< [unit of the test]; not finite where the model diverges
  /// Score with offset and state fitted to all scored rows, as in `eha validate`; the difference is due to the start.
  /// It is not a score by the test's rules; none for a later part of the estimating record.
  std::optional<double> with_start_fitted = {};
  bool is_of_estimating_rows = false;
  Eigen::VectorXd time_s = {};     ///< of the scored rows, from the test's first row
  Eigen::VectorXd measured = {};   ///< [unit of the file]
  Eigen::VectorXd simulated = {};  ///< the same
};

/// Results of a set.
struct StudiedSet {
  const PublishedSet* set = nullptr;
  std::vector<std::string> missing_files =
      {};                    ///< one entry for each part without a file, with its names; not empty: nothing was done
  std::string failure = {};  ///< reason for which an available set gave no score; one sentence
  std::optional<ident::Model> model = {};  ///< the recommended one, else the one recommended without a limit on R2
  bool is_recommended = false;
  std::string recommendation = {};  ///< sentence of the ladder
  std::size_t estimating_rows = 0;
  double seconds = 0.0;  ///< of the ladder, elapsed
  std::vector<ScoredTest> tests = {};

  [[nodiscard]] bool is_absent() const { return !missing_files.empty(); }
};

/// @param share  done so far, 0..1   @param step  "emps: fitting io"
using StudyProgress = std::function<void(double share, const std::string& step)>;

/// For each set whose files are below a folder: climbs the ladder on the whole estimating part, takes the recommended
/// model and scores it on each test. All sets follow one protocol: a test's rows have no effect on the fit, the choice
/// or the options, except `start_rows` of them, which determine the test's initial state.
/// @throws IoError, PermissionError  the folder cannot be read
/// Cost: a ladder a set, minutes where a record has 65 000 rows.
[[nodiscard]] std::vector<StudiedSet> study_published(std::span<const PublishedSet> sets,
                                                      const std::filesystem::path& folder,
                                                      const StudyProgress& progress = {});

}  // namespace eha::published
