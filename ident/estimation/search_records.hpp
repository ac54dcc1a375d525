// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

#include "ident/estimation/output_error.hpp"
#include "ident/search/global_search.hpp"
#include "ident/search/realisation.hpp"
#include "ident/structure/structure_options.hpp"

namespace eha::ident {

/// A record made ready for the search, and the poles guessed from it.
struct SearchRecord {
  ComparedRecord compared;
  std::vector<PoleGuess> guesses;
};

/// The records that a search takes.
/// @param coarse        of coarsen()
/// @param asked         whose poles are guessed where it has a finite state
/// @param past          whether an input before t = 0 is wanted
/// @param behind_map    whether a map before G will be searched for
[[nodiscard]] std::vector<SearchRecord> search_records(const std::vector<CoarseRecord>& coarse,
                                                       const StructureOptions& asked, bool past, bool behind_map);

/// Coordinates of the poles guessed from a record.
[[nodiscard]] std::vector<Eigen::VectorXd> pole_starts(const Parametrisation& parametrisation,
                                                       const SearchRecord& record);

}  // namespace eha::ident
