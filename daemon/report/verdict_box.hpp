// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>

#include "daemon/report/subject.hpp"

namespace eha::report {

/// The box at the head of a page, as HTML. @param kind  "some" or "none", of models that can be used
[[nodiscard]] std::string box(const char* kind, const std::string& heading, const std::string& html);

/// The box of a run without models: it did not complete, its identification failed, or it is a controller's trial.
[[nodiscard]] std::string without_models(const Subject& subject);

}  // namespace eha::report
