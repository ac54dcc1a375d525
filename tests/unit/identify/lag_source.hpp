// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cmath>
#include <utility>
#include <vector>

#include "daemon/identify/identification.hpp"
#include "daemon/identify/source.hpp"
#include "ident/excitation/excitation.hpp"
#include "ident/fractional/simulate.hpp"

namespace eha::identify::test {

inline constexpr double kStep_s = 0.01;
inline const ident::TransferFunction kLag{{{2.0, 0.0}}, {{0.1, 1.0}, {1.0, 0.0}}, 0.0};

/// A lag driven by an excitation that is played for `duration_s`, several times.
inline Source source_of(double duration_s, int repetitions, ident::ExcitationKind kind) {
  Source source;
  source.name = "test";
  source.record.step_s = kStep_s;
  source.experiment.emplace();
  const ident::Excitation excitation{.kind = std::move(kind)};
  source.experiment->kind = config::Played{.excitation = excitation};
  source.experiment->duration_s = duration_s;
  source.repetition_samples = static_cast<std::size_t>(std::lround(duration_s / kStep_s));
  source.record.input = ident::excitation(excitation, kStep_s, source.repetition_samples).replicate(repetitions, 1);
  source.record.output = ident::simulate(kLag, source.record.input, kStep_s);
  return source;
}

/// By tones with a common period of 10 s.
inline Source source_of(double duration_s, int repetitions, const std::vector<ident::Tone>& tones) {
  return source_of(duration_s, repetitions, ident::ExcitationKind(ident::Multisine{tones}));
}

/// By realisations of an odd-random multisine, three periods of 10 s each.
inline Source realised_source_of(int realisations, int repetitions) {
  return source_of(30.0 * realisations, repetitions,
                   ident::ExcitationKind(ident::OddRandomMultisine{
                       .amplitude_V = 1.0, .band = {0.1, 2.0}, .realisations = realisations, .periods = 3}));
}

inline const std::vector<ident::Tone> kTones{{0.1, 1.0, 0.4}, {0.5, 0.5, 1.0}};

inline ident::FitOptions discarding(double seconds) {
  ident::FitOptions options;
  options.discard_s = seconds;
  return options;
}

/// The plant itself, in the form of a fitted model.
inline std::vector<IdentifiedModel> the_plant() {
  std::vector<IdentifiedModel> models(1);
  models[0].result.model.name = "io";
  models[0].result.model.transfer_function = kLag;
  models[0].result.covariance = {{ident::numerator_key(0, 1), ident::coefficient_key(0)},
                                 1e-6 * Eigen::MatrixXd::Identity(2, 2)};
  return models;
}

}  // namespace eha::identify::test
