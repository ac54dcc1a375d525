# SPDX-License-Identifier: GPL-3.0-or-later
# Writes the headers of FMI 2.0 as C++: cmake -DOUTPUT=fmi_headers.cpp -DFILES="a;b" -P embed.cmake
set(arrays "")
set(rows "")
set(number 0)
foreach(file ${FILES})
  get_filename_component(name "${file}" NAME)
  file(READ "${file}" hex HEX)
  string(REGEX REPLACE "([0-9a-f][0-9a-f])" "0x\\1," bytes "${hex}")
  string(APPEND arrays "constexpr unsigned char file_${number}[] = {${bytes}0};\n")
  string(APPEND rows "      {\"${name}\", text_of(file_${number}, sizeof file_${number} - 1)},\n")
  math(EXPR number "${number} + 1")
endforeach()
file(WRITE "${OUTPUT}" "// Made by embed.cmake from the headers of FMI 2.0.
#include \"ident/export/fmu.hpp\"

namespace eha::ident {
namespace {

${arrays}
std::string text_of(const unsigned char* bytes, std::size_t size) {
  return {reinterpret_cast<const char*>(bytes), size};
}

}  // namespace

std::vector<ArchivedFile> fmi_headers() {
  return {
${rows}  };
}

}  // namespace eha::ident
")
