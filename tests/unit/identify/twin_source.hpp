// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <string>

#include "daemon/identify/source.hpp"
#include "tests/unit/replay/twin_record.hpp"

namespace eha::identify::test {

/// 40 s of the simulated rig with the paper's tones, compared as in the shipped experiment.
/// @param share  of the amplitudes
inline Source source_of(const hal::SimOptions& options, double share = 1.0) {
  const replay::test::TwinRecord record = replay::test::record_of(options, 40.0, share);
  Source source;
  source.name = "run";
  source.record.step_s = record.step_s;
  source.record.input = record.volts;
  source.record.output = record.displacement_in;
  source.experiment.emplace();
  source.experiment->kind = config::Played{
      .excitation = {
          .kind = ident::Multisine{{{0.05, 1.9 * share, 1.8}, {0.2, 1.6 * share, 1.9}, {0.65, 1.5 * share, 4.2}}},
          .offset_V = -0.1}};
  source.experiment->fit.decimation = 40;
  source.experiment->fit.discard_s = 10.0;
  return source;
}

/// One rig with other noise, started elsewhere.
inline hal::SimOptions seeded(std::uint64_t seed) {
  hal::SimOptions options;
  options.seed = seed;
  options.initial_displacement_in = 2.9 + 0.01 * static_cast<double>(seed % 10);
  return options;
}

}  // namespace eha::identify::test
