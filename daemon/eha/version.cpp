// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/eha/version.hpp"

#include <fftw3.h>
#include <fmt/format.h>
#include <nlopt.h>
#include <spdlog/version.h>
#include <toml++/toml.h>

#include <CLI/Version.hpp>
#include <Eigen/Core>
#include <boost/version.hpp>
#include <nlohmann/json.hpp>
#include <string>

#include "hal/comedi/comedi_available.hpp"

namespace eha::cli {

std::string version_text() {
  int nlopt_parts[3] = {};
  nlopt_version(&nlopt_parts[0], &nlopt_parts[1], &nlopt_parts[2]);
  std::string text = fmt::format("eha {}\n", EHA_VERSION);
  text += fmt::format("comedi backend: {}\n", hal::comedi_available ? "yes" : "no (built without libcomedi)");
  const auto add = [&](const char* library, const std::string& version) {
    text += fmt::format("{:<14}  {}\n", library, version);
  };
  add("Eigen", fmt::format("{}.{}.{}", EIGEN_WORLD_VERSION, EIGEN_MAJOR_VERSION, EIGEN_MINOR_VERSION));
  add("NLopt", fmt::format("{}.{}.{}", nlopt_parts[0], nlopt_parts[1], nlopt_parts[2]));
  add("FFTW", fftw_version);
  add("Boost", fmt::format("{}.{}.{}", BOOST_VERSION / 100000, BOOST_VERSION / 100 % 1000, BOOST_VERSION % 100));
  add("toml++", fmt::format("{}.{}.{}", TOML_LIB_MAJOR, TOML_LIB_MINOR, TOML_LIB_PATCH));
  add("nlohmann-json",
      fmt::format("{}.{}.{}", NLOHMANN_JSON_VERSION_MAJOR, NLOHMANN_JSON_VERSION_MINOR, NLOHMANN_JSON_VERSION_PATCH));
  add("spdlog", fmt::format("{}.{}.{}", SPDLOG_VER_MAJOR, SPDLOG_VER_MINOR, SPDLOG_VER_PATCH));
  add("fmt", fmt::format("{}.{}.{}", FMT_VERSION / 10000, FMT_VERSION / 100 % 100, FMT_VERSION % 100));
  add("CLI11", CLI11_VERSION);
  return text;
}

}  // namespace eha::cli
