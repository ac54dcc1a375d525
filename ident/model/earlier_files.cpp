// SPDX-License-Identifier: GPL-3.0-or-later
#include "ident/model/earlier_files.hpp"

#include <algorithm>
#include <cmath>
#include <string>
#include <string_view>
#include <vector>

#include "ident/signal/autoregression.hpp"
#include "ident/structure/structures.hpp"

namespace eha::ident {
namespace {

bool estimates(const Model& model, ParameterRole role) {
  return std::any_of(model.parameters.begin(), model.parameters.end(),
                     [&](const ParameterEstimate& p) { return p.role == role && !p.fixed; });
}

/// Whether the orders are 0, 1, 2, ... without a gap, in any sequence.
bool has_all_whole_orders(std::vector<Term> terms) {
  std::sort(terms.begin(), terms.end(), [](const Term& a, const Term& b) { return a.order < b.order; });
  for (std::size_t k = 0; k < terms.size(); ++k) {
    if (std::abs(terms[k].order - static_cast<double>(k)) > 0.0) return false;
  }
  return true;
}

/// Finds the family that the file's name gives, or that its terms and estimates fit.
std::string_view family_of(const Model& model) {
  std::string_view name = model.name;
  for (const InputMapKind& kind : input_map_kinds()) {
    if (!kind.suffix.empty() && name.ends_with(kind.suffix)) name.remove_suffix(kind.suffix.size());
  }
  const TransferFunction& g = model.transfer_function;
  const auto families = structure_families();
  const auto named = std::find_if(families.begin(), families.end(),
                                  [&](const StructureFamily& family) { return family.name == name; });
  if (named != families.end()) return named->name;
  if (estimates(model, ParameterRole::base_order)) return "commensurate";
  if (has_all_whole_orders(g.denominator) && has_all_whole_orders(g.numerator)) return "io";
  if (g.numerator.size() > 1) return {};
  if (g.denominator.size() == 3) return "fo";
  return g.denominator.size() == 2 ? "lag" : std::string_view();
}

std::optional<Structure> plain_structure(const Model& model) {
  const std::string_view name = family_of(model);
  if (name.empty()) return {};
  const TransferFunction& g = model.transfer_function;
  const Degrees degrees{static_cast<int>(g.denominator.size()) - 1, static_cast<int>(g.numerator.size()) - 1};
  const StructureFamily& family = structure_family(name);
  if (family.has_degrees && (degrees.poles < 1 || degrees.poles > kHighestDegree || degrees.zeros > degrees.poles)) {
    return {};
  }
  Structure structure = family.make(family.has_degrees ? degrees : Degrees{});
  const bool fits =
      structure.denominator.size() == g.denominator.size() && structure.numerator.size() == g.numerator.size();
  if (fits) return structure;
  // A form of the family with another number of terms.
  if (!has_all_whole_orders(g.denominator) || !has_all_whole_orders(g.numerator) || degrees.poles < 1 ||
      degrees.poles > kHighestDegree || degrees.zeros > degrees.poles) {
    return {};
  }
  return structures::io(degrees);
}

std::optional<StructureOptions> guessed_structure(const Model& model) {
  const std::optional<Structure> plain = plain_structure(model);
  if (!plain) return {};
  StructureOptions asked;
  asked.name = model.name;
  asked.structure = model.input_map ? structures::behind_valve(*plain) : *plain;
  for (const ParameterEstimate& p : model.parameters) {
    if (p.role == ParameterRole::delay) {
      asked.structure.delay.freedom = p.fixed ? Freedom::held : Freedom::free;
      asked.structure.delay.value = p.fixed ? model.transfer_function.delay_s : 0.0;
    } else if (p.role == ParameterRole::numerator_order && !p.fixed) {
      asked.parameters.push_back({p.name, false, {}, {}, {}});
    }
  }
  const bool lists_delay = std::any_of(model.parameters.begin(), model.parameters.end(),
                                       [](const ParameterEstimate& p) { return p.role == ParameterRole::delay; });
  if (!lists_delay) asked.structure.delay.value = model.transfer_function.delay_s;
  return asked;
}

}  // namespace

std::optional<ResidualNoise> noise_of(const Correlation& acf, std::size_t samples, double power) {
  std::vector<double> correlation;  // at lags 0, 1, ...
  for (std::size_t i = 0; i < acf.lags.size(); ++i) {
    if (acf.lags[i] == static_cast<int>(correlation.size())) correlation.push_back(acf.values[i]);
  }
  if (correlation.empty() || !(correlation[0] > 0.0) || samples == 0 || !(power > 0.0)) return {};
  const auto highest = std::min<std::size_t>(correlation.size() - 1, kHighestAutoregression);
  LevinsonModel found = levinson(correlation, static_cast<double>(samples), highest);
  ResidualNoise noise{
      .power = power, .variance = power * found.variance, .coefficients = std::move(found.coefficients)};
  if (!(noise.variance > 0.0) || !std::isfinite(power)) return {};
  noise.autocorrelation.assign(correlation.begin(),
                               correlation.begin() + 1 + static_cast<std::ptrdiff_t>(noise.coefficients.size()));
  return noise;
}

void complete_earlier(Model& model) {
  if (!model.structure) model.structure = guessed_structure(model);
  if (!model.estimation || !model.bode || model.bode->frequency_Hz.empty()) return;
  EstimationReport& estimation = *model.estimation;
  // The curve ends at the Nyquist frequency of the compared samples.
  const double highest_Hz = model.bode->frequency_Hz.back();
  if (!estimation.compared_step_s && std::isnormal(highest_Hz) && highest_Hz > 0.0) {
    estimation.compared_step_s = 0.5 / highest_Hz;
  }
  if (estimation.noise || !model.validation) return;
  estimation.noise = noise_of(model.validation->acf, model.validation->score.samples, estimation.score.mse);
  if (estimation.noise) estimation.noise->with_parameters = model.provenance.contains("noise_model");
}

}  // namespace eha::ident
