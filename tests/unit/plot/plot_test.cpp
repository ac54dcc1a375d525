// SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <set>
#include <string>
#include <vector>

#include "daemon/plot/axis_range.hpp"
#include "daemon/plot/envelope.hpp"
#include "daemon/plot/gnuplot.hpp"
#include "tests/unit/temporary_folder.hpp"

namespace {

using namespace eha::plot;

Figure ramp(const std::string& title, const std::string& label) {
  Series series{.label = label};
  for (int i = 0; i < 20; ++i) {
    series.x.push_back(i);
    series.y.push_back(0.1 * i);
  }
  return {.title = title, .panels = {{.x_label = "time in s", .y_label = "displacement in in", .series = {series}}}};
}

/// A figure that gnuplot refuses.
Figure undrawable() {
  Figure figure = ramp("nothing", "nothing");
  Series& series = figure.panels[0].series[0];
  std::fill(series.y.begin(), series.y.end(), std::numeric_limits<double>::quiet_NaN());
  return figure;
}

std::set<std::string> ids_of(const std::string& svg) {
  std::set<std::string> ids;
  for (std::size_t at = svg.find(" id="); at != std::string::npos; at = svg.find(" id=", at + 1)) {
    const std::size_t begin = at + 5;
    ids.insert(svg.substr(begin, svg.find(svg[at + 4], begin) - begin));
  }
  return ids;
}

TEST(Quoted, IsAConstantInWhichNothingIsExpanded) {
  EXPECT_EQ(quoted("it's"), "'it\xE2\x80\x99s'");
  EXPECT_EQ(quoted("a\nplot x\tb"), "'a plot x b'");
  EXPECT_EQ(quoted("\xC2\xB5m \xFF \xC3"), "'\xC2\xB5m ? ?'");
  EXPECT_EQ(quoted("a\xC2\x9B"
                   "b"),
            "'a b'");
}

TEST(Gnuplot, TakesNoLabelForACommand) {
  const eha::test::TemporaryFolder folder;
  const std::string file = (folder.path() / "made").string();
  for (const std::string& label :
       std::vector<std::string>{"'; system('touch " + file + "'); set title '", "`touch " + file + "`",
                                "\n!touch " + file + "\n", "@made \\", "EOD\n!touch " + file}) {
    const InlineFigure figure = draw_inline({ramp(label, label)}).front();
    EXPECT_EQ(figure.error, "") << label;
    EXPECT_FALSE(std::filesystem::exists(file)) << label;
  }
}

TEST(Gnuplot, EscapesLabelsForTheirPage) {
  const std::string svg = draw_inline({ramp("a < b & c", "<script>alert(1)</script>")}).front().svg;
  EXPECT_EQ(svg.find("<script"), std::string::npos);
  EXPECT_NE(svg.find("a &lt; b &amp; c"), std::string::npos);
}

TEST(Gnuplot, GivesTheFiguresOfAPageDifferentIds) {
  const auto figures = draw_inline({ramp("one", "a"), ramp("two", "b")});
  ASSERT_EQ(figures.size(), 2U);
  const std::set<std::string> first = ids_of(figures[0].svg);
  const std::set<std::string> second = ids_of(figures[1].svg);
  ASSERT_FALSE(first.empty());
  for (const std::string& id : first) EXPECT_EQ(second.count(id), 0U) << id;
}

TEST(Gnuplot, LeavesOutTheFigureThatFailsAlone) {
  const auto figures = draw_inline({ramp("one", "a"), undrawable(), ramp("three", "c")});
  ASSERT_EQ(figures.size(), 3U);
  EXPECT_EQ(figures[0].error, "");
  EXPECT_NE(figures[1].error, "");
  EXPECT_EQ(figures[1].svg, "");
  EXPECT_NE(figures[2].svg.find("<title>three</title>"), std::string::npos);
}

TEST(Gnuplot, NamesThePackageWhereItIsMissing) {
  const std::string path = std::getenv("PATH");
  setenv("PATH", "/nowhere", 1);
  try {
    (void)draw(ramp("a", "b"), Format::svg);
    ADD_FAILURE() << "drew without gnuplot";
  } catch (const PlotError& error) {
    EXPECT_NE(std::string(error.what()).find("apt install gnuplot-nox"), std::string::npos) << error.what();
  }
  setenv("PATH", path.c_str(), 1);
}

TEST(Gnuplot, DrawsPicturesOfEveryFormat) {
  EXPECT_EQ(draw(ramp("a", "b"), Format::png).substr(1, 3), "PNG");
  EXPECT_EQ(draw(ramp("a", "b"), Format::pdf).substr(0, 4), "%PDF");
  EXPECT_NE(draw(ramp("a", "b"), Format::svg).find("<svg"), std::string::npos);
}

TEST(Gnuplot, JoinsLinesRound) {
  const std::string svg = draw(ramp("a", "b"), Format::svg);
  EXPECT_EQ(svg.find("miter"), std::string::npos) << "a sharp turn between near samples would end in a spike";
  EXPECT_NE(svg.find("stroke-linejoin=\"round\""), std::string::npos);
}

TEST(Gnuplot, EndsAnAxisWithTheData) {
  Figure figure = ramp("a", "b");
  Series& series = figure.panels.front().series.front();
  series.x = {0.0, 61.0, 122.0};
  series.y = {0.0, 1.0, 2.0};
  figure.panels.front().x_range = {};
  const std::string svg = draw(figure, Format::svg);
  EXPECT_NE(svg.find(">120<"), std::string::npos) << "without a blank before it, which would shift it";
  EXPECT_EQ(svg.find("140<"), std::string::npos);
}

TEST(Gnuplot, NamesTheEndOfARecordThatEndsASampleBeforeAMark) {
  Figure figure = ramp("a", "b");
  Series& series = figure.panels.front().series.front();
  series.x = {0.04, 20.0, 49.96};
  series.y = {0.0, 1.0, 2.0};
  figure.panels.push_back(figure.panels.front());
  figure.panels.back().series.front().x = {0.0, 20.0, 49.99};
  const std::string svg = draw(figure, Format::svg);
  const auto times = [&](const std::string& label) {
    std::size_t count = 0;
    for (std::size_t at = svg.find(label); at != std::string::npos; at = svg.find(label, at + 1)) ++count;
    return count;
  };
  EXPECT_EQ(times(">50<"), 2U) << "at both panels";
}

TEST(AxisRange, HasThreeToSixMarksAndPartsOfATurnForDegrees) {
  const auto marks = [](double low, double high, const std::string& label) {
    Panel panel{.x_label = "", .y_label = label};
    panel.series.push_back({.label = "", .x = {0.0, 1.0}, .y = {low, high}});
    const Range ends = y_ends(panel);
    return static_cast<int>(std::lround((ends->second - ends->first) / y_step(panel))) + 1;
  };
  for (double high = 0.01; high < 1000.0; high *= 1.07) {
    EXPECT_GE(marks(0.0, high, "error [in]"), 3) << high;
    EXPECT_LE(marks(0.0, high, "error [in]"), 6) << high;
    EXPECT_LE(marks(-0.37 * high, 0.63 * high, "error [in]"), 7) << high;
  }
  Panel phase{.x_label = "", .y_label = "phase [deg]", .y_range = {{-175.0, -2.0}}};
  EXPECT_DOUBLE_EQ(y_step(phase), 45.0);
}

TEST(AxisRange, HasThreeMarksOrMoreOnAFixedAxis) {
  Panel gain{.x_label = "", .y_label = "gain [dB]", .y_range = std::pair(-70.0, 47.0)};
  EXPECT_DOUBLE_EQ(y_step(gain), 20.0) << "0 and -50 alone say little of a peak of 38 dB";
  for (double low = -100.0; low < 0.0; low += 7.3) {
    for (double high = 1.0; high < 100.0; high += 3.7) {
      gain.y_range = std::pair(low, high);
      const double step = y_step(gain);
      EXPECT_GE(std::floor(high / step) - std::ceil(low / step), 2.0) << low << " to " << high;
    }
  }
}

TEST(Gnuplot, DrawsABroadCurveBeneathAThinOneInTheOrderOfTheKey) {
  Figure figure = ramp("a", "recommended");
  figure.panels[0].series.push_back(figure.panels[0].series[0]);
  figure.panels[0].series[1].label = "runner-up";
  figure.panels[0].series[1].style = 2;
  const std::string script = script_of(figure, Surface::page);
  EXPECT_LT(script.find("title 'recommended'"), script.find("title 'runner-up'"));
  EXPECT_LT(script.find("d1 using"), script.find("d0 using")) << "the thin black line lies on the broad one";
  figure.panels[0].series[1].mark = Mark::points;
  figure.panels[0].series[1].style = 0;
  const std::string points = script_of(figure, Surface::page);
  EXPECT_LT(points.find("d1 using"), points.find("d0 using")) << "and on many measured points";
}

TEST(Gnuplot, DrawsTheFirstCurveLastInCharactersWhichHideOneAnother) {
  Figure figure = ramp("a", "measured");
  figure.panels[0].series.push_back(figure.panels[0].series[0]);
  figure.panels[0].series[1].label = "model";
  const std::string script = script_of(figure, Surface::characters);
  EXPECT_LT(script.find("d1 using"), script.find("d0 using")) << script;
  EXPECT_LT(script.find("title 'measured'"), script.find("title 'model'"));
}

TEST(Gnuplot, MarksTheDecadesOfALogarithmicAxisAndMoreWhereTheyAreFew) {
  Figure figure = ramp("bode", "model");
  figure.panels[0].log_x = true;
  figure.panels[0].x_range = {{0.02, 30.0}};
  const std::string few = script_of(figure, Surface::page);
  EXPECT_NE(few.find("set xtics norotate offset 0,0.3 ('0.1' 0.1, '1' 1, '10' 10, '' 0.02 1, '' 0.03 1"),
            std::string::npos)
      << few;
  EXPECT_NE(few.find("'' 20 1, '' 30 1)"), std::string::npos) << "no mark beyond the axis: " << few;
  EXPECT_NE(few.find("set grid mxtics"), std::string::npos) << "the marks have lines";
  figure.panels[0].x_range = {{1e-3, 1e3}};
  EXPECT_EQ(script_of(figure, Surface::page).find("'' 0.02 1"), std::string::npos) << "a wall of lines";
  figure.panels[0].x_range = {{0.05, 0.65}};
  EXPECT_NE(script_of(figure, Surface::page).find("('0.1' 0.1, '0.2' 0.2, '0.05' 0.05, '0.5' 0.5, '' 0.06 1"),
            std::string::npos)
      << "one number is no scale\n"
      << script_of(figure, Surface::page);
}

TEST(Gnuplot, ListsRulesAndShadesInTheKeyAndHatchesWhatIsNotKnown) {
  Figure figure = ramp("title", "curve");
  figure.panels[0].shades = {{0.0, 2.0, "usable band"}, {3.0, 4.0, "not tested", Look::hatched}};
  figure.panels[0].rules = {{.at = 5.0, .vertical = true, .label = "validated from here"}, {.at = 1.0}};
  const std::string script = script_of(figure, Surface::page);
  for (const char* label : {"usable band", "not tested", "validated from here"}) {
    const std::size_t at = script.find(std::string("title '") + label + "'");
    ASSERT_NE(at, std::string::npos) << label;
    EXPECT_NE(script.rfind("keyentry", at), std::string::npos) << label;
  }
  EXPECT_NE(script.find("fs solid noborder title 'usable band'"), std::string::npos);
  EXPECT_NE(script.find("pattern 4 noborder title 'not tested'"), std::string::npos);
  EXPECT_EQ(draw_inline({figure}).front().error, "");
  EXPECT_EQ(script_of(figure, Surface::characters).find("keyentry with filledcurves"), std::string::npos);
}

TEST(Gnuplot, DrawsGuidesBeneathEveryLine) {
  Figure figure = ramp("title", "model");
  figure.panels[0].series.push_back(figure.panels[0].series[0]);
  figure.panels[0].series[1].style = kGuideStyle;
  const std::string script = script_of(figure, Surface::page);
  EXPECT_LT(script.find("$p0d1 using"), script.find("$p0d0 using"));
}

TEST(Gnuplot, DrawsNoRuleBeyondItsAxes) {
  Figure figure = ramp("a", "b");
  figure.panels[0].rules = {{.at = -90.0, .vertical = false}};
  EXPECT_EQ(script_of(figure, Surface::page).find("set arrow from"), std::string::npos);
  figure.panels[0].rules = {{.at = 1.0, .vertical = false}};
  EXPECT_NE(script_of(figure, Surface::page).find("set arrow from"), std::string::npos);
}

TEST(Gnuplot, GivesALongKeyRoomOfItsOwn) {
  Figure figure = ramp("a", "measured");
  figure.panels.push_back(figure.panels.front());
  const double short_key = height_px(figure, Surface::page);
  for (const char* name :
       {"integrator_lag_residual", "cylinder_residual", "io1_residual", "io_residual", "fo_residual"}) {
    figure.panels.back().series.push_back(figure.panels.back().series.front());
    figure.panels.back().series.back().label = name;
  }
  // Six entries, at most two of which fit beside one another.
  EXPECT_GE(height_px(figure, Surface::page), short_key + 2 * 18.0);
  const std::string script = script_of(figure, Surface::page);
  const auto height_of = [&](std::size_t panel) {
    std::size_t at = 0;
    for (std::size_t i = 0; i <= panel; ++i) at = script.find("set size 1, ", at) + 12;
    return std::stod(script.substr(at)) * height_px(figure, Surface::page);
  };
  EXPECT_GT(height_of(1), height_of(0) + 2 * 18.0) << "the panel with the long key grows, not the other one";
}

TEST(Gnuplot, BreaksATitleThatIsWiderThanThePicture) {
  Figure figure = ramp("short title", "");
  const double one = height_px(figure, Surface::file);
  EXPECT_NE(script_of(figure, Surface::file).find("set label 'short title' at screen"), std::string::npos);
  figure.title = "20260101T120000Z-paper, simulated rig: integrator_lag_valve (usable), recommended, and its runner-up";
  const std::string script = script_of(figure, Surface::file);
  EXPECT_NE(script.find("set label '20260101T120000Z-paper, simulated rig: integrator_lag_valve' at"),
            std::string::npos)
      << script;
  EXPECT_NE(script.find("set label '(usable), recommended, and its runner-up' at"), std::string::npos) << script;
  EXPECT_GT(height_px(figure, Surface::file), one + 10.0);
  EXPECT_EQ(height_px(figure, Surface::page), one - 28.0) << "a page has its headings";
}

TEST(Gnuplot, SlantsNamesAtTheAxisThatWouldCollideOrBeCutOff) {
  Figure figure = ramp("a", "");
  Panel& panel = figure.panels[0];
  panel.x_ticks = {{1.0, "a2"}, {2.0, "K"}, {3.0, "null"}, {4.0, "b1"}};
  EXPECT_NE(script_of(figure, Surface::page).find("set xtics norotate"), std::string::npos);
  const double level = height_px(figure, Surface::page);
  panel.x_ticks = {{1.0, "null"}, {2.0, "dead_band"}, {3.0, "negative_gain_ratio"}, {4.0, "K"}};
  EXPECT_NE(script_of(figure, Surface::page).find("rotate by 25 right"), std::string::npos);
  // A name of 200 px beside the left edge, which is 140 px away.
  panel.x_ticks[0].text = "20261125T231210Z-paper-as";
  const std::string script = script_of(figure, Surface::page);
  const std::size_t at = script.find("rotate by ");
  ASSERT_NE(at, std::string::npos);
  EXPECT_GT(std::stod(script.substr(at + 10)), 40.0);
  EXPECT_GT(height_px(figure, Surface::page), level + 80.0) << "which needs room below";
}

TEST(Gnuplot, GivesDigitsAndCapitalsOfAKeyTheirWidth) {
  const auto key_width = [](const std::string& label) {
    const std::string script = script_of(ramp("a", label), Surface::page);
    return std::stod(script.substr(script.find("set key width ") + 14));
  };
  EXPECT_LT(key_width("integrator_lag_valve_x"), -3.0);
  EXPECT_GT(key_width("20261125T231210Z-paper"), -2.0);
}

TEST(Gnuplot, DrawsACircleAsOneWhereScalesAreEqual) {
  Figure figure{.title = "circle", .panels = {{.x_label = "real", .y_label = "imaginary"}}};
  Series circle{.label = ""};
  for (int i = 0; i < 60; ++i) {
    circle.x.push_back(std::cos(0.1 * i));
    circle.y.push_back(std::sin(0.1 * i));
  }
  Panel& panel = figure.panels[0];
  panel.series.push_back(circle);
  panel.x_range = {{-2.0, 1.0}};
  panel.y_range = {{-2.0, 1.0}};
  panel.has_equal_scales = true;
  EXPECT_NE(script_of(figure, Surface::page).find("set size ratio -1"), std::string::npos);
  panel.has_equal_scales = false;
  EXPECT_EQ(script_of(figure, Surface::page).find("ratio -1"), std::string::npos);
}

TEST(Gnuplot, DrawsTheTitleIntoFilesOnly) {
  EXPECT_NE(draw(ramp("rod of the bench", "b"), Format::svg).find("rod of the bench"), std::string::npos);
  const std::string page = script_of(ramp("rod of the bench", "b"), Surface::page);
  EXPECT_EQ(page.find("rod of the bench"), std::string::npos) << "a page has it as the heading";
}

TEST(Gnuplot, KeepsCharactersWithinTheTerminal) {
  const std::string text = draw_in_characters(ramp("a ramp", "measured"), {.columns = 60, .rows = 20});
  EXPECT_NE(text.find("measured"), std::string::npos);
  std::size_t lines = 0;
  for (std::size_t at = 0; at < text.size(); ++lines) {
    const std::size_t end = text.find('\n', at);
    EXPECT_LE(end - at, 60U);
    at = end + 1;
  }
  EXPECT_LE(lines, 20U);
}

TEST(Envelope, KeepsEveryPeakOfALongSignal) {
  std::vector<double> x(100'000);
  std::vector<double> y(x.size());
  for (std::size_t i = 0; i < x.size(); ++i) {
    x[i] = static_cast<double>(i);
    y[i] = std::sin(1e-3 * x[i]);
  }
  y[77'777] = 5.0;
  y[12'345] = -5.0;
  const Points points = envelope(x, y, 300);
  EXPECT_LE(points.x.size(), 600U);
  EXPECT_EQ(*std::max_element(points.y.begin(), points.y.end()), 5.0);
  EXPECT_EQ(*std::min_element(points.y.begin(), points.y.end()), -5.0);
  EXPECT_TRUE(std::is_sorted(points.x.begin(), points.x.end()));
}

TEST(Envelope, KeepsAPeakBesideAGap) {
  std::vector<double> x(10'000);
  std::vector<double> y(x.size(), 0.0);
  for (std::size_t i = 0; i < x.size(); ++i) x[i] = static_cast<double>(i);
  for (std::size_t i = 2'005; i < 4'005; ++i) y[i] = std::nan("");
  y[2'002] = 7.0;
  y[4'007] = -7.0;
  const Points points = envelope(x, y, 1000);
  EXPECT_EQ(std::count(points.y.begin(), points.y.end(), 7.0), 1);
  EXPECT_EQ(std::count(points.y.begin(), points.y.end(), -7.0), 1);
  EXPECT_TRUE(std::any_of(points.y.begin(), points.y.end(), [](double value) { return std::isnan(value); }));
  EXPECT_TRUE(std::is_sorted(points.x.begin(), points.x.end()));
}

TEST(Envelope, LeavesAShortSignalAlone) {
  const std::vector<double> x{0, 1, 2};
  const std::vector<double> y{3, 4, 5};
  EXPECT_EQ(envelope(x, y, 2).y, y);
}

}  // namespace
