// SPDX-License-Identifier: GPL-3.0-or-later
#include "config/service_config.hpp"

#include <filesystem>
#include <system_error>

#include "config/file_kind.hpp"
#include "config/toml_section.hpp"

namespace eha::config {

ServiceConfig load_service_config(const std::string& path) {
  std::error_code error;
  const std::filesystem::file_status status = std::filesystem::status(path, error);
  if (status.type() == std::filesystem::file_type::not_found) return {};
  return parse_service_config(read_config_file(path), path);
}

ServiceConfig parse_service_config(std::string_view text, const std::string& file_name) {
  Document document = parse_document(text, file_name);
  ServiceConfig config;
  Section root = Section::root(document);
  int schema = 0;
  root.integer("schema", schema, 1, 1);
  if (auto retention = root.section("retention", Need::optional)) {
    retention->number("disk_budget_GiB", config.disk_budget_GiB, Range::above(0.0), Need::optional);
    retention->finish();
  }
  if (auto worker = root.section("worker", Need::optional)) {
    worker->number("cpu_time_s", config.worker_cpu_time_s, Range::between(1.0, 1e6), Need::optional);
    worker->number("wall_time_s", config.worker_wall_time_s, Range::between(1.0, 1e6), Need::optional);
    worker->number("memory_MiB", config.worker_memory_MiB, Range::between(64.0, 1e7), Need::optional);
    worker->finish();
  }
  root.finish();
  document.issues.throw_if_any();
  return config;
}

}  // namespace eha::config
