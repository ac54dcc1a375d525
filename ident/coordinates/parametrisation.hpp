// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <complex>
#include <optional>
#include <string>
#include <vector>

#include "ident/fractional/transfer_columns.hpp"
#include "ident/fractional/transfer_function.hpp"
#include "ident/signal/valve_map.hpp"
#include "ident/structure/structure_options.hpp"

namespace eha::ident {

/// The quantity that one nonlinear coordinate moves.
enum class CoordinateRole {
  denominator,           ///< coefficient of denominator term `index`
  weighted_denominator,  ///< that coefficient's weight at the reference frequency, linear when slight, else logarithmic
  denominator_order,     ///< order of denominator term `index`
  numerator_order,       ///< order of numerator term `index`
  base_order,            ///< q: term k of numerator and denominator has order k q
  section_frequency,     ///< ln of the natural frequency of section `index` [ln rad/s]
  section_damping,       ///< inverse hyperbolic sine of the damping ratio of section `index`
  delay,                 ///< transport delay [s]
  input_bias,            ///< [input unit]; moves the input, not G, as do the next three
  valve_null,            ///< [input unit]
  dead_band,             ///< [input unit]
  negative_gain_ratio,
};

struct Coordinate {
  ParameterKey key;  ///< of its parameter; for a section's coordinates only its name
  CoordinateRole role;
  std::size_t index = 0;
  double start = 0.0;
  double lower = 0.0;
  double upper = 0.0;
  double search_lower = 0.0;  ///< box of the global search, inside the bounds
  double search_upper = 0.0;
};

/// Maps coordinates to a transfer function and its sensitivities. Numerator coefficients are not coordinates: they
/// enter the output linearly and are solved for. Two uses: `search` coordinates converge well from afar (logarithms
/// of coefficients weighted at a reference frequency; natural frequencies and damping ratios, which are stable by
/// construction), `plain` ones are what a model file reports.
class Parametrisation {
 public:
  /// Time span, band and input of the record a search is for.
  struct Scale {
    double duration_s;
    double step_s;                 ///< finest time the search needs to resolve [s]
    double lowest_input = -1e300;  ///< [input unit]; a valve's dead band lies between the lowest and the highest
    double highest_input = 1e300;
  };

  /// Coordinates to search in: one for each estimated parameter that does not enter the output linearly.
  /// @throws ConfigError  a request names no parameter of the structure or contradicts itself
  [[nodiscard]] static Parametrisation search(const StructureOptions& asked, const Scale& scale);

  /// Coordinates to report: coefficients, orders and delay of a normalised g unchanged, its terms by rising order.
  /// Parameters that are not estimated are left out.
  /// @param valve  of a structure that has one
  [[nodiscard]] static Parametrisation plain(const StructureOptions& asked, const TransferFunction& g,
                                             const std::optional<ValveMap>& valve = {});

  /// Makes the input bias a coordinate, for structures in which it does not enter linearly.
  /// @param largest_input  max |u|; @param first_input  u at t = 0: the bias of a record that starts at rest there
  void add_input_bias(const StructureOptions& asked, double largest_input, double first_input);

  [[nodiscard]] const std::vector<Coordinate>& coordinates() const noexcept { return coordinates_; }
  /// Number of coordinates that weight coefficients.
  [[nodiscard]] std::ptrdiff_t weight_count() const;
  [[nodiscard]] std::size_t numerator_terms() const noexcept { return base_.numerator.size(); }

  /// Numerator coefficients are taken from `numerator`; an empty one leaves them 1.
  [[nodiscard]] TransferFunction transfer_function(const Eigen::VectorXd& theta,
                                                   const Eigen::VectorXd& numerator) const;

  /// Returns one sensitivity a coordinate, at g = transfer_function(theta, numerator).
  [[nodiscard]] std::vector<Sensitivity> sensitivities(const Eigen::VectorXd& theta, const TransferFunction& g) const;

  /// Returns theta with denominator orders a twentieth lower: fewer models of lower order are unstable.
  [[nodiscard]] Eigen::VectorXd with_lower_orders(const Eigen::VectorXd& theta) const;

