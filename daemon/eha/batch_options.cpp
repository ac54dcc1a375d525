// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/eha/batch_options.hpp"

#include <charconv>
#include <string>
#include <string_view>

namespace eha::cli {
namespace {

constexpr const char* kBatchFooter = R"(
Fits and judges many records under the same rules, each with `eha fit` in a process of its own, as many at a time as
there are processors. SOURCE is a run folder, a file with a record, a folder of both, or a list: a file *.list with one
path a line. What follows -- are options of `eha fit`; --experiment makes one experiment's rules apply to all.
-o DIR holds batch.json (rules and records), records/ID/ (result.json and the models of each), table.csv and table.json.
After Ctrl-C or a kill the same command continues the batch. Outliers among the records are named.
--shard I/N fits every N-th record only, for N machines. Parts may share a folder; `eha batch merge` makes their table.
Exit code 0: every record judged, accepted or not; 10: some cannot be read or fitted, the table's text says why.

Examples:
  eha batch runs -o judged
  eha batch pumps/*.csv -o judged -- --model io --decimate 40
  eha batch bench.list -o judged -- --experiment config/experiments/paper.toml
  eha batch runs -o part2 --shard 2/4
  eha batch merge part1 part2 part3 part4 -o judged)";

constexpr const char* kMergeFooter = R"(
Puts the parts of one batch together and writes table.csv and table.json: the same bytes as on one machine.

Examples:
  eha batch merge judged
  eha batch merge part1 part2 -o judged)";

/// "2/4". @returns whether it is one
bool read_shard(const std::string& text, batch::Shard& shard) {
  const std::size_t slash = text.find('/');
  if (slash == std::string::npos) return false;
  const auto read = [](std::string_view part, std::size_t& value) {
    const auto [end, error] = std::from_chars(part.data(), part.data() + part.size(), value);
    return error == std::errc() && end == part.data() + part.size();
  };
  const std::string_view view = text;
  return read(view.substr(0, slash), shard.number) && read(view.substr(slash + 1), shard.count) && shard.number >= 1 &&
         shard.number <= shard.count && shard.count <= 100'000;
}

}  // namespace

void add_batch(CLI::App& app, BatchCommands& commands) {
  CLI::App* sub = app.add_subcommand("batch", "Fit and judge many records under the same rules");
  sub->fallthrough();
  sub->footer(kBatchFooter);
  sub->add_option("source", commands.batch.sources, "Run folders, files, folders of them, lists (*.list)")
      ->type_name("SOURCE ...");
  sub->add_option("-o,--output", commands.batch.output, "Folder of the batch (default batch)")->type_name("DIR");
  sub->add_option("--jobs", commands.batch.jobs, "Records at a time (default: the processors)")
      ->type_name("N")
      ->check(CLI::Range(std::size_t{1}, std::size_t{1024}).description(""));
  sub->add_option_function<std::string>(
         "--shard",
         [&commands](const std::string& text) {
           if (!read_shard(text, commands.batch.shard)) {
             throw CLI::ValidationError("--shard", "expected I/N with I from 1 to N, got \"" + text + "\"");
           }
         },
         "Every N-th record only, from the I-th")
      ->type_name("I/N");
  CLI::App* merge = sub->add_subcommand("merge", "Put the parts of a batch together");
  merge->footer(kMergeFooter);
  merge->add_option("folder", commands.merge.folders, "Folders of the parts")->required()->type_name("DIR ...");
  merge->add_option("-o,--output", commands.merge.output, "Folder of the whole (default: the first)")->type_name("DIR");
}

}  // namespace eha::cli
