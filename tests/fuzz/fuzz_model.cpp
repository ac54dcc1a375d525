// SPDX-License-Identifier: GPL-3.0-or-later
// The reader of model files either refuses with ConfigError or returns a model that can be simulated. A file written
// from that model reads back as the same model.
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

#include "core/error.hpp"
#include "ident/fractional/transfer_function.hpp"
#include "ident/model/model_file.hpp"
#include "tests/fuzz/require.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using eha::fuzz::require;
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  eha::ident::Model model;
  try {
    model = eha::ident::model_from_text(text, "m.json");
  } catch (const eha::ConfigError& error) {
    eha::fuzz::require_good_message(error.what(), "m.json");
    require(std::string_view(error.what()).size() < 2000, "a message is short");
    return 0;
  }
  eha::ident::check(model.transfer_function);
  const std::string written = eha::ident::to_text(model);
  try {
    require(eha::ident::to_text(eha::ident::model_from_text(written, "m.json")) == written,
            "an accepted model reads back as it was written");
  } catch (const eha::ConfigError& error) {
    require(false, written + "a written model can be read: " + error.what());
  }
  return 0;
}
