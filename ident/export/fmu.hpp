// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "ident/export/exported_model.hpp"

namespace eha::ident {

/// A file in an archive.
struct ArchivedFile {
  std::string name;  ///< with folders, separated by '/'
  std::string content;
};

/// The bytes of a ZIP archive, its files stored and not compressed, without times: same files, same bytes.
[[nodiscard]] std::string zip_bytes(const std::vector<ArchivedFile>& files);

/// The headers of FMI 2.0 (BSD-2, Modelica Association) and their licence.
[[nodiscard]] std::vector<ArchivedFile> fmi_headers();

/// The files of a functional mock-up unit of FMI 2.0 for co-simulation: modelDescription.xml and sources, no binary.
/// Input u and output y; the input is held over a communication step. A model with a delay takes steps of one length.
[[nodiscard]] std::vector<ArchivedFile> fmu_files(const ExportedModel& model, const std::string& function);

}  // namespace eha::ident
