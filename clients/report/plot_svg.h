// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <vector>

namespace haptic {

/// One line of a panel; x is time [s], not decreasing. Values that are not finite interrupt the
/// line.
struct Series {
  std::string name;
  std::vector<double> x, y;
};

/// One diagram. Its series are told apart by a legend where there are several.
struct Panel {
  std::string label;
  std::string unit;
  std::vector<Series> series;
};

/// Panels stacked over a shared time axis, as a standalone SVG document of fixed width. Of the
/// samples that fall on one column of pixels the first, lowest, highest and last are drawn: no
/// spike is lost and the size does not grow with the number of samples. Throws std::runtime_error
/// when a series has x and y of different length or there is nothing to draw.
std::string svg_document(const std::string& title, const std::vector<Panel>& panels);

/// The same into a file. Throws std::runtime_error where it cannot be written.
void write_svg(const std::string& path, const std::string& title, const std::vector<Panel>& panels);

}  // namespace haptic
