// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/report/report.hpp"

#include <fmt/format.h>

#include <set>

#include "core/os/files.hpp"
#include "daemon/record/manifest.hpp"
#include "daemon/report/display.hpp"
#include "daemon/report/html.hpp"
#include "daemon/report/section.hpp"

namespace eha::report {
namespace {

std::string subtitle(const Subject& subject) {
  if (!subject.manifest) {
    std::set<std::string> records;
    for (const ReportedModel& reported : subject.models) {
      const auto record = reported.model.provenance.find("record");
      if (record != reported.model.provenance.end() && !record->second.empty()) records.insert(record->second);
    }
    const std::string of = records.empty()       ? "a record that the files do not name"
                           : records.size() == 1 ? "the record " + *records.begin()
                                                 : fmt::format("{} records", records.size());
    return fmt::format("<p class=\"subtitle\">From model files of {}{}.</p>\n", escaped(of),
                       subject.written.empty() ? "" : ", written " + escaped(subject.written) + " UTC");
  }
  const auto text = [](const nlohmann::ordered_json& json) {
    return json.is_string() ? json.get<std::string>() : std::string("unknown");
  };
  return fmt::format("<p class=\"subtitle\">The experiment {} on {}, started {}; outcome: {}</p>\n",
                     escaped(text(subject.part("experiment", "name"))), escaped(text(subject.part("rig", "name"))),
                     escaped(utc_text(text(subject.part("utc_start")))), escaped(text(subject.part("outcome"))));
}

}  // namespace

Page page_of(const Subject& subject) {
  if (subject.next_step().first == ident::FirstStep::look_at_sensor) {
    // Pictures and remarks of models of noise would say something about them.
    std::vector<Section> sections{time_section(subject), timing_section(subject), manifest_section(subject)};
    for (Section& section : sections) section.folded = &section != &sections.front();
    for (Item& item : sections.front().items) item.remark = {};
    return assembled(subject.name, subtitle(subject) + verdict(subject) + list(subject.notes), sections,
                     subject.access());
  }
  std::vector<Section> sections{time_section(subject), models_section(subject), frequency_section(subject),
                                step_section(subject), valve_section(subject)};
  // What is looked up, once the first pages have said what to do. Without a model it is what there is to say.
  for (Section section :
       {stability_section(subject), residual_section(subject), parameter_section(subject),
        other_models_section(subject), paper_section(subject), timing_section(subject), manifest_section(subject)}) {
    section.folded = !subject.models.empty();
    sections.push_back(std::move(section));
  }
  return assembled(subject.name, subtitle(subject) + verdict(subject) + list(subject.notes), sections,
                   subject.access());
}

std::vector<std::string> write_into_run(const record::OpenRun& run, const DisplayUnit& unit) {
  const Page page = page_of(in_unit(load_run(run), unit));
  os::write_file_atomically(run.files() / kReportFile, page.html);
  record::Manifest manifest = record::read_manifest(run.files());
  record::write_manifest(run.files(), manifest);
  return page.missing;
}

}  // namespace eha::report
