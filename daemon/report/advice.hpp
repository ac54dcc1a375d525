// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>

#include "daemon/report/subject.hpp"
#include "ident/model/model.hpp"

namespace eha::report {

// What a section says of a model's error. The remedy stands in the verdict's sentences, in the box at the top of the
// page; a section refers to it.

/// "the box above says what to do." where a criterion of the model failed; else empty.
[[nodiscard]] std::string named_in_box(const ident::Model& model);

/// For a section that shows no fault: "Nothing.", or that the box asks for something first.
[[nodiscard]] std::string nothing_to_do(const Subject& subject);

/// Names a model's error by the cause that the box at the top of the page names; empty if none is known.
[[nodiscard]] std::string against_error(const ident::Model& model);

}  // namespace eha::report
