// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace eha::plot {

/// Ways to draw a series.
enum class Mark {
  line,
  points,
  impulses,    ///< a stem from 0 to each value
  error_bars,  ///< a point with a bar from `lower` to `upper`
  band,        ///< the area between `lower` and `upper`; not drawn in characters
  area,        ///< the inside of the polygon; not drawn in characters
};

/// Style of guide lines.
inline constexpr int kGuideStyle = -1;

/// One curve. x and y have one length; a value that is not finite interrupts the curve.
struct Series {
  std::string label;  ///< text in the key; empty: not listed
  std::vector<double> x = {};
  std::vector<double> y = {};  ///< unused by a band
  std::vector<double> lower = {};
  std::vector<double> upper = {};
  Mark mark = Mark::line;
  /// kGuideStyle: a thin grey line. 0: a broad grey line, for measured data. 1: solid black, for the most important
  /// model. 2 and more: dash patterns that differ without colour. Areas and bands take the style's colour, lightened.
  int style = 1;
  bool is_faint = false;  ///< a line beyond what was measured: thin and dotted in its colour
};

/// A line across the whole panel.
struct Rule {
  double at = 0.0;
  bool vertical = false;
  std::string label = {};  ///< text in the key; empty: not listed
};

/// How the background of a part looks. What the record shows and what it does not never look alike.
enum class Look {
  plain,    ///< grey
  hatched,  ///< what the record does not show
};

/// A part of the x axis with a background of its own.
struct Shade {
  double from = 0.0;
  double to = 0.0;
  std::string label = {};  ///< text in the key; empty: not listed
  Look look = Look::plain;
};

/// Text in a panel, centred on a point.
struct Caption {
  double x = 0.0;
  double y = 0.0;
  std::string text;
};

/// A tick mark with its own text.
struct Tick {
  double at = 0.0;
  std::string text;
};

/// One pair of axes. Empty ranges follow from the values.
struct Panel {
  std::string x_label;
  std::string y_label;
  std::vector<Series> series = {};
  std::vector<Rule> rules = {};
  std::vector<Shade> shades = {};
  std::vector<Caption> captions = {};
  std::vector<Tick> x_ticks = {};  ///< instead of numbers on the x axis
  std::optional<std::pair<double, double>> x_range = {};
  std::optional<std::pair<double, double>> y_range = {};
  bool log_x = false;
  bool has_equal_scales = false;  ///< equal units on both axes; needs both ranges
  bool is_map = false;            ///< equal scales and no axes; needs both ranges
};

/// Panels one below the other, their left and right edges aligned.
struct Figure {
  std::string title;  ///< read out by screen readers; drawn in characters only
  std::vector<Panel> panels;
};

}  // namespace eha::plot
