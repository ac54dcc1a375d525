// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

namespace CLI {
class App;
}

namespace eha::cli {

struct ParsedLine;

/// Adds `published` to the subcommands of `eha study`.
void add_study_published(CLI::App& study, ParsedLine& line);

}  // namespace eha::cli
