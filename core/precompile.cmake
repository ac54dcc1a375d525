# SPDX-License-Identifier: GPL-3.0-or-later
# Parses slow headers once for every target of the same optimisation: once for the programs, once for what only arranges
# and prints, once for ident, once for the tests. Sources still include what they use; a build without this file differs in
# time only.
# eha_precompile(OWNER HEADER...): makes the target OWNER, which holds the parsed headers.
function(eha_precompile owner)
  add_library(${owner} OBJECT ${PROJECT_SOURCE_DIR}/core/precompile.cpp)
  target_link_libraries(${owner} PRIVATE eha::core Eigen3::Eigen nlohmann_json::nlohmann_json CLI11::CLI11 eha_warnings)
  target_precompile_headers(${owner} PRIVATE ${ARGN})
endfunction()

# Gives every static library and program below `folder` the headers of `owner`, but for those of EHA_ARRANGING.
function(eha_reuse_precompiled owner folder)
  get_property(targets DIRECTORY ${folder} PROPERTY BUILDSYSTEM_TARGETS)
  foreach(target ${targets})
    get_target_property(type ${target} TYPE)
    if(type MATCHES "STATIC_LIBRARY|EXECUTABLE" AND NOT target IN_LIST EHA_ARRANGING)
      target_precompile_headers(${target} REUSE_FROM ${owner})
    endif()
  endforeach()
  get_property(folders DIRECTORY ${folder} PROPERTY SUBDIRECTORIES)
  foreach(below ${folders})
    eha_reuse_precompiled(${owner} ${below})
  endforeach()
endfunction()

# Where EHA_UNITY asks for it, compiles the sources of each folder of a library as one, which share their templates.
function(eha_compile_by_folder target)
  get_target_property(sources ${target} SOURCES)
  get_target_property(root ${target} SOURCE_DIR)
  foreach(source ${sources})
    cmake_path(GET source PARENT_PATH folder)
    set_property(SOURCE ${root}/${source} TARGET_DIRECTORY ${target} PROPERTY UNITY_GROUP ${folder})
  endforeach()
  set_target_properties(${target} PROPERTIES UNITY_BUILD ${EHA_UNITY} UNITY_BUILD_MODE GROUP)
endfunction()

set(EHA_SLOW_HEADERS <algorithm> <array> <chrono> <complex> <filesystem> <fstream> <functional> <future> <limits> <map> <memory>
  <mutex> <optional> <random> <regex> <set> <span> <sstream> <string> <thread> <variant> <vector> <Eigen/Core>)
