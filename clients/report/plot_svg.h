// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <vector>

namespace haptic {

/// One line of a panel; x is non-decreasing, and time [s] where the axis says nothing else.
/// Non-finite values interrupt the line.
struct Series {
  std::string name;
  std::vector<double> x, y;
};

/// A point of a panel that is marked with a ring and a word.
struct PlotMark {
  double x, y;
  std::string text;
};

/// One diagram; a legend names the series if there are several.
struct Panel {
  std::string label;
  std::string unit;
  std::vector<Series> series;
  std::vector<PlotMark> marks{};
};

/// The axis that the panels share.
struct PlotAxis {
  std::string label = "time [s]";
  bool is_logarithmic = false;  // values at most 0 are not drawn
};

/// Panels stacked over a shared axis, as a standalone SVG document of fixed width. In each
/// pixel column only the first, lowest, highest and last sample are drawn: no spike is lost, and
/// the size does not grow with the number of samples. Throws std::runtime_error if the x and y of a
/// series differ in length or there is nothing to draw.
std::string svg_document(const std::string& title, const std::vector<Panel>& panels,
                         const PlotAxis& axis = {});

/// Writes that document to a file. Throws std::runtime_error if it cannot be written.
void write_svg(const std::string& path, const std::string& title, const std::vector<Panel>& panels,
               const PlotAxis& axis = {});

}  // namespace haptic
