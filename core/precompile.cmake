# SPDX-License-Identifier: GPL-3.0-or-later
# Parses slow headers once for every target of the same optimisation: once for the programs, once for ident, once for the
# tests. Sources still include what they use; a build without this file differs in time only.
# eha_precompile(OWNER HEADER...): makes the target OWNER, which holds the parsed headers.
function(eha_precompile owner)
  add_library(${owner} OBJECT ${PROJECT_SOURCE_DIR}/core/precompile.cpp)
  target_link_libraries(${owner} PRIVATE eha::core Eigen3::Eigen nlohmann_json::nlohmann_json eha_warnings)
  target_precompile_headers(${owner} PRIVATE ${ARGN})
endfunction()

# Gives every static library and program below `folder` the headers of `owner`.
function(eha_reuse_precompiled owner folder)
  get_property(targets DIRECTORY ${folder} PROPERTY BUILDSYSTEM_TARGETS)
  foreach(target ${targets})
    get_target_property(type ${target} TYPE)
    if(type MATCHES "STATIC_LIBRARY|EXECUTABLE")
      target_precompile_headers(${target} REUSE_FROM ${owner})
    endif()
  endforeach()
  get_property(folders DIRECTORY ${folder} PROPERTY SUBDIRECTORIES)
  foreach(below ${folders})
    eha_reuse_precompiled(${owner} ${below})
  endforeach()
endfunction()

set(EHA_SLOW_HEADERS <algorithm> <array> <chrono> <complex> <filesystem> <fstream> <functional> <future> <limits> <map> <memory>
  <mutex> <optional> <random> <regex> <set> <span> <sstream> <string> <thread> <variant> <vector> <Eigen/Core>)
