// SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <iterator>
#include <numbers>
#include <string_view>
#include <vector>

#include "core/terminal_text.hpp"
#include "core/utf8.hpp"
#include "daemon/plot/axis_range.hpp"
#include "daemon/plot/gnuplot.hpp"
#include "daemon/plot/key.hpp"

namespace eha::plot {
namespace {

/// Colour, dashes, width and point of a style. The colours differ in lightness, the dashes in length.
struct Style {
  const char* colour;
  const char* dashes;
  double width;
  int point;
};
constexpr std::array<Style, 7> kStyles{{{"#a8a8a8", "solid", 5.0, 6},
                                        {"#000000", "solid", 1.4, 2},
                                        {"#0060a8", "(9,4)", 2.0, 4},
                                        {"#b03000", "(2,3)", 2.0, 8},
                                        {"#2d7000", "(11,3,2,3)", 2.0, 12},
                                        {"#7a2a90", "(5,5)", 1.6, 1},
                                        {"#8a6a00", "(14,4,2,4,2,4)", 1.6, 10}}};

constexpr double kPanelHeight_px = 225.0;  // of a panel among several
constexpr double kSinglePanelHeight_px = 300.0;
constexpr double kMapHeight_px = 380.0;
constexpr double kKeyLine_px = 20.0;
constexpr double kTitle_px = 28.0;
constexpr double kTitleLine_px = 18.0;   // of each further one
constexpr double kLine_px = 17.0;        // of text
constexpr double kLeftMargin_px = 88.0;  // set lmargin below
constexpr double kPlainMargin_lines = 3.2;

constexpr Style kGuide{"#a0a0a0", "solid", 0.7, 6};

const Style& style_of(int style) {
  if (style == kGuideStyle) return kGuide;
  const std::size_t last = kStyles.size() - 1;
  const auto index = static_cast<std::size_t>(std::max(0, style));
  return kStyles[index <= last ? index : 2 + (index - 2) % (last - 1)];
}

bool is_drawn(const Series& series, bool in_characters) {
  const bool has_area = series.mark == Mark::band || series.mark == Mark::area;
  return !series.x.empty() && !(in_characters && has_area);
}

/// Writes the points as a named block, which contains only numbers.
void add_data(std::string& script, const std::string& name, const Series& series) {
  fmt::format_to(std::back_inserter(script), "{} << EOD\n", name);
  for (std::size_t i = 0; i < series.x.size(); ++i) {
    const double y = series.mark == Mark::band ? series.lower[i] : series.y[i];
    const bool has_range = series.mark == Mark::band || series.mark == Mark::error_bars;
    const double low = has_range ? series.lower[i] : 0.0;
    const double high = has_range ? series.upper[i] : 0.0;
    if (!std::isfinite(series.x[i]) || !std::isfinite(y) || !std::isfinite(low) || !std::isfinite(high)) {
      script += "\n";  // interrupts the curve
    } else if (has_range) {
      fmt::format_to(std::back_inserter(script), "{:.7g} {:.7g} {:.7g} {:.7g}\n", series.x[i], y, low, high);
    } else {
      fmt::format_to(std::back_inserter(script), "{:.7g} {:.7g}\n", series.x[i], y);
    }
  }
  script += "EOD\n";
}

/// How a series is drawn, without data and title: "with lines lc rgb '#000000' ...".
std::string drawn_with(const Series& series, bool in_characters) {
  const Style& style = style_of(series.style);
  if (in_characters) {
    const char* with = series.mark == Mark::line ? "lines" : series.mark == Mark::impulses ? "impulses" : "points";
    return fmt::format("with {} lt {}", with, std::max(series.style, 0) + 1);
  }
  const std::string colour = fmt::format("lc rgb '{}'", style.colour);
  switch (series.mark) {
    case Mark::line:
      if (series.is_faint) return fmt::format("with lines {} dt (3,4) lw 1.3", colour);
      return fmt::format("with lines {} dt {} lw {}", colour, style.dashes, style.width);
    case Mark::points:
      // A model's larger than the bars' point that it may lie on.
      return fmt::format("with points {} pt {} ps {} lw 1.6", colour, style.point, series.style == 0 ? 0.9 : 1.3);
    case Mark::impulses:
      return fmt::format("with impulses {} lw 2.5", colour);
    case Mark::error_bars:
      // A ring about the model's point on it.
      return fmt::format("with yerrorbars {} pt {} ps {} lw 1.6", colour, style.point, series.style == 0 ? 1.6 : 0.9);
    case Mark::band:
    case Mark::area:
      return fmt::format("with filledcurves {}{} fs transparent solid 0.22 noborder",
                         series.mark == Mark::area ? "closed " : "", colour);
  }
  return {};
}

const char* columns_of(const Series& series, bool in_characters) {
  if (series.mark == Mark::band) return "1:3:4";
  return series.mark == Mark::error_bars && !in_characters ? "1:2:3:4" : "1:2";
}

/// Place in the order of drawing: areas, stems, measured points, lines with the broad ones first, so that a thin line
/// stays visible on them and guides beneath all of them, bars, other points.
double drawing_rank(const Series& series) {
  switch (series.mark) {
    case Mark::band:
    case Mark::area:
      return 0.0;
    case Mark::impulses:
      return 1.0;
    case Mark::line:
      if (series.style == kGuideStyle) return 1.8;
      return 2.0 + 1.0 / (1.0 + style_of(series.style).width);
    case Mark::points:
      return series.style == 0 ? 1.5 : 5.0;  // many measured points would hide the line through them
    case Mark::error_bars:
      break;
  }
  return 4.0;
}

const char* fill_of(Look look) {
  switch (look) {
    case Look::plain:
      return "rgb '#e4e4e4' fs solid noborder";
    case Look::hatched:
      return "rgb '#8c8c8c' fs transparent pattern 4 noborder";
  }
  return "";
}

constexpr const char* kRuleLine = "dt (10,6) lw 1 lc rgb '#505050'";

/// The list of a plot command. The key keeps the order of the panel, whatever is drawn first.
std::string plots_of(const Panel& panel, const std::string& prefix, bool in_characters) {
  std::string plots;
  const auto add = [&](const std::string& plot) { plots += (plots.empty() ? "" : ", \\\n  ") + plot; };
  std::vector<std::size_t> order;
  for (std::size_t i = 0; i < panel.series.size(); ++i) {
    const Series& series = panel.series[i];
    if (!is_drawn(series, in_characters)) continue;
    order.push_back(i);
    if (series.label.empty() || (in_characters && series.is_faint)) continue;  // a character is never faint
    const std::string with = drawn_with(series, in_characters);
    // An entry of the key alone knows no closed curve.
    const std::size_t closed = with.find("closed ");
    add("keyentry " + (closed == std::string::npos ? with : std::string(with).erase(closed, 7)) + " title " +
        quoted(series.label));
  }
  for (const Rule& rule : panel.rules) {
    if (!in_characters && !rule.label.empty())
      add(fmt::format("keyentry with lines {} title {}", kRuleLine, quoted(rule.label)));
  }
  for (const Shade& shade : panel.shades) {
    if (in_characters || shade.label.empty()) continue;
    add(fmt::format("keyentry with filledcurves fc {} title {}", fill_of(shade.look), quoted(shade.label)));
  }
  if (in_characters) {
    // A character hides the one beneath: what was measured, the first curve, stays visible.
    std::reverse(order.begin(), order.end());
  } else {
    std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
      return drawing_rank(panel.series[a]) < drawing_rank(panel.series[b]);
    });
  }
  for (const std::size_t i : order) {
    const Series& series = panel.series[i];
    add(fmt::format("{}{} using {} {} notitle", prefix, i, columns_of(series, in_characters),
                    drawn_with(series, in_characters)));
  }
  return plots;
}

