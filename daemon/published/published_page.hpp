// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "daemon/published/published_study.hpp"
#include "daemon/report/page.hpp"

namespace eha::published {

/// The study as a page: for each set that is there the scores beside the published ones, and measured and simulated
/// output of each test; then the sets that are not there. Cost as report::assembled().
[[nodiscard]] report::Page page_of(const std::vector<StudiedSet>& study);

}  // namespace eha::published
