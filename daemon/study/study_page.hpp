// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "daemon/report/page.hpp"
#include "daemon/study/study_summary.hpp"

namespace eha::study {

/// The study as a page: conclusions, table, one plot of the gains and one of the orders. Cost as report::assembled().
[[nodiscard]] report::Page page_of(const PaperStudy& study);

}  // namespace eha::study
