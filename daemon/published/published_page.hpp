// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "daemon/published/published_study.hpp"
#include "daemon/report/page.hpp"

namespace eha::published {

/// Renders the study as a page: for each available set its scores beside the published ones, and measured and simulated
/// output of each test; then the missing sets. Cost as report::assembled().
[[nodiscard]] report::Page page_of(const std::vector<StudiedSet>& study);

}  // namespace eha::published
