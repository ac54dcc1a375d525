// SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>
#include <vector>

#include "config/controller_config.hpp"
#include "config/rig_config.hpp"
#include "core/os/files.hpp"
#include "core/shell_word.hpp"
#include "core/text.hpp"
#include "daemon/eha/command.hpp"
#include "daemon/eha/command_list.hpp"
#include "daemon/eha/controller_argument.hpp"
#include "daemon/eha/import_options.hpp"
#include "daemon/eha/model_argument.hpp"
#include "daemon/eha/next_command.hpp"
#include "daemon/eha/run_argument.hpp"
#include "daemon/eha/track_report.hpp"
#include "daemon/identify/fit_table.hpp"
#include "daemon/identify/source.hpp"
#include "daemon/importer/asked_command.hpp"
#include "daemon/plot/envelope.hpp"
#include "daemon/plot/gnuplot.hpp"
#include "daemon/record/manifest.hpp"
#include "daemon/record/number_table.hpp"
#include "daemon/record/own_file.hpp"
#include "daemon/record/record_csv.hpp"
#include "daemon/record/run_folder.hpp"
#include "daemon/record/run_header.hpp"
#include "daemon/report/display.hpp"
#include "daemon/report/figures.hpp"
#include "daemon/report/subject.hpp"
#include "daemon/track/track_result.hpp"
#include "daemon/tune/controller_page.hpp"
#include "ident/model/engineering_form.hpp"
#include "ident/model/parameter_text.hpp"
#include "ident/validation/output_unit.hpp"
#include "ident/validation/verdict.hpp"
#include "ident/validation/verdict_phrases.hpp"

