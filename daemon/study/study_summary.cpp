// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/study/study_summary.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>

namespace eha::study {
namespace {

constexpr double kNoGain = 0.1;  // points of R2 too small to report

const Cell* find(const std::vector<Cell>& cells, std::size_t plant, Treatment treatment) {
  const auto at = std::find_if(cells.begin(), cells.end(),
                               [&](const Cell& c) { return c.plant == plant && c.treatment == treatment; });
  return at == cells.end() ? nullptr : &*at;
}

std::string described(const Quartiles& q, const char* unit) {
  return fmt::format("{:+.2f} {} (quartiles {:+.2f} .. {:+.2f})", q.median, unit, q.lower, q.upper);
}

/// Describes the part of the paper procedure's gain that a treatment leaves.
std::string share_left(const Cell& published, const Cell& treated) {
  const double share = treated.gain.median / published.gain.median;
  if (published.gain.median <= kNoGain || !(share >= 0.0 && share <= 1.0)) return {};
  return fmt::format(", {:.0f} % of it", 100.0 * share);
}

std::string about_gain(const std::vector<Cell>& cells, const Cell& published) {
  const auto& plant = plant_kinds()[published.plant];
  std::string text = fmt::format("{}: by the paper's procedure FO scores {} above IO on the validation part",
                                 plant.title, described(published.gain, "points"));
  text += fmt::format("; {} of {} records reach the printed {:.2f} points.", published.gains_as_printed,
                      published.records, kPrintedGain);
  for (const Treatment treatment : {Treatment::bias, Treatment::history, Treatment::both}) {
    const Cell* treated = find(cells, published.plant, treatment);
    if (treated == nullptr) continue;
    const char* what = treatment == Treatment::bias      ? " With the bias removed it is "
                       : treatment == Treatment::history ? " With the history kept it is "
                                                         : " With both it is ";
    text += what + described(treated->gain, "points") + share_left(published, *treated) + ".";
  }
  return text;
}

std::string about_order(const std::vector<Cell>& cells, const Cell& published) {
  const auto& plant = plant_kinds()[published.plant];
  const Cell* both = find(cells, published.plant, Treatment::both);
  if (!plant.true_order || both == nullptr) return {};
  return fmt::format(
      "{}: the highest order is {:g}; FO estimates {:.3f} (quartiles {:.3f} .. {:.3f}) by the paper's procedure and "
      "{:.3f} ({:.3f} .. {:.3f}) by the default one.",
      plant.title, *plant.true_order, published.fo_order.median, published.fo_order.lower, published.fo_order.upper,
      both->fo_order.median, both->fo_order.lower, both->fo_order.upper);
}

/// Describes the plants with a gain of the printed size.
std::string about_bias(const std::vector<Cell>& cells) {
  std::size_t fits[2] = {0, 0};
  std::size_t gains[2] = {0, 0};
  for (const Cell& cell : cells) {
    const std::size_t treated = cell.treatment == Treatment::bias || cell.treatment == Treatment::both ? 1 : 0;
    fits[treated] += cell.records;
    gains[treated] += cell.gains_as_printed;
  }
  return fmt::format(
      "FO gains {:.2f} points or more in {} of {} pairs of fits that neglect the bias, and in {} of {} that do not.",
      kPrintedGain, gains[0], fits[0], gains[1], fits[1]);
}

std::string about_stability(const std::vector<Cell>& cells) {
  std::size_t records = 0;
  std::size_t io[2] = {0, 0};
  std::size_t fo[2] = {0, 0};
  for (const Cell& cell : cells) {
    if (cell.treatment != Treatment::published && cell.treatment != Treatment::both) continue;
    const std::size_t which = cell.treatment == Treatment::both ? 1 : 0;
    if (which == 0) records += cell.records;
    io[which] += cell.stable_io;
    fo[which] += cell.stable_fo;
  }
  return fmt::format(
      "Of {} records the paper's procedure gives a stable IO model on {} and a stable FO model on {}; the default "
      "procedure on {} and {}.",
      records, io[0], fo[0], io[1], fo[1]);
}

void add_fields(std::string& text, const FittedModel& model) {
  fmt::format_to(std::back_inserter(text), ",{:.6g},{:.6g},{:.6g},{},{},{:.6g},{:.6g}", model.estimation_r2_percent,
                 model.validation_r2_percent, model.validation_mse, model.stable ? 1 : 0, model.converged ? 1 : 0,
                 model.highest_order, model.input_bias_V);
}

}  // namespace

Quartiles quartiles(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  const auto at = [&](double share) {
    const double place = share * static_cast<double>(values.size() - 1);
    const auto below = static_cast<std::size_t>(place);
    const std::size_t above = std::min(below + 1, values.size() - 1);
    return std::lerp(values[below], values[above], place - static_cast<double>(below));
  };
  return {at(0.25), at(0.5), at(0.75)};
}

std::vector<Cell> cells_of(const PaperStudy& study) {
  std::vector<Cell> cells;
  for (std::size_t plant = 0; plant < plant_kinds().size(); ++plant) {
    for (const Treatment treatment : kTreatments) {
      Cell cell{
          .plant = plant, .treatment = treatment, .io_r2_percent = {}, .fo_r2_percent = {}, .gain = {}, .fo_order = {}};
      std::vector<double> io;
      std::vector<double> fo;
      std::vector<double> gain;
      std::vector<double> order;
      for (const StudyRow& row : study.rows) {
        if (row.plant != plant || row.treatment != treatment) continue;
        io.push_back(row.io.validation_r2_percent);
        fo.push_back(row.fo.validation_r2_percent);
        gain.push_back(row.gain());
        order.push_back(row.fo.highest_order);
        cell.gains_as_printed += row.gain() >= kPrintedGain ? 1 : 0;
        cell.stable_io += row.io.stable ? 1 : 0;
        cell.stable_fo += row.fo.stable ? 1 : 0;
      }
      cell.records = gain.size();
      if (gain.empty()) continue;
      cell.io_r2_percent = quartiles(std::move(io));
      cell.fo_r2_percent = quartiles(std::move(fo));
      cell.gain = quartiles(std::move(gain));
      cell.fo_order = quartiles(std::move(order));
      cells.push_back(cell);
    }
  }
  return cells;
}

std::vector<std::string> conclusions(const std::vector<Cell>& cells) {
  std::vector<std::string> sentences;
  for (const Cell& cell : cells) {
    if (cell.treatment == Treatment::published) sentences.push_back(about_gain(cells, cell));
  }
  for (const Cell& cell : cells) {
    if (cell.treatment != Treatment::published) continue;
    if (std::string text = about_order(cells, cell); !text.empty()) sentences.push_back(std::move(text));
  }
  if (!sentences.empty()) {
    sentences.insert(sentences.begin(), about_bias(cells));
    sentences.push_back(about_stability(cells));
  }
  sentences.emplace_back(
      "These are simulated plants with parameters 20 % about one set of values, under one input. The paper's record is "
      "not published: the study shows how the procedure fits known plants, not what the paper's rig is.");
  sentences.emplace_back(
      "\"History kept\" also simulates the input as it was held every millisecond, where the paper holds it for 40 ms, "
      "and estimates coefficients and orders of FO together, where the paper keeps those of IO.");
  return sentences;
}

std::string to_csv(const PaperStudy& study) {
  std::string text = "plant,seed,treatment,gain_points";
  for (const char* model : {"io", "fo"}) {
    text += fmt::format(
        ",{0}_estimation_r2_percent,{0}_validation_r2_percent,{0}_validation_mse_in2,{0}_stable,{0}_converged,"
        "{0}_highest_order,{0}_input_bias_V",
        model);
  }
  text += "\n";
  for (const StudyRow& row : study.rows) {
    text += fmt::format("{},{},{},{:.6g}", plant_kinds()[row.plant].name, row.seed, name_of(row.treatment), row.gain());
    add_fields(text, row.io);
    add_fields(text, row.fo);
    text += "\n";
  }
  return text;
}

}  // namespace eha::study
