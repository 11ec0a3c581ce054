// SPDX-License-Identifier: GPL-3.0-or-later
#include "clients/report/plot_svg.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <fstream>
#include <iterator>
#include <limits>
#include <random>
#include <sstream>
#include <stdexcept>

#include "clients/library/histogram.h"
#include "clients/report/session_plot.h"
#include "clients/report/summary.h"
#include "tests/support/data.h"
#include "tests/support/temporary_folder.h"

using namespace haptic;

namespace {

/// Vertices of the n-th data line of a document, in pixels.
std::vector<std::pair<double, double>> line_of(const std::string& svg, int n = 0) {
  size_t at = 0;
  for (int i = 0; i <= n; ++i) at = svg.find("class=\"line\"", at) + 1;
  at = svg.find(" d=\"", at) + 4;
  std::string path = svg.substr(at, svg.find('"', at) - at);
  std::replace_if(
      path.begin(), path.end(), [](char c) { return c == 'M' || c == 'L'; }, ' ');
  std::istringstream numbers(path);
  std::vector<std::pair<double, double>> points;
  for (double x, y; numbers >> x >> y;) points.emplace_back(x, y);
  return points;
}

size_t count_of(const std::string& text, const std::string& part) {
  size_t count = 0;
  for (size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++count;
  return count;
}

Series ramp(size_t count, double seconds) {
  Series series{"ramp", {}, {}};
  for (size_t i = 0; i < count; ++i) {
    series.x.push_back(seconds * static_cast<double>(i) / static_cast<double>(count - 1));
    series.y.push_back(0);
  }
  return series;
}

/// The percentile by the definition of nearest rank.
int64_t exact_percentile(std::vector<int64_t> values, double percent) {
  std::sort(values.begin(), values.end());
  const double rank = std::ceil(percent / 100 * static_cast<double>(values.size()) - 1e-9);
  return values[static_cast<size_t>(std::max(1.0, rank)) - 1];
}

}  // namespace

TEST_CASE("plot: a spike of one sample in a hundred thousand is drawn at its full height",
          "[clients]") {
  const auto where = GENERATE(size_t{0}, size_t{1}, size_t{54'321}, size_t{99'999});
  const double spike = GENERATE(100.0, -100.0);
  Series series = ramp(100'000, 20);
  series.y[where] = spike;
  const std::string svg = svg_document("spike", {{"force", "N", {series}}});
  const auto points = line_of(svg);
  const auto [low, high] = std::minmax_element(
      points.begin(), points.end(), [](auto& a, auto& b) { return a.second < b.second; });
  // the axis ends at the spike: it spans the whole panel, 150 px
  CHECK(high->second - low->second == Approx(150).margin(0.2));
  const double share = static_cast<double>(where) / 99'999;
  const double x = spike > 0 ? low->first : high->first;
  CHECK(x == Approx(76 + share * (1000 - 76 - 28)).margin(0.2));
}

TEST_CASE("plot: a hundred thousand noisy samples stay small, a thousand are all drawn",
          "[clients]") {
  std::mt19937 random(1);
  Series noise = ramp(100'000, 100);
  for (double& y : noise.y) y = static_cast<double>(random() % 1000);
  const std::vector<Panel> panels(6, {"noise", "N", {noise, noise}});
  CHECK(svg_document("noise", panels).size() < 1'000'000);
  Series few = ramp(500, 1);
  for (double& y : few.y) y = static_cast<double>(random() % 1000);
  CHECK(line_of(svg_document("few", {{"few", "N", {few}}})).size() == 500);
}

TEST_CASE("plot: every vertex lies where its sample says", "[clients]") {
  Series wave{"wave", {}, {}};
  for (int i = 0; i <= 200; ++i) {
    wave.x.push_back(0.01 * i);
    wave.y.push_back(std::sin(0.05 * i));
  }
  const auto points = line_of(svg_document("wave", {{"wave", "mm", {wave}}}));
  REQUIRE(points.size() == wave.x.size());
  for (size_t i = 0; i < points.size(); ++i) {
    // x spans 0 to 2 s on 896 px, y −1 to 1 on 150 px; coordinates have one decimal
    CHECK(points[i].first == Approx(76 + 448 * wave.x[i]).margin(0.06));
    CHECK(points[i].second == Approx(56 + 28 + 75 * (1 - wave.y[i])).margin(0.06));
  }
}

TEST_CASE("plot: over a logarithmic axis decades are equally wide", "[clients]") {
  const Series decades{"gain", {1, 10, 100, 1000}, {0, 1, 2, 3}};
  const std::string svg =
      svg_document("bode", {{"gain", "dB", {decades}}}, {"frequency [Hz]", true});
  const auto points = line_of(svg);
  REQUIRE(points.size() == 4);
  for (size_t i = 0; i < 4; ++i) {
    CHECK(points[i].first == Approx(76 + 896.0 / 3 * static_cast<double>(i)).margin(0.06));
  }
  for (const char* text : {">1<", ">2<", ">50<", ">1000<", ">frequency [Hz]<"}) {
    CAPTURE(text);
    CHECK(svg.find(text) != std::string::npos);
  }
  CHECK(svg.find("time [s]") == std::string::npos);
  // the tick of ten stands under its sample
  CHECK(svg.find("<text x=\"374.7\" y=\"252.0\" class=\"tick mid\">10<") != std::string::npos);
  // what has no logarithm is not drawn
  const Series from_zero{"gain", {0, 1, 10}, {5, 1, 2}};
  CHECK(line_of(svg_document("zero", {{"gain", "", {from_zero}}}, {"f", true})).size() == 2);
}

TEST_CASE("plot: time goes forward along every line", "[clients]") {
  std::mt19937 random(7);
  Series noise = ramp(20'000, 20);
  for (double& y : noise.y) y = static_cast<double>(random() % 1000);
  const auto points = line_of(svg_document("noise", {{"noise", "N", {noise}}}));
  CHECK(std::is_sorted(points.begin(), points.end(),
                       [](auto& a, auto& b) { return a.first < b.first; }));
  CHECK(points.size() <= 4 * 897);
}

TEST_CASE("plot: what is not finite interrupts the line and nothing else", "[clients]") {
  Series series = ramp(100, 1);
  series.y[50] = std::numeric_limits<double>::quiet_NaN();
  series.y[70] = std::numeric_limits<double>::infinity();
  const std::string svg = svg_document("gaps", {{"gaps", "N", {series}}});
  CHECK(line_of(svg).size() == 98);
  const size_t line = svg.find("class=\"line\"");
  CHECK(count_of(svg.substr(line), "M") == 3);
  CHECK(count_of(svg, "nan") + count_of(svg, "inf") == 0);
}

TEST_CASE("plot: names are escaped, axes carry units, a legend appears for several series",
          "[clients]") {
  const Series a{"a < b", {0, 1}, {-2, 3}}, b{"\"c\" & d", {0, 1}, {1, 1}};
  const std::string svg = svg_document("F < 6 & more", {{"force", "N", {a, b}}});
  CHECK(svg.find("<title>F &lt; 6 &amp; more</title>") != std::string::npos);
  CHECK(svg.find(">force [N]</text>") != std::string::npos);
  CHECK(svg.find("a &lt; b</tspan>") != std::string::npos);
  CHECK(svg.find("&quot;c&quot; &amp; d</tspan>") != std::string::npos);
  CHECK(svg.find(">−2</text>") != std::string::npos);
  CHECK(svg.find(">time [s]</text>") != std::string::npos);
  CHECK(svg_document("one", {{"force", "N", {a}}}).find("a &lt; b") == std::string::npos);
}

TEST_CASE("plot: constant, tiny and huge values have readable axes", "[clients]") {
  const double value = GENERATE(0.0, 3.0, -7e-9, 4e8, 1e-300);
  const Series flat{"flat", {0, 1, 2}, {value, value, value}};
  const std::string svg = svg_document("flat", {{"flat", "N", {flat}}});
  CAPTURE(value);
  CHECK(line_of(svg).size() == 3);
  CHECK(count_of(svg, "class=\"tick end\"") >= 2);
  CHECK(count_of(svg, "class=\"tick end\"") <= 12);
}

TEST_CASE("plot: nothing to draw and unequal lengths are refused with a reason", "[clients]") {
  CHECK_THROWS_WITH(svg_document("none", {}), Catch::Contains("no samples"));
  CHECK_THROWS_WITH(svg_document("odd", {{"p", "N", {{"s", {0, 1}, {0}}}}}),
                    Catch::Contains("2 times and 1 values"));
  CHECK_THROWS_WITH(write_svg("/nowhere/at/all.svg", "t", {{"p", "N", {{"s", {0, 1}, {0, 1}}}}}),
                    Catch::Contains("/nowhere/at/all.svg: cannot be written"));
}

TEST_CASE("histogram: percentiles are those of the sorted values to one part in 128", "[clients]") {
  std::mt19937_64 random(3);
  const int octaves = GENERATE(4, 12, 30, 62);
  std::vector<int64_t> values;
  Histogram histogram;
  for (int i = 0; i < 5000; ++i) {
    const int shift = 63 - static_cast<int>(random() % static_cast<uint64_t>(octaves));
    values.push_back(static_cast<int64_t>(random() >> shift));
    histogram.add(values.back());
  }
  for (const double percent : {0.0, 1.0, 50.0, 90.0, 99.0, 99.9, 100.0}) {
    const int64_t exact = exact_percentile(values, percent), got = histogram.percentile(percent);
    CAPTURE(octaves, percent, exact, got);
    CHECK(got >= exact);
    CHECK(got - exact <= exact / 128);
  }
  CHECK(histogram.count() == values.size());
  CHECK(histogram.max() == *std::max_element(values.begin(), values.end()));
}

TEST_CASE("histogram: small, extreme and negative values are kept", "[clients]") {
  Histogram histogram;
  CHECK(histogram.percentile(50) == 0);
  for (const int64_t value : {int64_t{-5}, int64_t{3}, std::numeric_limits<int64_t>::max()}) {
    histogram.add(value);
  }
  CHECK(histogram.percentile(1) == 0);
  CHECK(histogram.percentile(50) == 3);
  CHECK(histogram.percentile(100) == std::numeric_limits<int64_t>::max());
}

TEST_CASE("histogram: one in a thousand shows at p99.9 only from the second on", "[clients]") {
  Histogram histogram;
  for (int i = 0; i < 999; ++i) histogram.add(100);
  histogram.add(200);
  CHECK(histogram.percentile(99.9) == 100);
  CHECK(histogram.percentile(99.95) == 200);
}

TEST_CASE("histogram: merged counts are those of all values together", "[clients]") {
  Histogram a, b, both;
  for (int i = 0; i < 1000; ++i) {
    (i % 3 != 0 ? a : b).add(i * i);
    both.add(i * i);
  }
  a.merge(b);
  CHECK(a.count() == both.count());
  CHECK(a.max() == both.max());
  for (int p = 0; p <= 100; ++p) CHECK(a.percentile(p) == both.percentile(p));
}

TEST_CASE("session plot: a recording of any layout is summed up and drawn", "[clients]") {
  const test::TemporaryFolder folder;
  for (uint32_t layout = 1; layout <= kAbiMajor; ++layout) {
    CAPTURE(layout);
    const std::string name = "tests/proto/log/golden/layout_" + std::to_string(layout) + ".mcap";
    const SessionData data = load_session(test::from_source(name));
    CHECK(data.frames.size() >= 8);
    CHECK(data.proxies.size() >= 3);
    CHECK(data.recorded >= data.frames.size() + data.proxies.size() + data.scenes.size());
    const std::vector<Row> rows = summarize("old", data, SessionConfig{}, Penetration{});
    CHECK(std::any_of(rows.begin(), rows.end(), [&](const Row& row) {
      return row.metric == "ticks" && row.value == static_cast<double>(data.frames.size());
    }));
    const std::string path = folder.path() + "/old.svg";
    plot_session(path, "old", data);
    std::ifstream file(path);
    const std::string svg((std::istreambuf_iterator<char>(file)), {});
    CHECK(line_of(svg).size() == data.frames.size());
  }
}
