// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/report/page.hpp"

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <algorithm>
#include <cstddef>
#include <ctime>
#include <set>
#include <string_view>
#include <utility>

#include "daemon/plot/gnuplot.hpp"
#include "daemon/report/html.hpp"

namespace eha::report {
namespace {

constexpr const char* kStyle = R"(
:root { color-scheme: light dark; }
* { box-sizing: border-box; }
body { margin: 0; background: #fff; color: #111; font: 16px/1.45 "Liberation Sans", Arial, Helvetica, sans-serif; }
main { max-width: 1120px; margin: 0 auto; padding: 16px; }
h1 { font-size: 1.6em; margin: 0 0 .1em; overflow-wrap: anywhere; }
h2 { font-size: 1.25em; margin: 1.6em 0 .5em; padding-bottom: .15em; border-bottom: 2px solid #111; }
h3 { font-size: 1em; margin: 1em 0 .3em; overflow-wrap: anywhere; }
p { margin: .4em 0; overflow-wrap: anywhere; }
ul { margin: .4em 0; padding-left: 1.3em; overflow-wrap: anywhere; }
.subtitle { color: #444; }
summary { cursor: pointer; overflow-wrap: anywhere; }
summary { font-weight: bold; }
details.section > summary { font-size: 1.25em; }
details.section { margin: 1.2em 0 0; padding-top: .5em; border-top: 1px solid #bbb; }
details.section[open] > summary { margin-bottom: .5em; }
.verdict { border: 2px solid #111; padding: 4px 16px 8px; margin: 16px 0; }
.verdict.some { border-left-width: 12px; }
.verdict.none { border-style: dashed; }
.verdict h2 { border: 0; margin: .4em 0; }
.equation { font-family: "Liberation Serif", "Times New Roman", serif; font-size: 1.1em; }
.fraction { display: inline-block; vertical-align: middle; text-align: center; }
.fraction > span { display: block; padding: 0 .4em; }
.fraction > span:nth-last-child(2) { border-top: 1px solid #111; }
.fraction > .hidden { position: absolute; width: 1px; height: 1px; padding: 0; overflow: hidden; clip-path: inset(50%); }
.item { margin: 0 0 1.2em; }
.plot { overflow-x: auto; }
.plot svg { display: block; width: 100%; height: auto; }
pre { overflow-x: auto; }
code { -webkit-user-select: all; user-select: all; overflow-wrap: anywhere; }
.missing { border: 1px dashed #111; padding: 12px; }
.remark dt { font-weight: bold; margin-top: .4em; }
.remark dd { margin: 0; }
.table { overflow-x: auto; }
table { border-collapse: collapse; margin: .5em 0; font-size: .9em; }
th, td { border-bottom: 1px solid #bbb; padding: 3px 10px 3px 0; text-align: left; vertical-align: top; }
th { border-bottom: 2px solid #111; vertical-align: bottom; }
td.number, th.number { text-align: right; font-variant-numeric: tabular-nums; }
td.number, .option { white-space: nowrap; }
td.wide { overflow-wrap: anywhere; min-width: 14em; }
td.name { overflow-wrap: anywhere; min-width: 7em; }
td.number + td:not(.number), th.number + th:not(.number) { padding-left: 10px; }
@media (max-width: 600px) {
  main { padding: 10px; }
  .verdict { padding: 2px 10px 6px; }
  .verdict.some { border-left-width: 6px; }
  .plot svg { min-width: 500px; }
  pre { font-size: .75em; }
  th, td { padding-right: 6px; }
  th:first-child, td:first-child:not(.id) { overflow-wrap: anywhere; }
  .stacked thead { display: none; }
  .stacked, .stacked tbody, .stacked tr, .stacked td { display: block; width: 100%; }
  .stacked tr { border-bottom: 2px solid #111; padding: 4px 0; }
  .stacked td, .stacked td.number { border: 0; white-space: normal; padding: 1px 0; text-align: left; overflow-wrap: anywhere; }
  .stacked td.wide, .stacked td.name { min-width: 0; }
  .stacked td.number + td:not(.number) { padding-left: 0; }
  .stacked td::before { content: attr(data-label) ": "; font-weight: bold; }
  .stacked td:empty { display: none; }
}
@media (max-width: 519px) {
  .plot::before { content: "The picture goes on to the right: swipe it."; font-size: .8em; }
}
@media (min-width: 900px) {
  .with-plot { display: grid; grid-template-columns: minmax(0, 2fr) minmax(0, 1fr); column-gap: 24px; }
  .with-plot > h3, .with-plot > .below { grid-column: 1 / -1; }
}
@media screen and (prefers-color-scheme: dark) {
  body { background: #16181a; color: #e6e6e6; }
  .subtitle { color: #b5b5b5; }
  h2, .verdict, th, .missing, .stacked tr, .fraction > span:nth-last-child(2) { border-color: #e6e6e6; }
  .plot svg { filter: invert(.91) hue-rotate(180deg); }
}
@page { size: A4; margin: 12mm 14mm 14mm; @bottom-right { content: counter(page) " / " counter(pages); font: 8pt Arial, sans-serif; } }
@media print {
  details::details-content { content-visibility: visible; block-size: auto; }
  body { font-size: 9pt; line-height: 1.35; }
  main { max-width: none; padding: 0; }
  h2 { margin: 1em 0 .4em; }
  p, ul { margin: .25em 0; }
  .item { margin-bottom: .6em; }
  .with-plot { display: grid; grid-template-columns: minmax(0, 7fr) minmax(0, 4fr); column-gap: 5mm; }
  .with-plot > h3, .with-plot > .below { grid-column: 1 / -1; }
  .beside { font-size: 8pt; line-height: 1.25; }
  .plot svg { max-height: 165mm; }
  .plot, .with-plot, dd, tr, li, .equation { break-inside: avoid; }
  #the-other-models::details-content, #the-paper-s-procedure::details-content { content-visibility: hidden; }
  #the-other-models > summary::after, #the-paper-s-procedure > summary::after { content: ": on the screen"; font-weight: normal; }
  h2, h3, thead, summary, dt { break-after: avoid; }
  section > h2 { break-inside: avoid; }
  section > h2::after { content: ""; display: block; height: 35mm; margin-bottom: -35mm; }
  .table, .plot { overflow: visible; }
  pre { white-space: pre-wrap; }
  table { font-size: 7.5pt; width: 100%; }
  td, th { padding: 1px 6px 1px 0; }
  details.section { margin-top: .4em; padding-top: .2em; }
}
)";

std::string remark_html(const Remark& remark) {
  std::string html;
  const auto add = [&](const char* what, const std::string& text) {
    if (!text.empty()) html += fmt::format("<dt>{}</dt><dd>{}</dd>\n", what, with_code(text));
  };
  add("Seen here", remark.seen);
  add("How it should look", remark.good);
  add("To do", remark.to_do);
  return html.empty() ? "" : "<dl class=\"remark\">\n" + html + "</dl>\n";
}

/// "the-other-models", by which the style sheet knows a section.
std::string id_of(std::string_view title) {
  std::string id;
  for (const char c : title) {
    const bool is_letter = (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9');
    id += is_letter ? c : c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : '-';
  }
  return id;
}

/// Letters, digits and hyphens of an option behind its "--".
bool continues_option(char c) { return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '-'; }

/// Keeps "--decimate" in one line: a browser breaks it behind its hyphens. Leaves tags and what is copied as it is.
std::string with_whole_options(std::string_view html) {
  std::string result;
  bool is_code = false;
  for (std::size_t at = 0; at < html.size();) {
    const std::size_t tag = std::min(html.find('<', at), html.size());
    std::string_view text = html.substr(at, tag - at);
    for (std::size_t option; !is_code && (option = text.find(" --")) != std::string_view::npos;) {
      std::size_t end = option + 3;
      while (end < text.size() && continues_option(text[end])) ++end;
      const std::string_view name = text.substr(option + 1, end - option - 1);
      result += text.substr(0, option + 1);
      result += name.size() > 2 ? fmt::format("<span class=\"option\">{}</span>", name) : std::string(name);
      text.remove_prefix(end);
    }
    result += text;
    const std::size_t after = std::min(html.find('>', tag), html.size() - 1) + 1;
    if (tag < html.size()) result += html.substr(tag, after - tag);
    if (html.substr(tag).starts_with("<code>")) is_code = true;
    if (html.substr(tag).starts_with("</code>")) is_code = false;
    at = tag < html.size() ? after : tag;
  }
  return result;
}

std::string item_html(const Item& item, const plot::InlineFigure* drawn) {
  std::string html =
      item.folded ? "<details class=\"item\">\n<summary>" + escaped(item.heading) + "</summary>\n" : std::string();
  html += drawn != nullptr ? "<div class=\"item with-plot\">\n" : "<div class=\"item\">\n";
  if (!item.heading.empty() && !item.folded) html += "<h3>" + escaped(item.heading) + "</h3>\n";
  if (drawn != nullptr) {
    html += drawn->error.empty() ? "<div class=\"plot\">" + drawn->svg + "</div>\n"
                                 : "<p class=\"missing\">This plot is missing: " + escaped(drawn->error) + "</p>\n";
    // Not the picture, whose texts have no spans.
    if (const std::string remark = remark_html(item.remark); !remark.empty())
      html += "<div class=\"beside\">" + with_whole_options(remark) + "</div>\n";
    if (!item.html.empty()) html += "<div class=\"below\">" + with_whole_options(item.html) + "</div>\n";
  } else {
    html += with_whole_options(item.html);
  }
  return html + (item.folded ? "</div>\n</details>\n" : "</div>\n");
}

}  // namespace

Page assembled(const std::string& title, const std::string& lead_html, const std::vector<Section>& sections,
               const std::optional<suggest::RigAccess>& rig) {
  std::vector<plot::Figure> figures;
  for (const Section& section : sections) {
    for (const Item& item : section.items) {
      if (item.figure) figures.push_back(*item.figure);
    }
  }
  const std::vector<plot::InlineFigure> drawn = plot::draw_inline(figures);
  Page page;
  std::set<std::string> missing;
  for (const plot::InlineFigure& figure : drawn) {
    if (!figure.error.empty() && missing.insert(figure.error).second) page.missing.push_back(figure.error);
  }
  const std::string heading = escaped(title);
  page.html =
      "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
      "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n"
      "<link rel=\"icon\" href=\"data:,\">\n<title>" +
      heading + "</title>\n<style>" + kStyle + "</style>\n</head>\n<body>\n<main>\n<h1>" + heading + "</h1>\n" +
      with_whole_options(lead_html);
  std::size_t next = 0;
  for (const Section& section : sections) {
    if (section.items.empty()) continue;
    const std::string name = escaped(section.title);
    page.html += section.folded ? fmt::format("<details class=\"section\" id=\"{}\">\n<summary>{}</summary>\n",
                                              id_of(section.title), name)
                                : "<section>\n<h2>" + name + "</h2>\n";
    for (const Item& item : section.items) {
      page.html += item_html(item, item.figure ? &drawn[next] : nullptr);
      if (item.figure) ++next;
    }
    page.html += section.folded ? "</details>\n" : "</section>\n";
  }
  page.html += fmt::format("<p class=\"subtitle\">Written {:%Y-%m-%d %H:%M} UTC by eha {}.</p>\n",
                           fmt::gmtime(std::time(nullptr)), EHA_VERSION);
  page.html += "</main>\n</body>\n</html>\n";
  if (rig) page.html = suggest::completed_html(page.html, *rig);
  return page;
}

}  // namespace eha::report
