// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/published/set_records.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <string>
#include <system_error>

#include "core/error.hpp"
#include "daemon/importer/imported_table.hpp"
#include "daemon/importer/roles.hpp"

namespace eha::published {
namespace {

std::string lower_case(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(), [](unsigned char c) { return std::tolower(c); });
  return text;
}

bool has_name(const std::filesystem::path& file, std::string_view name) {
  return lower_case("/" + file.generic_string()).ends_with(lower_case("/" + std::string(name)));
}

Eigen::VectorXd cut(const std::vector<double>& column, std::size_t first, std::size_t rows) {
  return Eigen::Map<const Eigen::VectorXd>(column.data(), static_cast<Eigen::Index>(column.size()))
      .segment(static_cast<Eigen::Index>(first), static_cast<Eigen::Index>(rows));
}

}  // namespace

std::vector<std::filesystem::path> files_below(const std::filesystem::path& folder) {
  std::vector<std::filesystem::path> files;
  try {
    for (const auto& entry : std::filesystem::recursive_directory_iterator(folder)) {
      if (entry.is_regular_file()) files.push_back(entry.path());
    }
  } catch (const std::filesystem::filesystem_error& error) {
    const std::string text = fmt::format("{}: {}", folder.string(), error.code().message());
    if (error.code() == std::errc::permission_denied) throw PermissionError(text);
    throw IoError(text);
  }
  std::sort(files.begin(), files.end());
  return files;
}

std::filesystem::path found(const Part& part, const std::vector<std::filesystem::path>& files) {
  for (const std::string_view name : part.files) {
    const auto at = std::find_if(files.begin(), files.end(), [&](const auto& file) { return has_name(file, name); });
    if (at != files.end()) return *at;
  }
  return {};
}

ident::Record read_part(const Part& part, const std::filesystem::path& file, double period_s) {
  importer::Options options;
  options.input = std::string(part.input);
  options.output = std::string(part.output);
  options.period_s = period_s;
  const auto table = importer::open_table(file, options);
  importer::Selection selection;
  try {
    const importer::Roles roles = importer::find_record(*table, file, options);
    selection.columns = {roles.input, roles.output.value()};
  } catch (const UsageError& error) {
    throw DataError(fmt::format("{}: not the published file: {}", file.string(), error.what()));
  }
  const importer::Rows rows = table->read(selection, {});
  const std::size_t wanted = part.rows > 0 ? part.rows : rows.count() - std::min(rows.count(), part.first);
  if (wanted == 0 || part.first + wanted > rows.count()) {
    throw DataError(fmt::format("{}: not the published file: expected at least {} rows, got {}", file.string(),
                                part.first + std::max<std::size_t>(wanted, 1), rows.count()));
  }
  ident::Record record;
  record.step_s = period_s;
  record.input = cut(rows.columns[0], part.first, wanted);
  record.output = cut(rows.columns[1], part.first, wanted);
  record.input_channel = {"input", ""};
  record.output_channel = {"output", ""};
  return record;
}

}  // namespace eha::published
