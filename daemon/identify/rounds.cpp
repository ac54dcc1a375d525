// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/identify/rounds.hpp"

#include <fmt/format.h>

#include <regex>

#include "core/error.hpp"

namespace eha::identify {
namespace {

constexpr int kMostRepetitions = 16;

/// Sets a top-level key in the text. @param after  the key after which a missing one is inserted
std::string with_number(const std::string& text, const std::string& key, int value, const std::string& after) {
  const std::size_t tables = text.find("\n[");
  const std::string top = text.substr(0, tables);
  const std::string rest = tables == std::string::npos ? std::string() : text.substr(tables);
  const std::regex line(fmt::format("(^|\n)({}[ \t]*=[ \t]*)[0-9]+", key));
  if (std::regex_search(top, line)) return std::regex_replace(top, line, fmt::format("$1$02{}", value)) + rest;
  const std::regex before(fmt::format("(^|\n)({}[ \t]*=[^\n]*)", after));
  return std::regex_replace(top, before, fmt::format("$1$2\n{} = {}", key, value)) + rest;
}

}  // namespace

std::optional<NextExperiment> longer_experiment(const Source& source) {
  if (!source.experiment || source.experiment->text.empty()) return {};
  const int repetitions = 2 * source.experiment->repetitions;
  if (repetitions > kMostRepetitions) return {};
  NextExperiment next;
  next.text = with_number(source.experiment->text, "repetitions", repetitions, "duration_s");
  next.reason = fmt::format("{} repetitions instead of {} halve the part of each estimate's variance that noise causes",
                            repetitions, source.experiment->repetitions);
  try {
    const auto read = config::parse_experiment(next.text, std::string(kNextExperimentFile), config::NamedFiles::leave);
    if (read.repetitions != repetitions) return {};
  } catch (const Error&) {
    return {};
  }
  return next;
}

}  // namespace eha::identify
