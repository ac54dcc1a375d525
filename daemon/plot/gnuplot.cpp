// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/plot/gnuplot.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <signal.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <optional>
#include <string_view>
#include <system_error>
#include <thread>

#include "core/os/child_process.hpp"
#include "core/os/file_descriptor.hpp"
#include "core/os/files.hpp"

namespace eha::plot {
namespace {

constexpr std::size_t kMostMessages = 300;  // bytes of gnuplot's error message that are repeated
constexpr int kWidth_px = 600;

std::string path_of_gnuplot() {
  const char* path = std::getenv("PATH");
  std::string_view rest = path != nullptr ? path : "/usr/local/bin:/usr/bin:/bin";
  while (!rest.empty()) {
    const std::size_t end = std::min(rest.find(':'), rest.size());
    const std::string program = std::string(rest.substr(0, end)) + "/gnuplot";
    if (program.front() == '/' && access(program.c_str(), X_OK) == 0) return program;
    rest.remove_prefix(std::min(end + 1, rest.size()));
  }
  throw PlotError("gnuplot is not installed; no plot can be drawn. Install it: sudo apt install gnuplot-nox");
}

os::FileDescriptor anonymous_file() {
  os::FileDescriptor file(memfd_create("eha-plot", MFD_CLOEXEC));
  if (!file) throw PlotError("cannot create a file for gnuplot: " + std::generic_category().message(errno));
  return file;
}

std::string content_of(const os::FileDescriptor& file) {
  const off_t size = lseek(file.get(), 0, SEEK_END);
  lseek(file.get(), 0, SEEK_SET);
  std::string content(size > 0 ? static_cast<std::size_t>(size) : 0, '\0');
  content.resize(os::read_up_to(file, content.data(), content.size(), "gnuplot's output"));
  return content;
}

void write_all(const os::FileDescriptor& file, std::string_view text) {
  while (!text.empty()) {
    const ssize_t written = write(file.get(), text.data(), text.size());
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) throw PlotError("cannot hand gnuplot its commands: " + std::generic_category().message(errno));
    text.remove_prefix(static_cast<std::size_t>(written));
  }
  lseek(file.get(), 0, SEEK_SET);
}

/// Returns the first lines of gnuplot's error message, joined to one.
std::string complaint(const os::FileDescriptor& messages) {
  std::string text;
  for (const char c : content_of(messages)) {
    const bool is_blank = c == '\n' || c == ' ' || c == '\t' || c == '^';
    if (is_blank && (text.empty() || text.back() == ' ')) continue;
    text += is_blank ? ' ' : c;
    if (text.size() >= kMostMessages) break;
  }
  return text.empty() ? "without a message" : text;
}

/// Runs gnuplot on a script. @returns its standard output
std::string run_gnuplot(std::string_view script) {
  const std::string program = path_of_gnuplot();
  const os::FileDescriptor commands = anonymous_file();
  const os::FileDescriptor output = anonymous_file();
  const os::FileDescriptor messages = anonymous_file();
  write_all(commands, script);
  // -d: no start-up files. With a script to load gnuplot ends at the first error; it reads its standard input byte by
  // byte, and a file that it opens in blocks. GNUTERM: the caller's choice for screens, with which gnuplot fails where
  // there is none.
  os::ChildProcess process({.words = {"/usr/bin/env", "-u", "GNUTERM", program, "-d", "/dev/stdin"},
                            .standard_input = &commands,
                            .standard_output = &output,
                            .standard_error = &messages});
  const auto begun = std::chrono::steady_clock::now();
  std::optional<os::ChildEnd> end;
  while (!(end = process.poll())) {
    if (std::chrono::steady_clock::now() - begun > kTimeLimit) {
      process.signal(SIGKILL);
      throw PlotError(fmt::format("gnuplot took over {} s and was ended", kTimeLimit.count()));
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  }
  const int status = end->status.value_or(0);
  if (WIFSIGNALED(status)) throw PlotError(fmt::format("gnuplot was ended by signal {}", WTERMSIG(status)));
  if (WEXITSTATUS(status) != 0) throw PlotError("gnuplot failed: " + complaint(messages));
  std::string drawn = content_of(output);
  if (drawn.empty()) throw PlotError("gnuplot drew nothing: " + complaint(messages));
  return drawn;
}

// Round joins: a mitred one ends in a spike at each sharp turn, so noisy samples closer than a line is wide become a
// blot. gnuplot's Cairo terminals round the ends of dashes with the joins, which closes the gaps, and keep the mitres.
std::string svg_terminal(double height_px) {
  return fmt::format("set terminal svg size {},{:.0f} noenhanced rounded font 'Arial,14' background '#ffffff'\n",
                     kWidth_px, height_px);
}

std::string terminal(const Figure& figure, Format format) {
  constexpr int kPixelRatio = 2;
  const double height = height_px(figure, Surface::file);
  switch (format) {
    case Format::svg:
      return svg_terminal(height);
    case Format::png:
      return fmt::format(
          "set terminal pngcairo size {},{:.0f} noenhanced font 'Sans,{}' fontscale 0.8 linewidth {} pointscale {}\n",
          kWidth_px * kPixelRatio, height * kPixelRatio, 12 * kPixelRatio, kPixelRatio, kPixelRatio);
    case Format::pdf:
      return fmt::format("set terminal pdfcairo size {:.2f}in,{:.2f}in noenhanced font 'Sans,10'\n", kWidth_px / 80.0,
                         height / 80.0);
  }
  return {};
}

/// Replaces every `from` by `to`.
void replace_all(std::string& text, std::string_view from, const std::string& to) {
  for (std::size_t at = text.find(from); at != std::string::npos; at = text.find(from, at + to.size())) {
    text.replace(at, from.size(), to);
  }
}

std::string xml_text(const std::string& text) {
  std::string result;
  for (const char c : text) {
    switch (c) {
      case '&':
        result += "&amp;";
        break;
      case '<':
        result += "&lt;";
        break;
      case '>':
        result += "&gt;";
        break;
      case '"':
        result += "&quot;";
        break;
      default:
        result += c;
    }
  }
  return result;
}

/// Converts gnuplot's document to an element of a page.
std::string as_element(std::string svg, std::size_t number, const std::string& title) {
  const std::size_t begin = svg.find("<svg");
  const std::size_t body = svg.find("<g id=\"gnuplot_canvas\">");
  const std::size_t end = svg.rfind("</svg>");
  if (begin == std::string::npos || body == std::string::npos || end == std::string::npos || end < body) {
    throw PlotError("gnuplot's picture is not the expected SVG");
  }
  const std::size_t box = svg.find("viewBox=\"", begin);
  const std::string view_box = box < body ? svg.substr(box, svg.find('"', box + 9) + 1 - box) : std::string();
  std::string element = svg.substr(body, end - body);
  // A browser shows them under the pointer: "gnuplot_plot_1a".
  constexpr std::string_view kOwnTitle = "<title>gnuplot_plot_";
  constexpr std::string_view kTitleEnd = "</title>";
  for (std::size_t at = element.find(kOwnTitle); at != std::string::npos; at = element.find(kOwnTitle, at)) {
    const std::size_t after = element.find(kTitleEnd, at);
    if (after == std::string::npos) break;
    element.erase(at, after + kTitleEnd.size() - at);
  }
  // gnuplot gives every picture the same ids and leaves lines at every blank.
  const std::string prefix = fmt::format("f{}-", number);
  for (const char* quote : {"\"", "'"}) {
    replace_all(element, std::string(" id=") + quote, std::string(" id=") + quote + prefix);
    replace_all(element, std::string("xlink:href=") + quote + "#", std::string("href=") + quote + "#" + prefix);
  }
  replace_all(element, "url(#", "url(#" + prefix);
  replace_all(element, " = '", "='");  // no label holds this quote, see quoted()
  const std::string named = quoted(title);
  const std::string label = xml_text(named.substr(1, named.size() - 2));
  return fmt::format(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" {} role=\"img\" aria-label=\"{}\">\n<title>{}</title>\n{}</svg>",
      view_box, label, label, element);
}

/// Draws figures with one gnuplot; `first` numbers them.
std::vector<std::string> draw_elements(const std::vector<Figure>& figures, std::size_t first) {
  std::string script;
  for (const Figure& figure : figures) {
    // Each picture ends at the next `set output`.
    script += "reset\nset output\n" + svg_terminal(height_px(figure, Surface::page)) + script_of(figure, Surface::page);
  }
  script += "set output\n";
  const std::string drawn = run_gnuplot(script);
  constexpr std::string_view kBegin = "<?xml";
  std::vector<std::string> elements;
  for (std::size_t at = drawn.find(kBegin); at != std::string::npos;) {
    const std::size_t next = drawn.find(kBegin, at + kBegin.size());
    if (elements.size() == figures.size()) throw PlotError("gnuplot drew more pictures than asked for");
    elements.push_back(
        as_element(drawn.substr(at, next - at), first + elements.size(), figures[elements.size()].title));
    at = next;
  }
  if (elements.size() != figures.size()) throw PlotError("gnuplot drew fewer pictures than asked for");
  return elements;
}

}  // namespace

std::string draw(const Figure& figure, Format format) {
  return run_gnuplot(terminal(figure, format) + script_of(figure, Surface::file));
}

std::string draw_in_characters(const Figure& figure, const CharacterSize& size) {
  const std::string drawn =
      run_gnuplot(fmt::format("set terminal dumb size {},{} noenhanced nofeed\n", size.columns, size.rows) +
                  script_of(figure, Surface::characters));
  // Returns lines without blanks at their ends.
  std::string text;
  for (std::size_t at = 0; at < drawn.size();) {
    const std::size_t end = std::min(drawn.find('\n', at), drawn.size());
    std::string line = drawn.substr(at, end - at);
    line.erase(line.find_last_not_of(" \f") + 1);
    if (!line.empty() || !text.empty()) text += line + "\n";
    at = end + 1;
  }
  while (text.size() > 1 && text[text.size() - 2] == '\n') text.pop_back();
  return text;
}

std::vector<InlineFigure> draw_inline(const std::vector<Figure>& figures) {
  std::vector<InlineFigure> drawn(figures.size());
  if (figures.empty()) return drawn;
  try {
    std::vector<std::string> elements = draw_elements(figures, 1);
    for (std::size_t i = 0; i < figures.size(); ++i) drawn[i].svg = std::move(elements[i]);
    return drawn;
  } catch (const Error&) {
    // Drawing the figures one by one finds the failing one.
  }
  const auto begun = std::chrono::steady_clock::now();
  for (std::size_t i = 0; i < figures.size(); ++i) {
    try {
      if (std::chrono::steady_clock::now() - begun > kTimeLimit) throw PlotError("the earlier plots took too long");
      drawn[i].svg = draw_elements({figures[i]}, i + 1).front();
    } catch (const Error& error) {
      drawn[i].error = error.what();
    }
  }
  return drawn;
}

}  // namespace eha::plot
