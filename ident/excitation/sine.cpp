// SPDX-License-Identifier: GPL-3.0-or-later
#include "ident/excitation/sine.hpp"

namespace eha::ident {

std::vector<OptionIssue> Sine::check() const {
  if (tones.size() <= 1) return {};
  return {{"tones", "expected one tone for kind = \"sine\", got " + std::to_string(tones.size())}};
}

Eigen::VectorXd Sine::volts(double step_s, std::size_t samples) const {
  Eigen::VectorXd table_V = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(samples));
  add_tone(tones.front(), step_s, table_V);
  return table_V;
}

}  // namespace eha::ident