void add_range(std::string& script, const char* axis, const std::optional<std::pair<double, double>>& range) {
  if (range && std::isfinite(range->first) && std::isfinite(range->second) && range->first < range->second) {
    fmt::format_to(std::back_inserter(script), "set {}range [{:.7g}:{:.7g}]\n", axis, range->first, range->second);
  } else {
    fmt::format_to(std::back_inserter(script), "set {}range [*:*]\n", axis);
  }
}

void add_decoration(std::string& script, const Panel& panel, const Range& x_range, bool in_characters) {
  script += "unset arrow\nunset object\nunset label\n";
  for (const Shade& shade : panel.shades) {
    if (in_characters || !(shade.from < shade.to) || !std::isfinite(shade.from) || !std::isfinite(shade.to)) continue;
    fmt::format_to(std::back_inserter(script),
                   "set object rectangle from first {:.7g}, graph 0 to first {:.7g}, graph 1 behind fc {}\n",
                   shade.from, shade.to, fill_of(shade.look));
  }
  for (const Rule& rule : panel.rules) {
    const Range ends = rule.vertical ? x_range : y_ends(panel);
    // gnuplot draws an arrow beyond the axes too.
    if (!std::isfinite(rule.at) || (ends && (rule.at < ends->first || rule.at > ends->second))) continue;
    const std::string from =
        rule.vertical ? fmt::format("first {:.7g}, graph 0", rule.at) : fmt::format("graph 0, first {:.7g}", rule.at);
    const std::string to =
        rule.vertical ? fmt::format("first {:.7g}, graph 1", rule.at) : fmt::format("graph 1, first {:.7g}", rule.at);
    fmt::format_to(std::back_inserter(script), "set arrow from {} to {} nohead {}\n", from, to, kRuleLine);
  }
  for (const Caption& caption : panel.captions) {
    fmt::format_to(std::back_inserter(script), "set label {} at first {:.7g}, first {:.7g} center front\n",
                   quoted(caption.text), caption.x, caption.y);
  }
}

