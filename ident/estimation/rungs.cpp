// SPDX-License-Identifier: GPL-3.0-or-later
#include "ident/estimation/rungs.hpp"

#include <utility>

namespace eha::ident {
namespace {

/// K/(a1 s): the lag is too fast for the record.
Structure integrator() {
  Structure structure = structures::integrator_lag();
  structure.formula = "K/(a1 s)";
  structure.denominator.pop_back();
  return structure;
}

}  // namespace

std::vector<FitStage> stages_of(const LadderOptions& wanted) {
  using namespace structures;
  // The basin of a fractional optimum need not hold a structure of integer order.
  std::vector<Structure> two_poles = {io(wanted.io)};
  if (wanted.io.poles == 2 && wanted.io.zeros == 0) two_poles.push_back(io({2, 1}));
  const auto from_known = [&](std::string name, std::vector<Structure> structures) {
    return Rung{std::move(name), std::move(structures), wanted.search};
  };
  const Rung one_lag = from_known("integrator_lag", {integrator(), integrator_lag()});
  return {
      {{one_lag}},
      {{from_known("cylinder", {cylinder()})}, {from_known("io1", {io1()}), from_known("io", std::move(two_poles))}},
      {{from_known("io3", {io3(0), io3(1)})}, {{"lag", {lag()}, Search::global}, {"fo", {fo()}, Search::global}}}};
}

}  // namespace eha::ident
