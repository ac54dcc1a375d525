// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/identify/source.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <span>
#include <system_error>
#include <utility>

#include "core/error.hpp"
#include "core/shell_word.hpp"
#include "daemon/importer/asked_command.hpp"
#include "daemon/importer/column_names.hpp"
#include "daemon/importer/import.hpp"
#include "daemon/importer/lone_rows.hpp"
#include "daemon/importer/output_findings.hpp"
#include "daemon/record/run_folder.hpp"
#include "daemon/record/run_header.hpp"
#include "ident/validation/loop_in_record.hpp"

namespace eha::identify {

namespace {

/// Of the import options a run accepts only --from and --to.
void refuse_options(const std::string& name, const importer::Options& options) {
  if (!importer::names_columns_or_times(options)) return;
  throw UsageError(
      fmt::format("{}: a run's columns and times are known; leave out --time, --input, --output, --delimiter, "
                  "--decimal, --thousands, --period, --input-unit, --output-unit, --input-late, --resample and "
                  "--keep-lone-rows",
                  name));
}

/// Says that an input goes beyond the volts of any valve amplifier, as one in millivolts does.
std::string implausible_volts(const ident::Record& record) {
  constexpr double kMost_V = 60.0;
  if (record.input_channel.unit != "V" || record.input.size() == 0) return {};
  const double greatest = record.input.cwiseAbs().maxCoeff();
  if (!(greatest > kMost_V)) return {};
  return fmt::format(
      "the input goes to {:.4g} V, more than a valve's amplifier takes: if these are millivolts, --input-unit mV says "
      "so, and gain and map are a thousand times off without it",
      greatest);
}

/// Leaves out the rows of a run before --from and after --to.
void cut(Source& source, const importer::Options& options) {
  if (!options.from_s && !options.to_s) return;
  ident::Record& record = source.record;
  const auto row_at = [&](double time_s) {
    return std::clamp<Eigen::Index>(std::llround((time_s - record.start_s) / record.step_s), 0, record.input.size());
  };
  const Eigen::Index first = options.from_s ? row_at(*options.from_s) : 0;
  const Eigen::Index last = options.to_s ? row_at(*options.to_s) : record.input.size();
  if (last - first < 2) {
    throw DataError(fmt::format("{}: {} rows lie between --from and --to; the run has {:.4g} to {:.4g} s", source.name,
                                std::max<Eigen::Index>(0, last - first), record.start_s,
                                record.start_s + record.step_s * static_cast<double>(record.input.size() - 1)));
  }
  record.input = record.input.segment(first, last - first).eval();
  record.output = record.output.segment(first, last - first).eval();
  record.unmeasured =
      ident::rows_within(record.unmeasured, static_cast<std::size_t>(first), static_cast<std::size_t>(last - first));
  record.start_s += record.step_s * static_cast<double>(first);
  // Repetitions are counted from the beginning.
  if (first > 0) source.repetition_samples = 0;
}

/// Names single wild samples of a run.
void name_lone_rows(Source& source) {
  const auto values = [](const Eigen::VectorXd& x) {
    return std::span<const double>(x.data(), static_cast<std::size_t>(x.size()));
  };
  const ident::Record& record = source.record;
  const std::vector<std::size_t> rows = importer::lone_rows(values(record.input), values(record.output));
  if (rows.empty()) return;
  const double first_s = record.start_s + record.step_s * static_cast<double>(rows.front());
  source.remarks.push_back(
      fmt::format("{}; a loose contact or a disturbed sensor does that, no motion; they are left in the record and "
                  "spoil a model: mend the sensor's wire and record again, or fit a part without them (--from, --to)",
                  importer::lone_rows_text(rows, values(record.output), first_s)));
}

}  // namespace

Source load_source(const std::string& name, const std::optional<std::string>& experiment_file,
                   const importer::Options& options, const importer::Progress& progress) {
  Source source;
  source.name = name;
  source.command = importer::command_that_made(options);
  // Checked before reading the record, which may be long; checking an experiment takes no time.
  if (experiment_file) source.experiment = config::load_experiment(*experiment_file);
  std::error_code ignored;
  if (!std::filesystem::is_directory(name, ignored)) {
    importer::Imported imported = importer::import_record(name, options, progress);
    source.record = std::move(imported.record);
    source.unmeasured = ident::unmeasured_of(source.record, imported.held);
    source.guess = std::move(imported.guess);
    source.remarks = std::move(imported.remarks);
    for (const ident::Channel& channel : {source.record.input_channel, source.record.output_channel}) {
      const std::string meant = importer::unit_meant(channel.unit);
      if (meant.empty()) continue;
      source.remarks.push_back(
          fmt::format("the unit \"{}\" of {} is none that eha knows and is kept as it is; if {} is meant, "
                      "correct the header or give --input-unit or --output-unit",
                      channel.unit, channel.name, meant));
    }
    if (std::string sentence = implausible_volts(source.record); !sentence.empty()) {
      source.remarks.push_back(std::move(sentence));
    }
    const std::filesystem::path folder = std::filesystem::absolute(name, ignored).parent_path();
    if (std::filesystem::path(name).filename().string().starts_with("data_") && record::is_run_folder(folder)) {
      source.is_of_run = true;
      source.remarks.push_back(fmt::format(
          "this is the thinned copy of a run's record, whose input between its rows is not held; the run has "
          "every row: `eha fit {}`",
          shell_word(std::filesystem::path(name).parent_path().empty()
                         ? folder.string()
                         : std::filesystem::path(name).parent_path().string())));
    }
    source.is_closed_loop = imported.is_closed_loop;
    source.exchange = std::move(imported.exchange);
    source.cut = imported.cut;
    source.frozen = std::move(imported.frozen);
    source.slow_rows = std::move(imported.slow_rows);
    if (const auto loop = ident::loop_in_record(source.record)) source.loop = *loop;
    source.without_gaps = imported.without_gaps;
    source.gaps = imported.gaps;
    source.repairs = std::move(imported.repairs);
    source.as_even = std::move(imported.as_even);
    if (source.experiment) {
      const double samples = std::round(source.experiment->duration_s / source.record.step_s);
      source.repetition_samples = static_cast<std::size_t>(samples);
    }
    return source;
  }
  refuse_options(name, options);
  if (!record::is_run_folder(name)) {
    throw DataError(
        fmt::format("{}: a folder without run.json or raw.ehalog is no run folder; expected one, or a file "
                    "with a record",
                    name));
  }
  record::LoadedRun run = record::read_run(name, options.to_s ? record::StillGoing::read : record::StillGoing::refuse);
  const double recorded_s = run.record.step_s * static_cast<double>(run.record.input.size());
  if (!run.manifest.outcome && recorded_s < *options.to_s) {
    throw DataError(fmt::format("{}: the run is still going, and its rows so far end at {:.4g} s, before --to {:.4g}",
                                name, recorded_s, *options.to_s));
  }
  source.record = std::move(run.record);
  source.run_folder = std::move(run.folder);
  source.opened = std::move(run.opened);
  source.rig_text = std::move(run.rig_text);
  source.outcome = run.outcome;
  source.units = record::rig_units(run.manifest.other);
  source.repetition_samples = run.samples_per_repetition;
  cut(source, options);
  source.unmeasured = ident::unmeasured_of(source.record);
  name_lone_rows(source);
  if (!source.experiment) {
    source.experiment = config::parse_experiment(run.experiment_text, fmt::format("{}/run.json (experiment)", name),
                                                 config::NamedFiles::leave);
  }
  return source;
}

void take_input_as_straight(Source& source) {
  if (source.run_folder) {
    throw UsageError(
        fmt::format("{}: the input of a run is held from tick to tick; leave out --intersample", source.name));
  }
  if (source.record.input.size() < 4) {
    throw DataError(fmt::format("{}: {} rows; --intersample foh needs four", source.name, source.record.input.size()));
  }
  source.record = ident::in_parts(source.record, ident::Intersample::straight);
  source.repetition_samples *= ident::kPartsOfARow;
  source.intersample = ident::Intersample::straight;
  source.slow_rows.clear();  // an input that moves between the rows is taken so now
}

std::optional<double> planned_s(const Source& source) {
  if (acquisition::is_whole(source.outcome) || !source.run_folder || !source.experiment) return std::nullopt;
  return source.experiment->duration_s * source.experiment->repetitions;
}

std::vector<std::string> warnings(const Source& source) {
  std::vector<std::string> sentences;
  if (!acquisition::is_whole(source.outcome)) {
    const auto whole_s = planned_s(source);
    sentences.push_back(fmt::format(
        "{} did not complete ({}); the fit uses the partial record{}", source.name,
        acquisition::to_text(source.outcome),
        whole_s ? fmt::format(", {:.3g} s of {:.3g} s",
                              static_cast<double>(source.record.output.size()) * source.record.step_s, *whole_s)
                : ""));
  }
  const ident::Unmeasured& unmeasured = source.unmeasured;
  if (unmeasured.rows > 0 && !source.run_folder) {
    sentences.push_back(fmt::format("{} of {} rows ({:.3g} %) were not measured and count for nothing in fit and tests",
                                    unmeasured.rows, unmeasured.of_rows, unmeasured.percent()));
    if (unmeasured.without_input > 0) {
      sentences.back() += fmt::format(
          "; in {} the input is missing: it is taken as straight from row to row, in gaps of {} rows or more as held, "
          "and where it switched there, the figures are less exact than their intervals say",
          unmeasured.without_input, ident::kRowsOfGap);
    }
  } else if (unmeasured.rows > 0) {
    sentences.push_back(
        fmt::format("{} of {} displacements ({:.3g} %) were not measured (late ticks, samples that the device did not "
                    "deliver, rows lost from a damaged journal) and count for nothing in fit and tests; raw.h5 flags "
                    "them, `eha runs show {}` counts them",
                    unmeasured.rows, unmeasured.of_rows, unmeasured.percent(), source.name));
  }
  return sentences;
}

std::vector<std::string> named_warnings(const std::vector<Source>& sources) {
  std::vector<std::string> named;
  for (const Source& source : sources) {
    std::vector<std::string> said = source.remarks;
    for (std::string& sentence : warnings(source)) said.push_back(std::move(sentence));
    for (const std::string& sentence : said) {
      named.push_back(sentence.find(source.name) == std::string::npos ? source.name + ": " + sentence : sentence);
    }
  }
  return named;
}

}  // namespace eha::identify