/// How the names at the x axis are written.
struct TickLayout {
  double angle_deg = 0.0;     ///< 0: level
  double margin_lines = 0.0;  ///< below the axis
};

/// Names that fit neither beside one another nor, slanted, beside the left edge are slanted more.
TickLayout tick_layout(const Panel& panel) {
  constexpr double kAir_px = 8.0;
  constexpr double kTickLetter_px = 6.6;  // Arial of 14 px
  constexpr double kSlanted_deg = 25.0;
  constexpr double kDegree = std::numbers::pi / 180.0;
  if (panel.x_ticks.empty()) return {};
  double longest = 0.0;
  for (const Tick& tick : panel.x_ticks) longest = std::max(longest, letters_of(tick.text));
  const double slot_px = kKeyWidth_px / static_cast<double>(panel.x_ticks.size());
  const double length_px = kTickLetter_px * longest;
  if (length_px + kAir_px <= slot_px) return {};
  const double left_px = kLeftMargin_px + 0.5 * slot_px - kAir_px;
  const double first_px = kTickLetter_px * letters_of(panel.x_ticks.front().text);
  double angle = kSlanted_deg * kDegree;
  if (first_px * std::cos(angle) > left_px) angle = std::acos(std::min(1.0, left_px / first_px));
  return {angle / kDegree, 1.6 + length_px * std::sin(angle) / kLine_px};
}

double panel_height_px(const Panel& panel, bool is_alone) {
  const std::size_t lines = key_lines(panel);
  const double plain = panel.is_map || panel.has_equal_scales ? kMapHeight_px
                       : is_alone                             ? kSinglePanelHeight_px
                                                              : kPanelHeight_px;
  const double below = std::max(0.0, tick_layout(panel).margin_lines - kPlainMargin_lines) * kLine_px;
  return plain + below + kKeyLine_px * static_cast<double>(lines > 1 ? lines - 1 : 0);
}

/// The title of a picture file, broken at blanks into lines that the picture holds.
std::vector<std::string> title_lines(const Figure& figure, Surface surface) {
  constexpr double kMostLetters = 74.0;
  std::vector<std::string> lines;
  if (surface != Surface::file) return lines;
  for (std::size_t at = 0; at < figure.title.size();) {
    const std::size_t end = std::min(figure.title.find(' ', at), figure.title.size());
    const std::string word = figure.title.substr(at, end - at);
    const bool fits = !lines.empty() && letters_of(lines.back() + " " + word) <= kMostLetters;
    if (fits) {
      lines.back() += " " + word;
    } else {
      lines.push_back(word);
    }
    at = end + 1;
  }
  return lines;
}

double title_px(const Figure& figure, Surface surface) {
  const std::size_t lines = title_lines(figure, surface).size();
  return lines == 0 ? 0.0 : kTitle_px + kTitleLine_px * static_cast<double>(lines - 1);
}

std::string bottom_margin(const Panel& panel) {
  if (const TickLayout ticks = tick_layout(panel); ticks.angle_deg > 0.0) {
    return fmt::format("set bmargin {:.1f}\n", ticks.margin_lines);
  }
  return panel.is_map ? "set bmargin 2.2\n" : panel.x_label.empty() ? "set bmargin 2\n" : "set bmargin 3.2\n";
}

/// Whether the y label is drawn at the picture's edge, as a text: gnuplot's own one moves with the width of the numbers
/// and leaves the picture beside wide ones.
bool has_own_y_label(const Panel& panel, bool in_characters) {
  return !in_characters && !panel.is_map && !panel.has_equal_scales && !panel.y_label.empty();
}

