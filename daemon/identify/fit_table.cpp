// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/identify/fit_table.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <iterator>
#include <utility>

#include "core/error.hpp"
#include "core/os/files.hpp"
#include "daemon/identify/identification.hpp"
#include "daemon/record/csv_field.hpp"
#include "daemon/record/number_table.hpp"
#include "daemon/record/record_csv.hpp"
#include "ident/signal/decimation.hpp"

namespace eha::identify {
namespace {

constexpr std::size_t kFixedColumns = 3;  // time, input, output
constexpr double kMostInTenDigits_s = 1e6;
constexpr std::string_view kResidual = "_residual";

std::vector<double> to_vector(const Eigen::VectorXd& values) { return {values.begin(), values.end()}; }

/// Returns the input at the compared rows: filtered like the output by the default procedure, unfiltered by the
/// paper's.
std::vector<double> applied_at(const ident::Record& record, const ident::FitOptions& options,
                               const Eigen::VectorXd& time_s) {
  const auto samples = static_cast<std::size_t>(record.input.size());
  const auto row_of = [&](double t) {
    const auto row = std::llround((t - record.start_s) / record.step_s);
    return static_cast<std::size_t>(std::clamp<long long>(row, 0, static_cast<long long>(samples) - 1));
  };
  if (options.procedure == ident::Procedure::standard) {
    const ident::Comparison compared =
        ident::compare_every(samples, static_cast<std::size_t>(std::max(1, options.decimation)),
                             ident::discarded_rows(options.discard_s, record.step_s));
    if (compared.count == static_cast<std::size_t>(time_s.size()) && row_of(time_s[0]) == compared.first) {
      return to_vector(ident::picked(record.input, compared));
    }
  }
  std::vector<double> values;
  for (const double t : time_s) values.push_back(record.input[static_cast<Eigen::Index>(row_of(t))]);
  return values;
}

/// Returns "io_valve_residual_in" without its end; empty if the column is not that of a residual.
std::string model_of_residual(const std::string& column, const std::string& unit) {
  const std::string end = unit.empty() ? std::string(kResidual) : std::string(kResidual) + "_" + unit;
  return column.size() > end.size() && column.ends_with(end) ? column.substr(0, column.size() - end.size()) : "";
}

void add_field(std::string& text, double value) {
  text += ',';
  if (std::isfinite(value)) fmt::format_to(std::back_inserter(text), "{:.7g}", value);
}

}  // namespace

const FitColumn* FitTable::find(std::string_view model) const {
  const auto at = std::find_if(models.begin(), models.end(), [&](const FitColumn& c) { return c.model == model; });
  return at == models.end() ? nullptr : &*at;
}

FitTable fit_table(const ident::Record& record, const ident::FitOptions& options,
                   const std::vector<IdentifiedModel>& models) {
  FitTable table{.input = record.input_channel,
                 .output = record.output_channel,
                 .time_s = {},
                 .applied = {},
                 .measured = {},
                 .models = {}};
  for (const IdentifiedModel& identified : models) {
    const ident::FitResult& result = identified.result;
    if (result.time_s.size() == 0) continue;
    if (table.time_s.empty()) {
      table.time_s = to_vector(result.time_s);
      table.applied = applied_at(record, options, result.time_s);
      table.measured = to_vector(result.measured);
    }
    if (!std::equal(result.time_s.begin(), result.time_s.end(), table.time_s.begin(), table.time_s.end())) continue;
    table.models.push_back({result.model.name, to_vector(result.simulated)});
  }
  return table;
}

std::string to_csv(const FitTable& table) {
  const std::string unit = table.output.unit.empty() ? "" : "_" + table.output.unit;
  std::string text = "time_s," + record::csv_name(record::header_from_channel(table.input)) + "," +
                     record::csv_name(record::header_from_channel(table.output));
  for (const FitColumn& model : table.models) {
    text += "," + record::csv_name(model.model + unit) + "," +
            record::csv_name(model.model + std::string(kResidual) + unit);
  }
  text += "\n";
  for (std::size_t row = 0; row < table.time_s.size(); ++row) {
    const int digits = std::abs(table.time_s[row]) < kMostInTenDigits_s ? 10 : 14;
    fmt::format_to(std::back_inserter(text), "{:.{}g}", table.time_s[row], digits);
    add_field(text, table.applied[row]);
    add_field(text, table.measured[row]);
    for (const FitColumn& model : table.models) {
      add_field(text, model.simulated[row]);
      add_field(text, table.measured[row] - model.simulated[row]);
    }
    text += "\n";
  }
  return text;
}

FitTable read_fit_table(const std::filesystem::path& path) {
  record::NumberTable numbers = record::read_number_table(path);
  const auto fail = [&] {
    throw DataError(os::shown(path) +
                    ": not the table of a fit; expected time_s, input, output, then each model's "
                    "output and residual; `eha fit` writes it");
  };
  if (numbers.names.size() < kFixedColumns || numbers.names.size() % 2 == 0 || numbers.names[0] != "time_s") fail();
  FitTable table{.input = record::channel_from_header(numbers.names[1]),
                 .output = record::channel_from_header(numbers.names[2]),
                 .time_s = std::move(numbers.columns[0]),
                 .applied = std::move(numbers.columns[1]),
                 .measured = std::move(numbers.columns[2]),
                 .models = {}};
  for (std::size_t i = kFixedColumns; i < numbers.names.size(); i += 2) {
    std::string model = model_of_residual(numbers.names[i + 1], table.output.unit);
    if (model.empty()) fail();
    table.models.push_back({std::move(model), std::move(numbers.columns[i])});
  }
  return table;
}

}  // namespace eha::identify