namespace eha::cli {
namespace {

namespace fs = std::filesystem;

constexpr const char* kPlotFooter = R"(
What is drawn:
  run                 over time the measured output with the recommended model and its runner-up, their errors (measured
                      less model), the input; right of a dashed line nothing was estimated, and a trip is marked
  fit.csv             the same, of a table without its models beside it with the two of least error
  run of `eha track`  over time reference and rod, the error (rod less reference), the command; means over 50 ms, and
                      of a trial that tripped the readings, with the trip marked
  record              output and input over time; --period for one without times, as for `eha import`
  another table       its columns over the first one
  model               gain and phase over frequency, with 95 % bounds (narrow ones are hidden by the line) within the
                      usable band, which is grey, and dotted beyond it; the measured response and its noise if
                      frequency_response.csv is beside it, the model behind its map at the measured lines (crosses), and
                      the measured gain over the model's on a scale of its own. Its grade and its parameters with their
                      95 % intervals are printed
  controller          over time a step on its twin: position and reference, error, command; its report has the rest
Without -o the plot is printed in characters. Needs gnuplot (Debian package gnuplot-nox).
Exit code 69: gnuplot is missing or failed.

Examples:
  eha plot runs/latest
  eha plot models/io.json -o bode.svg
  eha plot record.csv -o record.png
  eha plot logger.txt --period 0.001 --input 2 --output 3
  eha plot axis.toml -o step.svg)";

struct PlotCommand {
  std::string source = {};                           ///< run folder, CSV, model or controller file
  std::vector<std::string> sources = {};             ///< as typed; one alone is drawn
  importer::Options import = {};                     ///< of a record of another program
  std::optional<std::filesystem::path> output = {};  ///< none: in characters on standard output
};

constexpr std::size_t kMostColumnsInPanel = 6;  // of a CSV file
constexpr std::size_t kMostNamesOfAxis = 2;     // columns named at the y axis; the key names more
constexpr std::size_t kRowsOfPanel = 16;        // characters
constexpr std::size_t kWidest = 160;

struct FileFormat {
  std::string_view extension;
  plot::Format format;
};
constexpr std::array<FileFormat, 3> kFormats{
    {{".png", plot::Format::png}, {".svg", plot::Format::svg}, {".pdf", plot::Format::pdf}}};

plot::Format format_of(const fs::path& path) {
  const auto at = std::find_if(kFormats.begin(), kFormats.end(),
                               [&](const FileFormat& known) { return path.extension() == known.extension; });
  if (at == kFormats.end()) {
    throw UsageError(fmt::format("-o {}: the name must end in .png, .svg or .pdf", shortened(path.string(), 200)));
  }
  return at->format;
}

/// "integrator_lag_valve (usable)".
std::string name_and_grade(const ident::Model& model) {
  return model.verdict ? fmt::format("{} ({})", model.name, ident::verdict_word(*model.verdict)) : model.name;
}

/// "20260101T120000Z-paper, simulated rig: integrator_lag_valve (usable), recommended, and its runner-up".
/// @param names  of the drawn models, the first one recommended where there is a recommendation
std::string title_of_fit(const std::string& of_what, const report::Subject& subject,
                         const std::vector<std::string>& names) {
  std::string title = of_what + ": ";
  for (const report::ReportedModel& reported : subject.models) {
    if (reported.model.name == names.front()) title += name_and_grade(reported.model);
  }
  if (subject.has_recommendation) title += names.size() > 1 ? ", recommended, and its runner-up" : ", recommended";
  return title;
}

plot::Figure of_run(const std::string& folder, const Console& console) {
  if (record::is_run_folder(folder) && record::purpose_of(record::read_manifest(folder)) == record::Purpose::tracking) {
    const track::TrackResult result = track::played_track(record::OpenRun(folder));
    const std::string name = result.folder.filename().string();
    const DisplayUnit unit = console.unit(result.units);
    if (!result.trip_s) return tune::motion_figure(trace_of(result), name, unit);
    report::Subject trial;
    trial.track = table_of(result);
    plot::Figure figure = report::ended_trial_figure(report::in_unit(std::move(trial), unit).track, name);
    report::mark_trip(figure, *result.trip_s);
    return figure;
  }
  report::Subject loaded = report::load_run(folder);
  const DisplayUnit unit = console.unit(record::rig_units(*loaded.manifest));
  const report::Subject subject = report::in_unit(std::move(loaded), unit);
  std::vector<std::string> names;
  for (const report::ReportedModel* reported : subject.pictured()) {
    if (subject.fit.find(reported->model.name) != nullptr) names.push_back(reported->model.name);
  }
  if (names.empty() && !subject.record) throw DataError(folder + ": nothing to plot; the run holds no record");
  const auto& rig = subject.part("rig", "name");
  const std::string title = subject.name + (rig.is_string() ? ", " + rig.get<std::string>() : std::string());
  plot::Figure figure =
      names.empty() ? report::record_figure(*subject.record, title)
                    : report::fit_figure(subject.fit, names, subject.split_s(), title_of_fit(title, subject, names));
  if (names.empty()) {
    const ident::Record& record = *subject.record;
    const double last = static_cast<double>(record.output.size() - 1);
    report::draw_limits(subject, {record.start_s, record.start_s + last * record.step_s},
                        {record.output.data(), static_cast<std::size_t>(record.output.size())},
                        record.output_channel.unit, figure.panels.front());
  } else if (!subject.fit.time_s.empty()) {
    report::draw_limits(subject, {subject.fit.time_s.front(), subject.fit.time_s.back()}, subject.fit.measured,
                        subject.fit.output.unit, figure.panels.front());
    report::name_left_out(subject, figure);
  }
  const auto trip_s = subject.trip_s();
  if (trip_s && !names.empty() && subject.record) report::add_rest(figure, subject.fit, *subject.record);
  if (trip_s) report::mark_trip(figure, *trip_s);
  return figure;
}

plot::Figure of_model(const std::string& file, const DisplayUnit& unit) {
  const report::Subject subject = report::in_unit(report::load_models({file}), unit);
  const record::NumberTable* response = subject.response ? &*subject.response : nullptr;
  const ident::Model& model = subject.models.front().model;
  const std::string record = fs::path(record_of(model)).filename().string();
  const std::string title = name_and_grade(model) + (record.empty() ? "" : ", fitted to " + record);
  return report::bode_figure({&subject.models.front()}, response, title, &subject.fit);
}

/// Draws the step of a controller's trial.
plot::Figure of_controller(const std::string& file, const Console& console) {
  const tune::ControllerSubject subject = controller_subject(config::load_controller(file));
  if (!subject.trace) throw DataError(fmt::format("{}: nothing to plot; {}", file, subject.why_without_plots));
  return tune::step_figure(*subject.trace, subject.controller,
                           console.unit(rig_units_of_controller(subject.controller)));
}

/// Returns a file's name, preceded by that of its run, if any.
std::string title_of(const std::string& file) {
  const fs::path path(file);
  const fs::path folder = path.has_parent_path() ? path.parent_path() : fs::path(".");
  std::error_code ignored;
  const fs::path whole = fs::canonical(folder, ignored);
  const bool is_of_run = record::is_run_folder(folder) && !whole.empty();
  return is_of_run ? fmt::format("{}, {}", whole.filename().string(), path.filename().string())
                   : path.filename().string();
}

/// Draws the fit.csv of judged models as their report does: the recommended one and its runner-up, with the end of the
/// estimating part; none where no model of the table is beside it.
std::optional<plot::Figure> of_judged_table(const std::string& file, const identify::FitTable& table,
                                            const DisplayUnit& unit) {
  const fs::path path(file);
  const fs::path folder = path.has_parent_path() ? path.parent_path() : fs::path(".");
  if (path.filename() != identify::kFitFile) return std::nullopt;
  try {
    std::vector<fs::path> models;
    if (!record::is_run_folder(folder)) {
      for (const auto& entry : fs::directory_iterator(folder)) {
        const bool is_of_table =
            entry.path().extension() == ".json" && table.find(entry.path().stem().string()) != nullptr;
        if (is_of_table && entry.is_regular_file() && !entry.is_symlink()) models.push_back(entry.path());
      }
      if (models.empty()) return std::nullopt;
    }
    std::sort(models.begin(), models.end());
    const report::Subject subject =
        report::in_unit(models.empty() ? report::load_run(folder) : report::load_models(models), unit);
    std::vector<std::string> names;
    for (const report::ReportedModel* reported : subject.pictured()) {
      if (subject.fit.find(reported->model.name) != nullptr) names.push_back(reported->model.name);
    }
    if (names.empty() || !subject.has_recommendation) return std::nullopt;
    return report::fit_figure(subject.fit, names, subject.split_s(), title_of_fit(title_of(file), subject, names));
  } catch (const Error&) {
    return std::nullopt;  // a file beside the table that is no model: the table alone is drawn
  }
}

/// Draws fit.csv and frequency_response.csv, which have their own figures; none for another table.
std::optional<plot::Figure> of_known_table(const std::string& file, const record::NumberTable& table,
                                           const std::string& rig_units, const DisplayUnit& unit) {
  report::Subject subject;
  const fs::path folder = fs::path(file).has_parent_path() ? fs::path(file).parent_path() : fs::path(".");
  if (table.find("gain_dB") != nullptr && table.find("phase_deg") != nullptr && record::is_run_folder(folder)) {
    subject = report::load_run(folder);
    subject.response = table;
    subject = report::in_unit(std::move(subject), unit);
    if (!subject.models.empty())
      return report::bode_figure(subject.pictured(), &*subject.response, title_of(file), &subject.fit);
    subject = {};
  }
  if (table.find("gain_dB") != nullptr && table.find("phase_deg") != nullptr) {
    subject.response = table;
    // Only a run gives the unit of the gain.
    if (!rig_units.empty()) subject.record.emplace().output_channel = {"displacement", "in"};
    subject = report::in_unit(std::move(subject), unit);
    const std::string gain_unit = subject.record ? subject.record->output_channel.unit + "/V" : "";
    return report::response_figure(*subject.response, gain_unit, title_of(file));
  }
  try {
    subject.fit = identify::read_fit_table(file);
  } catch (const DataError&) {
    return std::nullopt;
  }
  if (subject.fit.models.empty()) return std::nullopt;
  if (auto figure = of_judged_table(file, subject.fit, unit)) return figure;
  return report::fit_table_figure(report::in_unit(std::move(subject), unit).fit, title_of(file));
}

/// Draws a panel for each unit, in the order of the columns; the first column is x.
plot::Figure of_table(const record::NumberTable& table, const std::string& name, const DisplayUnit& unit) {
  plot::Figure figure{.title = name, .panels = {}};
  std::vector<std::string> units;
  const ident::Channel x = record::channel_from_header(table.names.front());
  for (std::size_t i = 1; i < table.names.size(); ++i) {
    ident::Channel column = record::channel_from_header(table.names[i]);
    std::vector<double> values = table.columns[i];
    for (double& value : values) value *= unit.factor(column.unit);
    column.unit = unit.of(column.unit);
    auto at = std::find(units.begin(), units.end(), column.unit);
    if (at == units.end()) {
      at = units.insert(units.end(), column.unit);
      figure.panels.push_back({.x_label = "", .y_label = column.unit.empty() ? "" : "[" + column.unit + "]"});
      figure.panels.back().log_x = x.name == "frequency";
    }
    plot::Panel& panel = figure.panels[static_cast<std::size_t>(at - units.begin())];
    if (panel.series.size() == kMostColumnsInPanel) continue;
    plot::Points points = plot::envelope(table.columns.front(), values);
    const int style = static_cast<int>(panel.series.size()) + 1;
    const plot::Series line{.label = column.name,
                            .x = std::move(points.x),
                            .y = std::move(points.y),
                            .mark = plot::Mark::line,
                            .style = style};
    // Volts are played and held until the next row.
    // Of a thinned curve the stairs would be coarser than the rows.
    const bool is_whole = line.x.size() == table.rows();
    panel.series.push_back(column.unit == "V" && x.name == "time" && is_whole ? report::held(line) : line);
  }
  for (plot::Panel& panel : figure.panels) {
    if (panel.series.size() > kMostNamesOfAxis) continue;
    std::string names;
    for (const plot::Series& series : panel.series) names += (names.empty() ? "" : ", ") + series.label;
    panel.y_label = names + (panel.y_label.empty() ? "" : " ") + panel.y_label;
  }
  if (figure.panels.empty()) throw DataError(name + ": one column alone; expected time_s and another one");
  figure.panels.back().x_label = report::axis_label(x);
  return figure;
}

/// The first line of a CSV file that is no comment; empty where it cannot be read.
std::string header_of(const std::string& file) {
  constexpr std::size_t kEnough = 4096;
  std::string head(kEnough, ' ');
  try {
    head.resize(os::read_up_to(os::open_regular_file(file), head.data(), head.size(), file));
  } catch (const Error&) {
    return {};
  }
  for (std::size_t at = 0; at < head.size();) {
    const std::size_t end = std::min(head.find('\n', at), head.size());
    if (head[at] != '#') return head.substr(at, end - at);
    at = end + 1;
  }
  return {};
}

/// Whether a CSV file is one that eha writes: its first column is known, so it needs no importer.
bool is_own_table(const std::string& file) {
  const std::string header = header_of(file);
  return header.starts_with("time_s,") || header.starts_with("frequency_Hz,") || header.starts_with("q,");
}

/// Refuses a table of figures that eha writes for a spreadsheet: it has no curve, and its rows would be taken for those
/// of a record. @throws DataError
void require_curves(const std::string& file) {
  const std::string header = header_of(file);
  if (header.starts_with("record,source,model,")) {
    throw DataError(
        fmt::format("{}: a table of `eha batch`, a row a model, without curves; report.html of that folder draws its "
                    "parameters over the records",
                    file));
  }
  if (header.starts_with("part,figure,value,")) {
    throw DataError(
        fmt::format("{}: a table of figures of an axis, without curves; `eha plot` of its run or of the controller's "
                    "file (.toml) draws the axis",
                    file));
  }
}

/// Draws a record of another program, or a part of one.
plot::Figure of_record(const PlotCommand& command, Console& console) {
  identify::Source source =
      identify::load_source(command.source, std::nullopt, command.import, console.progress_callback());
  console.end_progress();
  print_import(source.guess, source.remarks, source.repairs, console);
  const DisplayUnit unit = console.unit(source.units);
  ident::Record& record = source.record;
  record.output *= unit.factor(record.output_channel.unit);
  record.output_channel.unit = unit.of(record.output_channel.unit);
  return report::record_figure(record, title_of(command.source));
}

plot::Figure figure_of(const PlotCommand& command, Console& console) {
  const std::string& source = command.source;
  std::error_code ignored;
  if (importer::says_how_to_read(command.import)) return of_record(command, console);
  record::require_no_link_of_others(source);
  if (fs::is_directory(source, ignored)) return of_run(source, console);
  if (is_controller_file(source)) return of_controller(source, console);
  if (fs::path(source).extension() == ".json") return of_model(source, console.unit(rig_units_of_model(source)));
  if (fs::is_regular_file(source, ignored)) require_curves(source);  // a pipe is read once
  if (is_own_table(source)) {
    const record::NumberTable table = record::read_number_table(source);
    const std::string rig_units = rig_units_of_model(source);
    const DisplayUnit unit = console.unit(rig_units);
    if (auto figure = of_known_table(source, table, rig_units, unit)) return *figure;
    return of_table(table, title_of(source), unit);
  }
  return of_record(command, console);
}

/// The grade and the usable band of a model file, then "K  0.1305 in/(V s)  (95 %: 0.1297 to 0.1313 in/(V s))" of each
/// estimated parameter of a model file, a line each; empty for other sources.
std::string parameters_text(const std::string& source, const Console& console) {
  std::error_code ignored;
  if (fs::is_directory(source, ignored) || fs::path(source).extension() != ".json") return {};
  const ident::Model model = in_unit(read_model(source), console.unit(rig_units_of_model(source)));
  std::string grade;
  if (model.verdict) {
    const auto& band = model.verdict->usable_band;
    grade = fmt::format("{}: {}; {}\n", model.name, ident::verdict_word(*model.verdict),
                        band ? fmt::format("usable from {:.3g} to {:.3g} Hz, no record tests what is beyond",
                                           band->lowest_Hz, band->highest_Hz)
                             : "no usable band: no part of the picture is tested by its record");
  }
  std::string text;
  for (const ident::ParameterEstimate& p : model.parameters) {
    if (p.fixed || !(p.std > 0.0)) continue;
    const std::string unit = ident::unit_of(p, model);
    text += fmt::format("{:<20} {}{}  (95 %: {}{}{})\n", p.name, ident::rounded_to(p.value, ident::half_width95(p)),
                        unit.empty() ? "" : " " + unit, ident::interval_text(p), unit.empty() ? "" : " ", unit);
  }
  if (text.empty()) return grade;
  const bool is_least = model.verdict && may_miss_a_part(*model.verdict);
  return grade + text +
         (is_least ? "95 %: by noise alone; a part of the plant that the model may miss adds an error of its own\n"
                   : "");
}

/// The fit of the record that is drawn, read by the same options.
std::string fit_of(const PlotCommand& command) {
  constexpr std::string_view kPlot = " plot ";
  const std::string folder = shell_word(free_name("models"));
  importer::Options asked = command.import;
  const std::size_t at = asked.command.find(kPlot);
  if (at == std::string::npos) return "eha fit " + shell_word(command.source) + " -o " + folder;
  asked.command.replace(at, kPlot.size(), " fit ");
  return importer::command_with(asked, command.source, "-o " + folder);
}

/// What usually follows a picture of this source; empty where nothing does, as after a table of figures.
std::string next_after_plot(const PlotCommand& command) {
  const std::string& source = command.source;
  std::error_code ignored;
  const std::string word = shell_word(source);
  if (record::is_run_folder(source)) return report_of_run(source, "eha runs show " + word);
  if (fs::is_directory(source, ignored)) return {};
  if (is_controller_file(source))
    return suggest::track(access_of_controller(source, config::load_controller(source)), source);
  if (fs::path(source).extension() == ".json") return "eha report " + word;
  if (!is_own_table(source)) return fit_of(command);
  const record::NumberTable table = record::read_number_table(source);
  const auto has = [&](std::string_view name) {
    return std::any_of(table.names.begin(), table.names.end(),
                       [&](const std::string& n) { return n.starts_with(name); });
  };
  return has("time_s") && has("voltage_") && has("displacement_") ? fit_of(command) : std::string();
}

plot::CharacterSize terminal_size(std::size_t panels) {
  plot::CharacterSize size{.columns = 79, .rows = 0};
  winsize window{};
  if (ioctl(STDOUT_FILENO, TIOCGWINSZ, &window) == 0 && window.ws_col > 20) {
    size.columns = std::min<std::size_t>(window.ws_col - 1U, kWidest);
  }
  size.rows = std::max<std::size_t>(24, kRowsOfPanel * panels);
  return size;
}

/// An earlier version took --output for the picture, and no column has such a name.
PlotCommand as_meant(PlotCommand command) {
  if (command.output || !command.import.output) return command;
  const std::string ending = fs::path(*command.import.output).extension().string();
  const bool is_picture =
      std::any_of(kFormats.begin(), kFormats.end(), [&](const FileFormat& known) { return ending == known.extension; });
  if (!is_picture) return command;
  command.output = *command.import.output;
  command.import.output.reset();
  return command;
}

/// @throws UsageError  several are named
void require_one(const std::vector<std::string>& sources) {
  if (sources.size() < 2) return;
  std::string all;
  for (const std::string& source : sources) all += shell_word(source) + " ";
  throw UsageError(fmt::format(
      "one picture is of one source, {} are named; models, runs or records over one another: `eha compare {}-o {}`",
      sources.size(), all, shell_word(free_name("compared.svg"))));
}

ExitCode execute(const PlotCommand& given, Console& console) {
  PlotCommand command = as_meant(given);
  require_one(command.sources);
  command.source = command.sources.front();
  // Checked before the file is read, which may take a while.
  if (command.output) static_cast<void>(format_of(*command.output));
  const plot::Figure figure = figure_of(command, console);
  if (!command.output) {
    console.print_content(plot::draw_in_characters(figure, terminal_size(figure.panels.size())) +
                          parameters_text(command.source, console));
    if (const std::string next = next_after_plot(command); !next.empty()) console.next_step(next);
    return ExitCode::ok;
  }
  os::write_file_atomically(*command.output, plot::draw(figure, format_of(*command.output)));
  console.print_json({{"schema", "eha-plot/1"}, {"file", command.output->string()}});
  console.print(parameters_text(command.source, console) + fmt::format("written: {}", command.output->string()));
  console.next_step("xdg-open " + shell_word(command.output->string()));
  return ExitCode::ok;
}

}  // namespace

void add_plot(CLI::App& app, ParsedLine& line) {
  CLI::App* sub =
      app.add_subcommand("plot", "Plot a run, a record, a model or a controller, on the terminal or into a file");
  sub->footer(kPlotFooter);
  auto& plot = options_of<PlotCommand>(*sub, line);
  takes_run_name(
      sub->add_option("source", plot.sources, "One run folder, CSV file, model file (JSON) or controller file"), line,
      Newer::of_any_purpose)
      ->required()
      ->type_name("RUN|CSV|MODEL|CONTROLLER");
  add_import_options(*sub, line, plot.import, ImportedColumns::record);
  sub->add_option("-o", plot.output, "Picture to write; its name ends in .png, .svg or .pdf (--output: a column)")
      ->type_name("FILE");
}

}  // namespace eha::cli
