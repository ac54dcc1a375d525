// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
#include <string>

#include "daemon/identify/identification.hpp"
#include "daemon/identify/scored_model.hpp"

namespace eha::identify {

/// A model of a record with input and output exchanged.
struct ExchangedFit {
  std::string name;         ///< "io1"
  double r2_percent = 0.0;  ///< of the validation part
};

/// Whether input and output of a file may be exchanged: no model of it is accepted, or none is good and the output
/// comes before the input by itself (importer::why_later_than_its_output()) or what a model leaves over looks like
/// noise of the input; and the other way round one of the simplest has an R2 above 90 %, and above that of every model
/// as given, of an accepted one by a quarter of what that leaves over. None for a run, whose columns are known, and
/// where all samples estimate. Cost: two fits of two or three parameters to a few thousand samples.
[[nodiscard]] std::optional<ExchangedFit> exchanged_fit(const Source& source, const IdentificationTask& task,
                                                        const Identification& identification);

/// The same of a model scored on a file: neither it nor its structure fitted to the file has such an R2.
/// @param options  of the scores
[[nodiscard]] std::optional<ExchangedFit> exchanged_fit(const Source& source, const ident::FitOptions& options,
                                                        const ScoredModel& scored);

/// The same where the output comes before its input by a trial (wrong_input()): no model of exchanged columns is found
/// to be worse than the one whose input is taken as late.
/// @param r2_percent  of that model
[[nodiscard]] std::optional<ExchangedFit> exchanged_fit(const Source& source, const ident::FitOptions& options,
                                                        double r2_percent);

/// "input and output may be exchanged: ...", without the command that exchanges them.
[[nodiscard]] std::string exchange_sentence(const ExchangedFit& other, const ScoredModel& scored);

}  // namespace eha::identify
