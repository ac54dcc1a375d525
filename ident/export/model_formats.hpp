// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <span>
#include <string>
#include <string_view>

#include "ident/export/exported_model.hpp"

namespace eha::ident {

/// An export format of a model. A new one is a row of model_formats() and a function.
struct ModelFormat {
  std::string_view name;  ///< of --format
  std::string_view what;  ///< for --help
  /// The file's text, ending in a newline. @param function  an eha::identifier(); the name to call it by
  std::string (*text)(const ExportedModel& model, const std::string& function);
  bool is_binary = false;  ///< bytes, for a file only
};

[[nodiscard]] std::span<const ModelFormat> model_formats();

// The formats, each in its file.
[[nodiscard]] std::string octave_text(const ExportedModel& model, const std::string& function);
[[nodiscard]] std::string python_text(const ExportedModel& model, const std::string& function);
[[nodiscard]] std::string c_text(const ExportedModel& model, const std::string& function);
[[nodiscard]] std::string state_space_text(const ExportedModel& model, const std::string& function);
[[nodiscard]] std::string tf_text(const ExportedModel& model, const std::string& function);
/// The ZIP archive of fmu_files(): bytes, not text.
[[nodiscard]] std::string fmu_bytes(const ExportedModel& model, const std::string& function);
[[nodiscard]] std::string json_text(const ExportedModel& model, const std::string& function);

/// Describes the model line by line, for every format: equation, units, accuracy, verdict, and G as FOMCON and the
/// CRONE toolbox write it. Text from the file has passed eha::code_text().
[[nodiscard]] std::vector<std::string> notes(const ExportedModel& model);
/// G for FOMCON: `fotf([..], [..], [..], [..], delay)`.
[[nodiscard]] std::string fomcon_line(const TransferFunction& g);
/// G without its delay for the object-oriented CRONE toolbox: `frac_tf(...)`.
[[nodiscard]] std::string crone_line(const TransferFunction& g);

}  // namespace eha::ident
