// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/eha/report_options.hpp"

namespace eha::cli {
namespace {

constexpr const char* kReportFooter = R"(
Writes one HTML page that needs no other file and prints on A4: the recommended model and why, all models, measured and
simulated output with errors, frequency response, stability, residual, valve map, parameter intervals, timing and
provenance. A note beside each plot says what this record shows, what a good one looks like, and what to do.
A run's page goes to RUN/report.html, where `eha run` and `eha fit RUN` write it too; of model files to ./report.html.
With fit.csv and frequency_response.csv in the models' folder (`eha fit -o`) their plots are included.
The plots are drawn by gnuplot (Debian package gnuplot-nox); without it the page has none and says so.

Examples:
  eha report runs/latest
  eha report models/io.json models/fo.json -o comparison.html)";

constexpr const char* kPlotFooter = R"(
A run: measured output, its best models, errors and input over time. A record or another table of eha: its columns over
the first one. A model file: gain and phase with 95 % bounds, over the measured response if frequency_response.csv is
beside it. Without -o the plot is printed in characters. Needs gnuplot (Debian package gnuplot-nox).
Exit code 69: gnuplot is missing or failed.

Examples:
  eha plot runs/latest
  eha plot models/io.json -o bode.svg
  eha plot record.csv -o record.png)";

}  // namespace

void add_report(CLI::App& app, ReportCommand& report) {
  CLI::App* sub = app.add_subcommand("report", "Write a report with plots of a run or of models");
  sub->footer(kReportFooter);
  sub->add_option("sources", report.sources, "Run folder, or model files (JSON)")
      ->required()
      ->type_name("RUN|MODEL...");
  sub->add_option("-o,--output", report.output, "File to write")->type_name("FILE.html");
}

void add_plot(CLI::App& app, PlotCommand& plot) {
  CLI::App* sub = app.add_subcommand("plot", "Plot a run, a record or a model, on the terminal or into a file");
  sub->footer(kPlotFooter);
  sub->add_option("source", plot.source, "Run folder, CSV file or model file (JSON)")
      ->required()
      ->type_name("RUN|CSV|MODEL");
  sub->add_option("-o,--output", plot.output, "Picture to write; its name ends in .png, .svg or .pdf")
      ->type_name("FILE");
}

}  // namespace eha::cli
