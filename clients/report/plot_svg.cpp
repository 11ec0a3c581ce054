// SPDX-License-Identifier: GPL-3.0-or-later
#include "clients/report/plot_svg.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <fstream>
#include <limits>
#include <stdexcept>
#include <string_view>

#include "proto/os/text.h"

namespace haptic {
namespace {

// layout [px]
constexpr double kWidth = 1000, kLeft = 76, kRight = 28, kTitleHeight = 56, kFootHeight = 48;
constexpr double kPanelHeight = 150, kPanelHead = 28, kPanelGap = 18;
constexpr double kPlotWidth = kWidth - kLeft - kRight;
constexpr int kTicksX = 10, kTicksY = 4;  // ticks per axis, approximately

// distinguishable with colour blindness (Okabe & Ito 2008), darkened for a white background
constexpr std::array<const char*, 6> kColours{"#0067a5", "#d1550a", "#00876c",
                                              "#b4458b", "#8a6d00", "#4d4d4d"};

std::string escaped(const std::string& text) {
  return replaced(text, {{"&", "&amp;"}, {"<", "&lt;"}, {">", "&gt;"}, {"\"", "&quot;"}});
}

struct Range {
  double low = std::numeric_limits<double>::infinity();
  double high = -std::numeric_limits<double>::infinity();

  void include(double value) {
    if (!std::isfinite(value)) return;
    low = std::min(low, value);
    high = std::max(high, value);
  }
  bool is_empty() const { return low > high; }
};

/// 1, 2 or 5 times a power of ten, such that about `count` steps span the range.
double tick_step(const Range& range, int count) {
  const double rough = (range.high - range.low) / count;
  const double power = std::pow(10, std::floor(std::log10(rough)));
  for (const double factor : {1.0, 2.0, 5.0}) {
    if (factor * power >= rough * (1 - 1e-9)) return factor * power;
  }
  return 10 * power;
}

/// The number with as many decimals as the step needs, and a typographic minus.
std::string tick_text(double value, double step) {
  const double magnitude = std::max(std::fabs(value), step);
  const int decimals = std::max(0, -static_cast<int>(std::floor(std::log10(step) + 1e-9)));
  const bool plain = magnitude < 1e6 && decimals <= 4;
  // a multiple of the step that is zero up to rounding
  const double size = std::fabs(value) < step / 2 ? 0 : std::fabs(value);
  const std::string text = plain ? formatted("%.*f", decimals, size) : formatted("%.4g", size);
  return (value < 0 && size > 0 ? "−" : "") + text;
}

/// A readable range: from zero if the data begin near it, never empty, ending on ticks.
Range axis_range(Range data) {
  if (data.is_empty()) data = {0, 1};
  if (data.low > 0 && data.low < data.high / 2) data.low = 0;
  if (data.high < 0 && data.high > data.low / 2) data.high = 0;
  const double least = std::max(1e-12, 1e-9 * std::max(std::fabs(data.low), std::fabs(data.high)));
  if (data.high - data.low < least) {
    const double margin = data.low == 0 ? 0.5 : std::fabs(data.low) / 10;
    data = {data.low - margin, data.high + margin};
  }
  const double step = tick_step(data, kTicksY);
  return {std::floor(data.low / step + 1e-9) * step, std::ceil(data.high / step - 1e-9) * step};
}

/// Position of a panel and the ranges of its axes.
struct Frame {
  double top;
  Range x, y;

  double px(double value) const { return kLeft + kPlotWidth * (value - x.low) / (x.high - x.low); }
  double py(double value) const {
    return top + kPanelHeight * (1 - (value - y.low) / (y.high - y.low));
  }
};

/// The samples of one pixel column that must be drawn.
class Column {
 public:
  void add(const Series& series, size_t i) {
    if (empty_) first_ = low_ = high_ = i;
    empty_ = false;
    last_ = i;
    if (series.y[i] < series.y[low_]) low_ = i;
    if (series.y[i] > series.y[high_]) high_ = i;
  }
  /// Appends them to the path in order of time.
  void draw(const Frame& frame, const Series& series, std::string& path, bool& pen_down) {
    if (empty_) return;
    std::array<size_t, 4> points{first_, std::min(low_, high_), std::max(low_, high_), last_};
    for (size_t k = 0; k < points.size(); ++k) {
      if (k > 0 && points[k] == points[k - 1]) continue;
      path += formatted("%c%.1f %.1f", pen_down ? 'L' : 'M', frame.px(series.x[points[k]]),
                        frame.py(series.y[points[k]]));
      pen_down = true;
    }
    empty_ = true;
  }

