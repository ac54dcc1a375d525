// SPDX-License-Identifier: GPL-3.0-or-later
// Writes the seeds of the fuzz targets: fuzz_seeds FOLDER makes FOLDER/fuzz_{journal,csv,mat,hdf5,toml,model,protocol}.
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <limits>
#include <string>
#include <vector>

#include "config/controller_config.hpp"
#include "core/os/files.hpp"
#include "daemon/record/journal.hpp"
#include "daemon/record/record_csv.hpp"
#include "ident/model/model_file.hpp"
#include "tests/unit/importer/foreign_fixtures.hpp"

namespace {

using namespace std::string_literals;
using eha::acquisition::TickRecord;
using eha::os::write_file_atomically;
using std::filesystem::path;

std::vector<TickRecord> ticks(std::size_t count) {
  std::vector<TickRecord> all(count);
  for (std::size_t k = 0; k < count; ++k) {
    all[k].sequence = static_cast<std::uint32_t>(k);
    all[k].scheduled_ns = static_cast<std::int64_t>(k) * 1'000'000;
    all[k].state = eha::acquisition::State::running;
    all[k].applied_V = std::sin(static_cast<double>(k));
    all[k].displacement_in = std::cos(static_cast<double>(k));
  }
  return all;
}

void write_journals(const path& folder) {
  for (const std::size_t count : {0U, 3U, 10U}) {
    for (const bool ends : {false, true}) {
      const path file = folder / (std::to_string(count) + (ends ? "-ended" : "-torn"));
      std::filesystem::remove(file);
      eha::record::JournalWriter writer(file, {{"schema", "eha-journal/1"}, {"name", "seed"}}, 4);
      writer.append(ticks(count));
      if (ends) writer.finish({{"outcome", "completed"}});
    }
  }
}

void write_records(const path& folder) {
  const std::vector<double> time_s = {0.0, 0.04, 0.08, 0.12};
  Eigen::VectorXd values(4);
  values << 0.0, -1.5, 2e-7, 1e300;
  write_file_atomically(folder / "series", eha::record::series_csv(time_s, {"voltage", "V"}, values));
  write_file_atomically(folder / "record",
                        "# a comment\ntime_s,voltage_V,displacement_in\n0,1,2.5\n0.001,-1,2.25\n0.002,+1e-3,2.125\n");
  write_file_atomically(folder / "quoted", "\xEF\xBB\xBFtime_s,\"a \"\"b\"\"_V\",c\r\n10,\"1\",2\r\n20,3,4\r\n");
  write_file_atomically(folder / "rounded", "time_s,u,y\n0.000000,1,2\n0.000977,3,4\n0.001953,5,6\n0.002930,7,8\n");
  write_file_atomically(folder / "utf16", "\xFF\xFEt\0,\0u\0\n\0\x31\0"s);
  write_file_atomically(folder / "gap", "time_s,u,y\n1e1,1,2\n2e1,1,2\n4e1,1,2\n");
  // Heads of other programs; tests/unit/importer/other_programs_test.cpp has whole files.
  write_file_atomically(folder / "dspace",
                        "descriptor,,,\npath,,Model Root/u,Model Root/y\ntrace,time,u,y\nunit,s,V,mm\n"
                        "trace_values,0.0,0,50\ntrace_values,0.001,0.1,51\ntrace_values,0.002,0.2,52\n");
  write_file_atomically(
      folder / "mts",
      "MTS793|BTW|ENU|1|2|.|/|:|1|0|0|A\nData Header:\tCyclic\tTime:\t0.5\tSec\n\n"
      "Time\tAxial Displacement\tAxial Command\nSec\tmm\tV\n0\t50\t0\n0.001\t51\t0.1\n0.002\t52\t0.2\n");
  write_file_atomically(
      folder / "rigol",
      "X,CH1,CH2,Start,Increment,\nSequence,Volt,Volt,-1.0e-01,1.0e-03,\n0,0,4.5,,\n1,0.1,4.6,,\n2,0.2,4.7,,\n");
  write_file_atomically(folder / "keysight",
                        "x-axis,1,2\nsecond,Volt,Volt\n-1E-1,0,4.5\n-9.9E-2,0.1,4.6\n-9.8E-2,0.2,4.7\n");
  write_file_atomically(folder / "yokogawa",
                        "\"TraceName\",\"CH1\",\"CH2\"\n\"VUnit\",\"V\",\"V\"\n\"HResolution\",0.001,0.001\n\n,0,4.5\n,"
                        "0.1,4.6\n,0.2,4.7\n");
  write_file_atomically(folder / "clock",
                        "Zeit;Ventil [V];Weg [mm]\n23.11.2026 10:00:00,000;0,5;45,2\n23.11.2026 10:00:00,010;0,6;45,3\n"
                        "23.11.2026 10:00:00,020;0,7;#WERT!\n23.11.2026 10:00:00,030;0,8;45,5\n");
  write_file_atomically(
      folder / "whole_seconds",
      "Zeit;u;y\n10:00:00;0,5;45,2\n10:00:00;0,6;45,3\n10:00:01;0,7;45,4\n10:00:01;0,8;45,5\n10:00:00;1;2\n");
  write_file_atomically(folder / "days", "Time,u,y\n46349.41670000,1,2\n46349.41670012,2,3\n46349.41670023,3,4\n");
  write_file_atomically(folder / "catman",
                        "HBM_CATMAN_DATAFILE_50\nDATEI: m.bin\nT0 = 23.11.2026 10:00:00\nWerte: 3\n"
                        "Zeit \tVentil \tWeg \ns\tV\tmm\n0,000\t1,5\t2\n0,001\t1,6\t3\n0,002\t1,7\t4\n");
  write_file_atomically(folder / "wincc",
                        "\"VarName\";\"TimeString\";\"VarValue\";\"Validity\";\"Time_ms\"\n"
                        "\"u\";\"23.11.2026 10:00:00\";0,5;1;46349416666,6667\n"
                        "\"y\";\"23.11.2026 10:00:00\";45,2;1;46349416666,6667\n");
  write_file_atomically(folder / "pico", "Time,Channel A,Channel B\n(ms),(V),(mV)\n\n0,1,2\n1,2,3\n2,3,4\n");
  write_file_atomically(
      folder / "labview",
      "LabVIEW Measurement\t\nSeparator\tTab\nDecimal_Separator\t,\nX_Columns\tOne\n***End_of_Header***\t\n\n"
      "Channels\t2\nX_Dimension\tTime\tTime\nDelta_X\t0,001\t0,001\n***End_of_Header***\t\t\n"
      "X_Value\tu\ty\tComment\n0,000\t1,5\t2\n0,001\t1,6\t3\n0,002\t1,7\t4\n");
}

void write_models(const path& folder) {
  eha::ident::Model model;
  model.name = "fo";
  model.transfer_function = {{{0.46, 0.0}}, {{0.61, 1.75}, {1.0, 0.9}, {0.04, 0.0}}, 0.016};
  write_file_atomically(folder / "smallest", eha::ident::to_text(model));
  model.input_map = eha::ident::ValveMap{-0.2, 0.15, 1.14};
  write_file_atomically(folder / "valve", eha::ident::to_text(model));
  model.input_map.reset();
  model.input_bias = 0.25;
  model.initial_state = {0.1, -1.0 / 3.0};
  model.parameters = {{"a2", 0.61, 0.01, 0.59, 0.63, false}, {"n0", 0.0, std::nan(""), 0.0, 0.0, true}};
  model.estimation.emplace();
  model.estimation->score = {99.5, 1e-4, 93.0, 0.0, 0.0, 500};
  model.estimation->evaluations = 27;
  model.estimation->seconds = 0.4;
  model.estimation->termination = "converged";
  model.estimation->converged = true;
  model.validation.emplace();
  model.validation->score.r2_percent = -std::numeric_limits<double>::infinity();
  model.validation->offset_reestimated = eha::ident::Score{99.2, 1.9e-4, 91.0, -0.02, 0.03, 500};
  model.validation->acf = {{0, 1}, {1.0, 0.5}, 0.0877, 0.115};
  model.validation->ccf = {{-1, 0, 1}, {0.1, 0.2, 0.3}, 0.2, 0.25};
  model.stability = eha::ident::StabilityReport{true, "argument_principle", 0.3};
  model.verdict = eha::ident::Verdict{true, {"The residual is not white."}, eha::ident::Grade::usable, {}};
  model.provenance = {{"normalisation", "a1 = 1"}, {"seed", "1"}};
  write_file_atomically(folder / "full", eha::ident::to_text(model));
}

void write_configurations(const path& folder) {
  for (const char* part : {"rigs", "experiments"}) {
    for (const auto& entry : std::filesystem::directory_iterator(path(EHA_SOURCE_DIR) / "config" / part)) {
      write_file_atomically(folder / entry.path().filename(), eha::os::read_file(entry.path()));
    }
  }
  const std::string rest =
      "duration_s = 4.0\n[record]\ndecimation = 4\ndiscard_s = 1.0\n[acceptance]\nmax_abs_error_in = 0.5\n"
      "[[model]]\nname = \"fo\"\nstructure = \"fo\"\ndelay = \"free\"\n"
      "[[model.parameter]]\nname = \"n2\"\nstart = 1.8\nlower = 1.0\nupper = 2.0\n";
  const std::string head = "schema = 1\nname = \"seed\"\nexcitation = { kind = ";
  write_file_atomically(folder / "prms.toml",
                        head + "\"prms\", amplitude_V = 2.0, levels = 5, hold_s = 0.5, seed = 7 }\n" + rest);
  write_file_atomically(folder / "chirp.toml",
                        head + "\"chirp\", amplitude_V = 1, frequency_min_Hz = 0.1, frequency_max_Hz = 2 }\n" + rest);
  write_file_atomically(folder / "controller.toml", eha::config::controller_text({}));
  write_file_atomically(folder / "step.toml", head + "\"step\", amplitude_V = 1, hold_s = 0.5 }\n" + rest);
}

void write_requests(const path& folder) {
  write_file_atomically(folder / "session",
                        "{\"id\":1,\"method\":\"status\"}\n{\"id\":2,\"method\":\"arm\",\"params\":{}}\r\n"
                        "{\"id\":3,\"method\":\"watch\",\"params\":{\"rate_Hz\":25,\"entry\":7}}\n\n"
                        "{\"id\":4,\"method\":\"stop\",\"params\":{\"entry\":null}}\n");
  write_file_atomically(folder / "submit",
                        "{\"id\":9007199254740991,\"method\":\"submit\",\"params\":{\"experiment\":\"schema = 1\\n\","
                        "\"name\":\"a\\u00e4.toml\",\"fast\":true}}\n");
  write_file_atomically(folder / "wrong",
                        "[]\n{}\n{\"id\":-1}\n{\"id\":1,\"method\":\"arms\"}\n{\"id\":1,\"method\":\"cancel\","
                        "\"params\":{\"entry\":0.5,\"x\":[[[[1]]]]}}\n\xff\n{\"id\":1,\"method\":\"que");
}

void write_arrays(const path& folder) {
  for (const eha::importer::foreign::Fixture& fixture : eha::importer::foreign::fixtures()) {
    const path file = folder / ("fuzz_" + fixture.kind) / fixture.name;
    std::filesystem::create_directories(file.parent_path());
    write_file_atomically(file, fixture.content);
  }
}

path made(const path& folder) {
  std::filesystem::create_directories(folder);
  return folder;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fputs("usage: fuzz_seeds FOLDER\n", stderr);
    return 2;
  }
  try {
    const path folder = argv[1];
    write_journals(made(folder / "fuzz_journal"));
    write_records(made(folder / "fuzz_csv"));
    write_arrays(folder);
    write_models(made(folder / "fuzz_model"));
    write_configurations(made(folder / "fuzz_toml"));
    write_requests(made(folder / "fuzz_protocol"));
  } catch (const std::exception& error) {
    std::fprintf(stderr, "fuzz_seeds: %s\n", error.what());
    return 1;
  }
  return 0;
}