  /// Greatest imaginary part of a pole [rad/s]; 0 when coefficients or a base order are coordinates.
  [[nodiscard]] double fastest_oscillation(const Eigen::VectorXd& theta) const;

  /// Coordinates of given poles (conjugate pairs together, stable) and delay, other coordinates at their start; nothing
  /// when the coordinates are not sections of integer order or the delay is beyond the search box.
  [[nodiscard]] std::optional<Eigen::VectorXd> at_poles(std::vector<std::complex<double>> poles, double delay_s) const;

  /// Coordinates of a model of this structure or of a sub-structure. Missing terms get the smallest weight, missing
  /// poles the highest frequency that the coordinates allow. Gain and other linear quantities have no effect.
  /// @param bias  input bias of the model; without a map the null of a structure with one is -bias
  /// @param map   valve map of the model; none: no dead band
  /// @returns nothing if the model is not one of this structure or of a sub-structure
  [[nodiscard]] std::optional<Eigen::VectorXd> at_model(const TransferFunction& g, double bias,
                                                        const std::optional<ValveMap>& map) const;

  /// Value of the input_bias coordinate, 0 when there is none.
  [[nodiscard]] double input_bias(const Eigen::VectorXd& theta) const;

  /// The valve map, where the structure has one; its gain ratio is 1 when that is neither held nor a coordinate.
  [[nodiscard]] std::optional<ValveMap> valve(const Eigen::VectorXd& theta) const;

  [[nodiscard]] bool has_valve() const noexcept { return valve_.has_value(); }

  [[nodiscard]] Eigen::VectorXd start() const;
  [[nodiscard]] Eigen::VectorXd lower() const;
  [[nodiscard]] Eigen::VectorXd upper() const;
  /// Largest change of a coordinate in one step; the linearisation is not valid beyond it.
  [[nodiscard]] Eigen::VectorXd max_step() const;

  /// See ident::must_be_strictly_proper().
  [[nodiscard]] bool must_be_strictly_proper() const noexcept { return strictly_proper_; }

 private:
  [[nodiscard]] bool integer_sections() const;
  void place_roots(std::vector<std::complex<double>> roots, double q, Eigen::VectorXd& theta) const;
  [[nodiscard]] bool place_polynomial(const std::vector<Term>& denominator, Eigen::VectorXd& theta) const;
  [[nodiscard]] bool place_terms(const std::vector<Term>& denominator, Eigen::VectorXd& theta) const;
  [[nodiscard]] bool place_numerator(std::vector<Term> numerator, Eigen::VectorXd& theta) const;
  [[nodiscard]] std::size_t normalised() const { return normalised_index(base_.denominator.size()); }
  [[nodiscard]] std::vector<double> section_polynomial(const Eigen::VectorXd& theta, std::size_t without) const;
  [[nodiscard]] std::vector<LogTerm> section_change(const Eigen::VectorXd& theta, const TransferFunction& g,
                                                    std::size_t section, const std::vector<double>& change) const;
  [[nodiscard]] std::vector<LogTerm> radius_change(const Eigen::VectorXd& theta, const TransferFunction& g,
                                                   std::size_t coordinate) const;
  [[nodiscard]] Sensitivity by_denominator_order(const TransferFunction& g, std::size_t index) const;
  [[nodiscard]] Sensitivity by_base_order(const Eigen::VectorXd& theta, const TransferFunction& g) const;
  [[nodiscard]] std::vector<bool> weighted_terms() const;
  void add_sections(const Structure& structure, const Scale& scale);
  void add_weights(const StructureOptions& asked);
  void add_valve(const StructureOptions& asked, const Scale& scale);

  TransferFunction base_;          ///< constants; coordinates overwrite their places
  std::optional<ValveMap> valve_;  ///< the same
  std::vector<Coordinate> coordinates_;
  double reference_rad_s_ = 1.0;
  std::size_t sections_ = 0;  ///< integer-order sections; 0 when coefficients are coordinates
  bool integrates_ = false;   ///< the sections stand beside a pole at 0
  bool odd_section_ = false;  ///< the last section is of first order
  bool strictly_proper_ = true;
};

}  // namespace eha::ident