 private:
  bool empty_ = true;
  size_t first_ = 0, low_ = 0, high_ = 0, last_ = 0;
};

std::string line_path(const Frame& frame, const Series& series) {
  std::string path;
  Column column;
  double pixel = -1;
  bool pen_down = false;
  for (size_t i = 0; i < series.x.size(); ++i) {
    const bool drawable = std::isfinite(series.x[i]) && std::isfinite(series.y[i]);
    const double at = drawable ? std::floor(frame.px(series.x[i])) : -1;
    if (at != pixel) column.draw(frame, series, path, pen_down);
    pixel = at;
    if (drawable) column.add(series, i);
    pen_down = pen_down && drawable;
  }
  column.draw(frame, series, path, pen_down);
  return path;
}

std::string text_at(double x, double y, const char* style, const std::string& text) {
  return formatted("<text x=\"%.1f\" y=\"%.1f\" class=\"%s\">", x, y, style) + escaped(text) +
         "</text>\n";
}

std::string grid_line(double x1, double y1, double x2, double y2, const char* style) {
  return formatted("<path class=\"%s\" d=\"M%.1f %.1fL%.1f %.1f\"/>\n", style, x1, y1, x2, y2);
}

struct TickX {
  double at;  // on the axis
  std::string text;
};

std::vector<TickX> even_ticks(const Range& range) {
  std::vector<TickX> out;
  const double step = tick_step(range, kTicksX);
  const auto last = std::llround(std::floor(range.high / step));
  for (auto k = std::llround(std::ceil(range.low / step - 1e-9)); k <= last; ++k) {
    const double value = static_cast<double>(k) * step;
    out.push_back({value, tick_text(value, step)});
  }
  return out;
}

/// 1, 2 and 5 times the powers of ten, on an axis of logarithms.
std::vector<TickX> decade_ticks(const Range& range) {
  std::vector<TickX> out;
  for (double power = std::floor(range.low); power <= range.high; ++power) {
    for (const double factor : {1.0, 2.0, 5.0}) {
      const double at = power + std::log10(factor);
      if (at < range.low - 1e-9 || at > range.high + 1e-9) continue;
      const double value = factor * std::pow(10, power);
      out.push_back({at, formatted("%.6g", value)});
    }
  }
  return out;
}

std::string axes(const Frame& frame, const std::vector<TickX>& ticks, bool with_text) {
  const double bottom = frame.top + kPanelHeight, right = kLeft + kPlotWidth;
  std::string out;
  for (const TickX& tick : ticks) {
    const double x = frame.px(tick.at);
    out += grid_line(x, frame.top, x, bottom, "grid");
    if (with_text) out += text_at(x, bottom + 18, "tick mid", tick.text);
  }
  const double step_y = tick_step(frame.y, kTicksY);
  const auto last_y = std::llround(frame.y.high / step_y);
  for (auto k = std::llround(frame.y.low / step_y); k <= last_y; ++k) {
    const double value = static_cast<double>(k) * step_y, y = frame.py(value);
    out += grid_line(kLeft, y, right, y, k == 0 ? "zero" : "grid");
    out += text_at(kLeft - 8, y + 4, "tick end", tick_text(value, step_y));
  }
  return out + formatted("<path class=\"axis\" d=\"M%.1f %.1fV%.1fH%.1f\"/>\n", kLeft, frame.top,
                         bottom, right);
}

std::string legend(const Panel& panel, double baseline) {
  std::string out =
      formatted("<text x=\"%.1f\" y=\"%.1f\" class=\"tick end\">", kWidth - kRight, baseline);
  for (size_t i = 0; i < panel.series.size(); ++i) {
    // no-break spaces keep the distance; dx would shift the right end
    out += formatted("<tspan fill=\"%s\">\u00a0\u00a0\u00a0━\u00a0</tspan><tspan>",
                     kColours[i % kColours.size()]) +
           escaped(panel.series[i].name) + "</tspan>";
  }
  return out + "</text>\n";
}

std::string ring_at(const Frame& frame, const PlotMark& mark) {
  if (!std::isfinite(mark.x) || !std::isfinite(mark.y)) return "";
  const double x = frame.px(mark.x), y = frame.py(mark.y);
  // the word on the side that has room
  const bool is_right = x > kLeft + kPlotWidth / 2;
  return formatted("<circle class=\"ring\" cx=\"%.1f\" cy=\"%.1f\" r=\"5\"/>\n", x, y) +
         text_at(x + (is_right ? -9 : 9), y - 7, is_right ? "tick end" : "tick", mark.text);
}

std::string panel_body(const Panel& panel, const Frame& frame, const std::vector<TickX>& ticks,
                       bool last) {
  const std::string unit = panel.unit.empty() ? "" : " [" + panel.unit + "]";
  std::string out = text_at(kLeft, frame.top - 10, "label", panel.label + unit);
  if (panel.series.size() > 1) out += legend(panel, frame.top - 10);
  out += axes(frame, ticks, last);
  for (size_t i = 0; i < panel.series.size(); ++i) {
    out += formatted("<path class=\"line\" stroke=\"%s\" d=\"", kColours[i % kColours.size()]) +
           line_path(frame, panel.series[i]) + "\"/>\n";
  }
  for (const PlotMark& mark : panel.marks) out += ring_at(frame, mark);
  return out;
}

Range range_of(const std::vector<Series>& all, std::vector<double> Series::*values) {
  Range range;
  for (const Series& series : all) {
    for (const double value : series.*values) range.include(value);
  }
  return range;
}

Range shared_range(const std::vector<Panel>& panels) {
  Range range;
  for (const Panel& panel : panels) {
    for (const Series& series : panel.series) {
      if (series.x.size() == series.y.size()) continue;
      throw std::runtime_error("plot: series '" + series.name + "' has " +
                               std::to_string(series.x.size()) + " times and " +
                               std::to_string(series.y.size()) + " values; give as many of both");
    }
    const Range own = range_of(panel.series, &Series::x);
    range.include(own.low);
    range.include(own.high);
  }
  if (range.is_empty()) throw std::runtime_error("plot: no samples to draw; record some first");
  if (range.high == range.low) range.high = range.low + 1;
  return range;
}

/// The panels with the decimal logarithms of x in place of x.
std::vector<Panel> with_logarithms(std::vector<Panel> panels) {
  const auto logarithm = [](double x) {
    return x > 0 ? std::log10(x) : std::numeric_limits<double>::quiet_NaN();
  };
  for (Panel& panel : panels) {
    for (Series& series : panel.series) {
      for (double& x : series.x) x = logarithm(x);
    }
    for (PlotMark& mark : panel.marks) mark.x = logarithm(mark.x);
  }
  return panels;
}

constexpr const char* kStyle =
    "<style>text{font-family:'DejaVu Sans',Verdana,sans-serif;fill:#222}"
    ".title{font-size:18px;font-weight:bold}.label{font-size:13px;font-weight:bold}"
    ".tick{font-size:12px;fill:#444}.mid{text-anchor:middle}.end{text-anchor:end}"
    ".grid{stroke:#e4e4e4;fill:none}.zero{stroke:#b0b0b0;fill:none}.axis{stroke:#555;fill:none}"
    ".ring{fill:none;stroke:#222;stroke-width:1.4}"
    ".line{fill:none;stroke-width:1.2;stroke-linejoin:round}</style>\n";

}  // namespace

std::string svg_document(const std::string& title, const std::vector<Panel>& given,
                         const PlotAxis& axis) {
  const std::vector<Panel> panels = axis.is_logarithmic ? with_logarithms(given) : given;
  const Range shared = shared_range(panels);
  const std::vector<TickX> ticks = axis.is_logarithmic ? decade_ticks(shared) : even_ticks(shared);
  const double count = static_cast<double>(panels.size());
  const double height =
      kTitleHeight + count * (kPanelHead + kPanelHeight + kPanelGap) - kPanelGap + kFootHeight;
  std::string out =
      formatted(
          "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 %.0f %.0f\" width=\"%.0f\" "
          "height=\"%.0f\">\n",
          kWidth, height, kWidth, height) +
      kStyle + "<title>" + escaped(title) + "</title>\n" +
      "<rect width=\"100%\" height=\"100%\" fill=\"#fff\"/>\n" + text_at(kLeft, 34, "title", title);
  double top = kTitleHeight + kPanelHead;
  for (size_t i = 0; i < panels.size(); ++i) {
    const Frame frame{top, shared, axis_range(range_of(panels[i].series, &Series::y))};
    out += panel_body(panels[i], frame, ticks, i + 1 == panels.size());
    top += kPanelHead + kPanelHeight + kPanelGap;
  }
  return out + text_at(kLeft + kPlotWidth / 2, height - 10, "tick mid", axis.label) + "</svg>\n";
}

void write_svg(const std::string& path, const std::string& title, const std::vector<Panel>& panels,
               const PlotAxis& axis) {
  const std::string document = svg_document(title, panels, axis);
  std::ofstream file(path, std::ios::binary);
  file << document << std::flush;
  if (!file) {
    throw std::runtime_error(path + ": cannot be written: " + std::strerror(errno) +
                             "; choose a folder that exists and is yours");
  }
}

}  // namespace haptic