/// Numbers of a logarithmic axis: each decade, and 2 and 5 of each where less than three decades begin within. Over few
/// decades the other multiples have a mark and a grid line without a number.
std::string log_ticks(const Range& range) {
  if (!range || !(range->first > 0.0) || !(range->first < range->second)) return "autofreq";
  const int first = static_cast<int>(std::floor(std::log10(range->first)));
  const int last = static_cast<int>(std::ceil(std::log10(range->second)));
  std::string ticks;
  const auto add = [&](double mantissa) {
    for (int decade = first; decade <= last; ++decade) {
      const double at = mantissa * std::pow(10.0, decade);
      if (at < range->first || at > range->second) continue;
      ticks += fmt::format("{}'{:g}' {:.7g}", ticks.empty() ? "" : ", ", at, at);
    }
  };
  add(1.0);
  constexpr std::ptrdiff_t kEnough = 3;
  const bool has_few = std::count(ticks.begin(), ticks.end(), ',') + 1 < kEnough || ticks.empty();
  if (has_few) {
    add(2.0);
    add(5.0);
  }
  if (ticks.empty()) return "autofreq";
  constexpr int kMostDecades = 4;
  if (last - first <= kMostDecades) {
    for (int decade = first; decade <= last; ++decade) {
      for (int mantissa = 2; mantissa <= 9; ++mantissa) {
        const double at = mantissa * std::pow(10.0, decade);
        const bool has_number = has_few && (mantissa == 2 || mantissa == 5);
        if (at >= range->first && at <= range->second && !has_number) ticks += fmt::format(", '' {:.7g} 1", at);
      }
    }
  }
  return "(" + ticks + ")";
}

/// Of the values of a panel, where it has no range of its own.
Range x_ends(const Panel& panel) {
  Range ends = panel.x_range;
  if (ends) return ends;
  for (const Series& series : panel.series) {
    for (const double x : series.x) {
      if (!std::isfinite(x)) continue;
      ends = ends ? std::pair(std::min(ends->first, x), std::max(ends->second, x)) : std::pair(x, x);
    }
  }
  return ends;
}

void add_axes(std::string& script, const Panel& panel, const Range& x_range, bool in_characters) {
  fmt::format_to(std::back_inserter(script), "set xlabel {} offset 0,{}\nset ylabel {}\n", quoted(panel.x_label),
                 panel.is_map ? 0.0 : 0.5, has_own_y_label(panel, in_characters) ? "''" : quoted(panel.y_label));
  script += panel.log_x ? "set logscale x\n" : "unset logscale\n";
  script += panel.log_x ? "set format x '%g'\n" : "set format x '%h'\n";
  add_range(script, "x", x_range);
  // A record's axis ends with the record, not at the next tick mark.
  script += x_range ? "unset autoscale x\n" : "set autoscale xfix\n";
  add_range(script, "y", panel.y_range);
  if (panel.is_map) {
    script += "unset border\nunset tics\nunset grid\nset size ratio -1\n";
    return;
  }
  script += "set border 3\nset tics nomirror out scale 0.6\n" +
            (y_step(panel) > 0.0 ? fmt::format("set ytics {:.7g}\n", y_step(panel)) : "set ytics autofreq\n") +
            "set grid lt 1 lc rgb '#c8c8c8' lw 0.7 dt solid, lt 1 lc rgb '#d6d6d6' lw 0.5 dt solid\n" +
            (panel.log_x ? "set grid mxtics\n" : "set grid nomxtics\n") + "if (GPVAL_TERM eq 'dumb') unset grid\n" +
            (panel.has_equal_scales ? "set size ratio -1\n" : "set size noratio\n");
  if (panel.x_ticks.empty()) {
    const double step = panel.x_range || panel.log_x ? 0.0 : x_step(x_range);
    script += "set xtics norotate offset 0,0.3 " +
              (panel.log_x  ? log_ticks(x_ends(panel))
               : step > 0.0 ? fmt::format("{:.7g}", step)
                            : std::string("autofreq")) +
              "\n";
    return;
  }
  const double angle_deg = tick_layout(panel).angle_deg;
  script += angle_deg > 0.0 ? fmt::format("set xtics offset 0,0 rotate by {:.0f} right (", angle_deg)
                            : "set xtics norotate offset 0,0.3 (";
  for (const Tick& tick : panel.x_ticks) {
    fmt::format_to(std::back_inserter(script), "{}{} {:.7g}", &tick == &panel.x_ticks.front() ? "" : ", ",
                   quoted(tick.text), tick.at);
  }
  script += ")\n";
}

