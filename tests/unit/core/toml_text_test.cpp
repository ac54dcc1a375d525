// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/toml_text.hpp"

#include <gtest/gtest.h>

namespace eha {
namespace {

TEST(TomlText, KeepsANameWithinItsComment) {
  EXPECT_EQ(toml_comment("rig\n[excitation]\r\x1b\x7f"), "rig?[excitation]???");
  EXPECT_EQ(toml_comment("Pr\xC3\xBC"
                         "fstand 1"),
            "Pr\xC3\xBC"
            "fstand 1");
}

}  // namespace
}  // namespace eha
