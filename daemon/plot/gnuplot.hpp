// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <chrono>
#include <cstddef>
#include <string>
#include <vector>

#include "core/error.hpp"
#include "daemon/plot/figure.hpp"

// Figures drawn by gnuplot, as a child process. All labels pass through quoted(), and all data are numbers, so gnuplot
// reads none of them as a command. Nothing is written to disk. Thread-safe.

namespace eha::plot {

/// gnuplot is missing, failed, or took too long.
class PlotError : public Error {
 public:
  explicit PlotError(const std::string& message) : Error(ExitCode::device_unavailable, message) {}
};

enum class Format { svg, png, pdf };

/// A terminal's size in characters.
struct CharacterSize {
  std::size_t columns = 79;
  std::size_t rows = 24;
};

/// Longest duration of one call.
inline constexpr std::chrono::seconds kTimeLimit{20};

/// Draws a figure as the bytes of a file.
/// @throws PlotError  gnuplot is not installed (the message names the package), refuses, or takes over kTimeLimit
/// Cost: some 20 ms and the drawing.
[[nodiscard]] std::string draw(const Figure& figure, Format format);

/// A figure in characters. @throws as draw()
[[nodiscard]] std::string draw_in_characters(const Figure& figure, const CharacterSize& size);

/// A figure for an HTML page, or the reason why it is missing.
struct InlineFigure {
  std::string svg;    ///< an <svg> element without size, as wide as its parent; empty after a failure
  std::string error;  ///< one sentence; empty otherwise
};

/// Draws the figures of a page: ids of elements are unique among them, and each has its title for screen readers. One
/// gnuplot draws all of them; if it fails, each has its own, so that a failing figure does not lose the others.
/// @returns one element a figure. Never throws PlotError.
[[nodiscard]] std::vector<InlineFigure> draw_inline(const std::vector<Figure>& figures);

/// Converts text to gnuplot's string constant: single quotes, in which gnuplot expands nothing. Quotes in it become
/// typographic ones, control characters spaces, and bytes that are no UTF-8 '?'.
[[nodiscard]] std::string quoted(const std::string& text);

/// Destination of a figure.
enum class Surface {
  characters,
  page,  ///< below a heading, so without its title
  file,
};

/// Returns the height of a figure [px of a picture 600 wide]: its panels, with room for every line of their keys.
[[nodiscard]] double height_px(const Figure& figure, Surface surface);

/// Returns the commands that draw a figure on the present terminal; exposed for tests.
[[nodiscard]] std::string script_of(const Figure& figure, Surface surface);

}  // namespace eha::plot
