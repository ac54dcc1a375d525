// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/identify/clipped_input_trial.hpp"

#include <fmt/format.h>

#include <array>
#include <cstddef>
#include <utility>

#include "daemon/identify/judging.hpp"
#include "daemon/identify/refit.hpp"
#include "ident/estimation/levels_beyond.hpp"
#include "ident/model/parameter_text.hpp"
#include "ident/signal/clipped_input.hpp"

namespace eha::identify {
namespace {

constexpr double kLessByBridges = 0.5;  // of the error
constexpr std::array kBridgeScales{0.7, 1.0, 1.4};

/// "-2.5 or 2.5 V": where a clipped input stands.
std::string ends_text(const ident::ClippedInput& ends, const ident::Record& record) {
  const std::string unit = ident::after_number(record.input_channel.unit);
  return ends.greatest && ends.least ? fmt::format("{:.4g} or {:.4g}{}", *ends.least, *ends.greatest, unit)
                                     : fmt::format("{:.4g}{}", ends.greatest.value_or(ends.least.value_or(0.0)), unit);
}

/// What is said of a clipped input. @param goes_on  "an input that goes on smoothly beyond"
WrongInput clipped_text(const ident::ClippedInput& ends, const ident::Record& record, const char* goes_on,
                        const std::string& structure, double over) {
  const auto without = longest_without(ends.runs, record.input.size());
  const std::string part = without ? cut_to(*without, record) : std::string();
  return WrongInput{
      fmt::format(
          "The input's column is clipped: {:.2g} % of the rows stand exactly at {}, and with {} {} errs {} times as "
          "much: the plant got more than was recorded, and gain and map come out wrong; record again with a wider "
          "range of the logger, or with a smaller input{}",
          ends.percent, ends_text(ends, record), goes_on, structure, ident::figure_text(over),
          part.empty() ? std::string() : fmt::format(", or fit the longest part without such rows ({})", part)),
      part};
}

/// Of a staircase: the levels of the holds at an end follow from the output.
std::optional<WrongInput> of_clipped_levels(const Source& source, const IdentificationTask& task,
                                            const std::vector<const IdentifiedModel*>& bases) {
  constexpr std::size_t kMostHolds = 200;
  constexpr int kRounds = 8;
  constexpr double kLeastBeyond = 0.8;  // of the holds
  if (source.intersample != ident::Intersample::held || task.record.input.size() > kMostTriedRows) return std::nullopt;
  const ident::Record& record = task.record;
  const auto ends = ident::clipped_levels(record.input);
  if (!ends || ends->runs.size() > kMostHolds) return std::nullopt;
  for (const IdentifiedModel* one : bases) {
    const std::vector<const IdentifiedModel*> base{one};
    const std::optional<Refit> given = least_error_of(base, record, task.options);
    if (!given) continue;
    ident::Record mended = record;
    Refit found = *given;
    double beyond = 0.0;
    for (int round = 0; round < kRounds; ++round) {
      ident::LevelsBeyond levels = ident::levels_beyond(record, mended.input, *ends, found.model);
      mended.input = std::move(levels.input);
      beyond = levels.share_beyond;
      const std::optional<Refit> next = least_error_of(base, mended, task.options);
      if (!next) break;
      found = *next;
    }
    if (!(found.error <= kLessByBridges * given->error) || beyond < kLeastBeyond) continue;
    return clipped_text(*ends, record, "levels that follow from the output where they stand so", found.name,
                        found.error / given->error);
  }
  return std::nullopt;
}

/// Of a smooth input: cubics over the rows at an end.
std::optional<WrongInput> of_clipped_crests(const Source& source, const IdentificationTask& task,
                                            const std::vector<const IdentifiedModel*>& bases) {
  if (source.intersample != ident::Intersample::held) return std::nullopt;
  const ident::Record& record = task.record;
  const auto ends = ident::clipped_input(record.input);
  if (!ends) return std::nullopt;
  const ident::Record tried = tried_rows(record, 1);
  const std::optional<Refit> given = least_error_of(bases, tried, task.options);
  std::optional<Refit> best;
  for (const double scale : kBridgeScales) {
    ident::Record mended = tried;
    mended.input = ident::bridged(record.input, *ends, scale).head(tried.input.size());
    const std::optional<Refit> found = least_error_of(bases, mended, task.options);
    if (found && (!best || found->error < best->error)) best = found;
  }
  if (!given || !best || !(best->error <= kLessByBridges * given->error)) return std::nullopt;
  return clipped_text(*ends, record, "an input that goes on smoothly beyond", best->name, best->error / given->error);
}

}  // namespace

std::optional<WrongInput> of_clipped_input(const Source& source, const IdentificationTask& task,
                                           const std::vector<const IdentifiedModel*>& bases) {
  if (auto found = of_clipped_crests(source, task, bases)) return found;
  return of_clipped_levels(source, task, bases);
}

std::string may_be_clipped(const Source& source, const IdentificationTask& task, const Identification& identification) {
  if (source.run_folder || source.is_of_run || is_loop_noted(identification) ||
      source.intersample != ident::Intersample::held) {
    return {};
  }
  const IdentifiedModel* first = recommended_model(identification);
  if (first != nullptr && !misses_something(first->result.model)) return {};
  auto ends = ident::clipped_input(task.record.input);
  if (!ends) ends = ident::clipped_levels(task.record.input);
  if (!ends) return {};
  return fmt::format(
      "the input stands exactly at {} for {:.2g} % of the rows, as where the range of a logger cuts it off. What the "
      "plant got beyond is not recorded then: gains come out too great, and dry friction, play or a dead time are told "
      "that are none; record with a wider range of the logger. Of a command that is limited there that is no fault",
      ends_text(*ends, task.record), ends->percent);
}

}  // namespace eha::identify