/// "base: displacement [in]", "error [in] over time [s]; 10 to 20: at rest": a terminal has no place beside the axes,
/// and its key lists neither rules nor shades.
std::string title_in_characters(const Figure& figure, const Panel& panel) {
  std::string title = &panel == &figure.panels.front() ? figure.title : std::string();
  if (!panel.y_label.empty()) title += (title.empty() ? "" : ": ") + panel.y_label;
  if (!panel.x_label.empty()) title += " over " + panel.x_label;
  for (const Rule& rule : panel.rules) {
    if (rule.vertical && !rule.label.empty()) title += fmt::format("; at {:.3g}: {}", rule.at, rule.label);
  }
  for (const Shade& shade : panel.shades) {
    if (!shade.label.empty()) title += fmt::format("; {:.3g} to {:.3g}: {}", shade.from, shade.to, shade.label);
  }
  return title;
}

}  // namespace

std::string quoted(const std::string& text) {
  std::string result = "'";
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t length = character_length(text, at);
    if (length == 0) {
      result += '?';
    } else if (length == 1) {
      const char c = text[at];
      const bool is_control = static_cast<unsigned char>(c) < ' ' || c == '\x7f';
      // gnuplot 5.4 misreads a doubled quote at the beginning of a constant.
      result += c == '\'' ? std::string("\xE2\x80\x99") : std::string(1, is_control ? ' ' : c);
    } else if (controls_text(std::string_view(text).substr(at, length))) {
      result += ' ';  // as those below the blank
    } else {
      result.append(text, at, length);
    }
    at += std::max<std::size_t>(length, 1);
  }
  return result + "'";
}

double height_px(const Figure& figure, Surface surface) {
  double height = title_px(figure, surface);
  for (const Panel& panel : figure.panels) height += panel_height_px(panel, figure.panels.size() == 1);
  return height;
}

std::string script_of(const Figure& figure, Surface surface) {
  const bool in_characters = surface == Surface::characters;
  const bool has_several = figure.panels.size() > 1;
  const double whole_px = height_px(figure, surface);
  std::string script = "set encoding utf8\n";
  script += "set key outside top left horizontal Left reverse samplen 3 spacing 1.1\n";
  if (!in_characters) script += "set lmargin 11\nset rmargin 2.5\n";
  if (has_several && in_characters) script += fmt::format("set multiplot layout {},1\n", figure.panels.size());
  if (!in_characters) script += "set multiplot\n";
  double top_px = whole_px - title_px(figure, surface);
  const Range shared_x = x_range_of(figure);
  for (const Panel& panel : figure.panels) {
    const std::string prefix = fmt::format("$p{}d", &panel - figure.panels.data());
    for (std::size_t i = 0; i < panel.series.size(); ++i) {
      if (is_drawn(panel.series[i], in_characters)) add_data(script, fmt::format("{}{}", prefix, i), panel.series[i]);
    }
    const std::string plots = plots_of(panel, prefix, in_characters);
    const Range x_range = panel.x_range || panel.log_x || !panel.x_ticks.empty() ? panel.x_range : shared_x;
    add_axes(script, panel, x_range, in_characters);
    if (in_characters) {
      script += fmt::format("set title {}\nset xlabel ''\nset ylabel ''\n", quoted(title_in_characters(figure, panel)));
    } else {
      const double height = panel_height_px(panel, !has_several);
      top_px -= height;
      script += fmt::format("set origin 0, {:.5f}\nset size 1, {:.5f}\n", top_px / whole_px, height / whole_px);
      script += bottom_margin(panel) + key_width(panel);
    }
    add_decoration(script, panel, x_range, in_characters);
    if (has_own_y_label(panel, in_characters)) {
      script +=
          fmt::format("set label {} at screen 0.03, graph 0.5 center rotate by 90 front\n", quoted(panel.y_label));
    }
    if (&panel == &figure.panels.front()) {
      double middle_px = whole_px - 0.5 * kTitle_px;
      for (const std::string& line : title_lines(figure, surface)) {
        script +=
            fmt::format("set label {} at screen 0.5, screen {:.4f} center front\n", quoted(line), middle_px / whole_px);
        middle_px -= kTitleLine_px;
      }
    }
    // An empty panel keeps its axes.
    script += "plot " + (plots.empty() ? "[0:1] NaN notitle" : plots) + "\n";
  }
  if (has_several || !in_characters) script += "unset multiplot\n";
  return script;
}

}  // namespace eha::plot
