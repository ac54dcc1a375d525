// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <set>
#include <string>
#include <vector>

#include "ident/estimation/fit.hpp"
#include "ident/estimation/left_out.hpp"
#include "ident/estimation/prepared_record.hpp"

namespace eha::ident {

/// Fits of the structures inside those that are asked, the smallest first, each once for all fits of one record. They
/// serve as starts. Cost: a search from known models for each structure of integer order, a global one for the others.
class InsideFits {
 public:
  /// @param options  of the same rows; the record must outlive it
  InsideFits(const PreparedRecord& prepared, const FitOptions& options, Executor executor);

  /// Fits what is inside the asked structure. Those with a request, or another initial state, share with none before.
  /// @returns the work of these fits
  Work fit(const StructureOptions& asked, const FitProgress& progress);

  /// Takes the fit of an asked structure, which may be inside of one that is asked later.
  void take(const StructureOptions& asked, const Model& fitted);

  [[nodiscard]] const std::vector<Model>& models() const { return models_; }
  [[nodiscard]] const std::vector<FittedStructure>& structures() const { return structures_; }

 private:
  void forget();
  void count(const StructureOptions& asked);
  void fit_inside(const StructureOptions& asked, const FitProgress& progress);

  const PreparedRecord& prepared_;
  FitOptions options_;
  Executor executor_;
  bool shares_ = true;             ///< whether what is kept was asked without a request
  std::set<std::string> counted_;  ///< signatures of what the asked structure still needs
  std::set<std::string> fitted_;   ///< signatures, of what failed too
  std::size_t done_ = 0;           ///< of those counted
  std::vector<Model> models_;
  std::vector<FittedStructure> structures_;
  Work work_;
};

}  // namespace eha::ident
