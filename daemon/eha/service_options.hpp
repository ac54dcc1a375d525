// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <CLI/CLI.hpp>
#include <filesystem>
#include <optional>

#include "daemon/eha/commands.hpp"

namespace eha::cli {

/// --socket PATH.
CLI::Option* add_socket_option(CLI::App& app, std::filesystem::path& socket);
CLI::Option* add_socket_option(CLI::App& app, std::optional<std::filesystem::path>& socket);

/// The numbers of queued experiments.
CLI::Option* add_entries(CLI::App& app, ServiceCommand& service, const char* help);

/// `read`.
void add_read(CLI::App& app, ReadCommand& read);

/// The commands that only call a method of ehad: status, arm, disarm, stop, metrics, reload, queue. Parsing sets
/// `service.method`.
void add_service_commands(CLI::App& app, ServiceCommand& service);

}  // namespace eha::cli
