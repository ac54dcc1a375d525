// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <limits>
#include <vector>

#include "ident/estimation/prepared_record.hpp"
#include "ident/grey_box/grey_box_kind.hpp"
#include "ident/model/model.hpp"
#include "ident/structure/structure_options.hpp"

namespace eha::ident {

/// What is estimated of a model: a parameter in its own unit, or the natural logarithm of a positive one.
struct GreyBoxCoordinate {
  ParameterKey key;
  bool is_logarithm = false;
};

/// Output error of a grey box on the N rows that estimate, and its least squares from a start (Levenberg-Marquardt,
/// Eigen's port of MINPACK), over P coordinates. Residuals are in the output's unit. The record and what is asked must
/// outlive it. Thread-safe. A residual costs one simulation of the record, O(rows).
class GreyBoxSearch {
 public:
  /// @param rows_together  that are simulated as one of their mean input, the output in between as straight: for a
  /// search from afar
  GreyBoxSearch(const PreparedRecord& prepared, const StructureOptions& asked, Eigen::Index rows_together = 1);

  [[nodiscard]] const std::vector<GreyBoxCoordinate>& coordinates() const { return coordinates_; }
  [[nodiscard]] const Eigen::VectorXd& measured() const { return measured_; }

  /// Models worth a start. @param linear  fitted to the same rows
  [[nodiscard]] std::vector<Model> starts(const Model& linear) const;

  /// A model of the kind with the states and the dead time that the search moves.
  [[nodiscard]] Model begun_at(Model model) const;

  /// Model less measured at the estimating rows (N); far off where it is not finite.
  [[nodiscard]] Eigen::VectorXd residual(const Model& model) const;

  /// The coordinates of a model (P).
  [[nodiscard]] Eigen::VectorXd place(const Model& model) const;
  /// Gives a model the values of coordinates (P).
  void move_to(Model& model, const Eigen::VectorXd& theta) const;

  /// Derivatives of the residual by the coordinates (N x P), by forward differences: P simulations, and good enough
  /// for a search from afar. @param at  the residual at theta
  [[nodiscard]] Eigen::MatrixXd rough_derivatives(const Model& model, const Eigen::VectorXd& theta,
                                                  const Eigen::VectorXd& at) const;

  /// Derivatives of the simulated output by what is estimated (N x P), by central differences: 2 P simulations.
  /// @param by_coordinate  of logarithms where the search has them; else of the parameters themselves
  [[nodiscard]] Eigen::MatrixXd derivatives(const Model& model, bool by_coordinate) const;

  /// Least squares from a start. The cost is infinite if it ends at a model that is not finite.
  struct End {
    Model model;
    double cost = std::numeric_limits<double>::infinity();  ///< sum of squared residuals
    bool converged = false;
    bool is_hopeless = false;  ///< it will not come below the cost that is wanted
    std::size_t evaluations = 0;
  };
  /// How far and how exactly a search goes.
  struct Effort {
    int trials = 0;
    bool rough = false;   ///< derivatives by forward differences
    int trials_left = 0;  ///< after this search
  };
  /// @param most_cost  beyond which the end is not wanted: a search ends where it will not come below it
  [[nodiscard]] End minimised(const Model& start, const Effort& effort, double most_cost) const;

 private:
  /// Of a difference.
  [[nodiscard]] double step_of(Eigen::Index i, const Eigen::VectorXd& theta) const;

  [[nodiscard]] double scale_of(const GreyBoxCoordinate& coordinate) const;

  void choose_coordinates();

  /// The first state of the model at each row.
  [[nodiscard]] Eigen::VectorXd simulated(const Model& model) const;

  const StructureOptions& asked_;
  const GreyBoxKind& kind_;
  Comparison rows_;
  bool estimates_start_;
  Record record_;
  Eigen::Index rows_together_;
  Eigen::VectorXd means_;  ///< of the input of as many rows
  MeasuredRows kept_;
  Eigen::VectorXd measured_;
  double spread_ = 0.0;
  std::vector<GreyBoxCoordinate> coordinates_;
};

}  // namespace eha::ident
