# SPDX-License-Identifier: GPL-3.0-or-later
# Writes the files of the page as C++: cmake -DOUTPUT=page_files.cpp -DFILES="a;b" -P embed.cmake
set(types html "text/html; charset=utf-8" js "text/javascript; charset=utf-8" css "text/css; charset=utf-8"
  svg "image/svg+xml" png "image/png" txt "text/plain; charset=utf-8")
set(arrays "")
set(rows "")
set(number 0)
foreach(file ${FILES})
  get_filename_component(name "${file}" NAME)
  get_filename_component(ending "${file}" LAST_EXT)
  string(SUBSTRING "${ending}" 1 -1 ending)
  list(FIND types "${ending}" at)
  if(at EQUAL -1)
    message(FATAL_ERROR "${file}: no content type for .${ending} files; add it to embed.cmake")
  endif()
  math(EXPR at "${at} + 1")
  list(GET types ${at} type)
  file(READ "${file}" hex HEX)
  string(REGEX REPLACE "([0-9a-f][0-9a-f])" "0x\\1," bytes "${hex}")
  string(APPEND arrays "constexpr unsigned char file_${number}[] = {${bytes}0};\n")
  string(APPEND rows "    PageFile{\"${name}\", \"${type}\", text_of(file_${number}, sizeof file_${number} - 1)},\n")
  math(EXPR number "${number} + 1")
endforeach()
file(WRITE "${OUTPUT}" "// Made by embed.cmake from the files of the page.
#include \"daemon/web/page_files.hpp\"

#include <vector>
#include <cstddef>
#include <vector>

namespace eha::web {
namespace {

${arrays}
[[maybe_unused]] std::string_view text_of(const unsigned char* bytes, std::size_t size) {
  return {reinterpret_cast<const char*>(bytes), size};
}

}  // namespace

std::span<const PageFile> page_files() noexcept {
  static const std::vector<PageFile> files{
${rows}  };
  return files;
}

}  // namespace eha::web
")
