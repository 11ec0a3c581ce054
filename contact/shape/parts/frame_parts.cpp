// SPDX-License-Identifier: GPL-3.0-or-later
#include <array>
#include <cmath>
#include <functional>
#include <map>
#include <vector>

#include "contact/shape/mesh/primitives.h"
#include "proto/math/assert.h"
#include "proto/math/units.h"

namespace haptic {
namespace {

/// Number of a cell, or of a vertex of the grid, along x, y and z.
using Cell = std::array<size_t, 3>;

/// A body of boxes: the lines of a grid along each axis [m], ascending, and which cells are solid.
/// No two solid cells may meet in an edge alone.
struct BoxBody {
  std::array<std::vector<double>, 3> lines;
  std::function<bool(const Vec3& middle)> is_solid;

  double line(size_t axis, size_t i) const { return lines[axis][i]; }
  Vec3 middle(const Cell& cell) const {
    Vec3 p;
    for (size_t axis = 0; axis < 3; ++axis) {
      p[static_cast<int>(axis)] = 0.5 * (line(axis, cell[axis]) + line(axis, cell[axis] + 1));
    }
    return p;
  }
  bool has(const Cell& cell) const {
    for (size_t axis = 0; axis < 3; ++axis) {
      // below zero wraps around, and is beyond the end as well
      if (cell[axis] >= lines[axis].size() - 1) return false;
    }
    return is_solid(middle(cell));
  }
};

/// A level curve in a cell, counter-clockwise from above. Each quarter faces one corner of the
/// cell, the first that at +x +y; it begins where the one before ends, but beyond the straight part
/// of a slot.
struct Outline {
  std::vector<uint32_t> points;
  std::array<std::vector<uint32_t>, 4> quarters;
};

/// Makes the triangles of a body of boxes with round holes and pins.
struct BoxMesh {
  const BoxBody& body;
  Soup soup{};
  std::map<Cell, uint32_t> known{};

  uint32_t corner(const Cell& at) {
    const auto [entry, is_new] = known.try_emplace(at, static_cast<uint32_t>(soup.vertices.size()));
    if (is_new) {
      soup.vertices.push_back({body.line(0, at[0]), body.line(1, at[1]), body.line(2, at[2])});
    }
    return entry->second;
  }
  void add(uint32_t a, uint32_t b, uint32_t c, bool is_turned) {
    soup.triangles.push_back(is_turned ? Triangle{a, c, b} : Triangle{a, b, c});
  }
};

/// Corners of a face of a cell, counter-clockwise about the axis that it lies across.
std::array<uint32_t, 4> face(BoxMesh& mesh, const Cell& cell, size_t axis, bool is_upper) {
  const size_t u = (axis + 1) % 3, v = (axis + 2) % 3;
  Cell at = cell;
  at[axis] += is_upper;
  Cell along = at, across = at, both = at;
  ++along[u], ++across[v], ++both[u], ++both[v];
  return {mesh.corner(both), mesh.corner(across), mesh.corner(at), mesh.corner(along)};
}

/// All faces between solid and empty but those of which `is_left_out` says so.
void add_faces(BoxMesh& mesh,
               const std::function<bool(const Cell&, size_t axis, bool is_upper)>& is_left_out) {
  const auto& lines = mesh.body.lines;
  const auto add_cell = [&](const Cell& cell) {
    if (!mesh.body.has(cell)) return;
    for (size_t axis = 0; axis < 3; ++axis) {
      for (const bool is_upper : {false, true}) {
        Cell beside = cell;
        is_upper ? ++beside[axis] : --beside[axis];
        if (mesh.body.has(beside) || is_left_out(cell, axis, is_upper)) continue;
        const auto [a, b, c, d] = face(mesh, cell, axis, is_upper);
        mesh.add(a, b, c, !is_upper);
        mesh.add(a, c, d, !is_upper);
      }
    }
  };
  for (size_t i = 0; i + 1 < lines[0].size(); ++i) {
    for (size_t j = 0; j + 1 < lines[1].size(); ++j) {
      for (size_t k = 0; k + 1 < lines[2].size(); ++k) add_cell({i, j, k});
    }
  }
}

/// A circle about `centre`, drawn out by `slot` [m] to either side along x.
Outline add_outline(Soup& soup, const Vec3& centre, double radius, double slot, uint32_t around) {
  HAPTIC_ASSERT(radius > 0 && around >= 4 && around % 4 == 0);
  Outline outline;
  for (size_t quarter = 0; quarter < 4; ++quarter) {
    const double aside = quarter == 0 || quarter == 3 ? slot : -slot;
    std::vector<uint32_t>& own = outline.quarters[quarter];
    if (quarter == 2 || (quarter != 0 && slot == 0)) {
      own.push_back(outline.quarters[quarter - 1].back());
    }
    for (uint32_t i = own.empty() ? 0 : 1; i <= around / 4; ++i) {
      if (quarter == 3 && i == around / 4) break;
      const double angle = 0.5 * kPi * static_cast<double>(quarter) + 2 * kPi * i / around;
      own.push_back(static_cast<uint32_t>(soup.vertices.size()));
      outline.points.push_back(own.back());
      soup.vertices.push_back(centre +
                              Vec3{aside + radius * std::cos(angle), radius * std::sin(angle), 0});
    }
  }
  outline.quarters[3].push_back(outline.points.front());
  return outline;
}

/// The face of a cell across z around an outline in it.
void add_around(BoxMesh& mesh, const Cell& cell, bool is_upper, const Outline& outline) {
  const auto corners = face(mesh, cell, 2, is_upper);
  for (size_t quarter = 0; quarter < 4; ++quarter) {
    const std::vector<uint32_t>& own = outline.quarters[quarter];
    for (size_t i = 0; i + 1 < own.size(); ++i) {
      mesh.add(corners[quarter], own[i + 1], own[i], !is_upper);
    }
    const size_t next = (quarter + 1) % 4;
    const uint32_t end = own.back(), begin = outline.quarters[next].front();
    mesh.add(corners[quarter], corners[next], end, !is_upper);
    if (begin != end) mesh.add(end, corners[next], begin, !is_upper);
  }
}

/// The side between two outlines of equal number, the second above the first.
void add_side(BoxMesh& mesh, const Outline& lower, const Outline& upper, bool faces_out) {
  const size_t n = lower.points.size();
  HAPTIC_ASSERT(n == upper.points.size());
  for (size_t i = 0; i < n; ++i) {
    const size_t j = (i + 1) % n;
    mesh.add(lower.points[i], lower.points[j], upper.points[j], !faces_out);
    mesh.add(lower.points[i], upper.points[j], upper.points[i], !faces_out);
  }
}

/// The cell whose middle is nearest to a point.
Cell cell_at(const BoxBody& body, const Vec3& point) {
  Cell cell{};
  for (size_t axis = 0; axis < 3; ++axis) {
    const auto& lines = body.lines[axis];
    const double at = point[static_cast<int>(axis)];
    while (cell[axis] + 2 < lines.size() && lines[cell[axis] + 1] < at) ++cell[axis];
  }
  return cell;
}

/// Thickness of the sheet and height of the tabs [m].
double sheet_of(const primitive::Frame& frame) {
  return frame.width / 8;
}
double tab_of(const primitive::Frame& frame) {
  return 2 * frame.width / 3;
}

/// From the middle of the part to each hole [m].
double pin_distance(const primitive::Frame& frame) {
  return 0.5 * (frame.length - frame.width);
}

/// How far a slot lets its pin go to either side: a quarter of the pin's diameter.
double slot_of(const primitive::Frame& frame) {
  return frame.diameter / 4;
}

BoxBody rail_boxes(const primitive::FrameRail& rail) {
  const double end = 0.5 * rail.length, side = 0.5 * rail.width, sheet = sheet_of(rail);
  const double top = rail.height, tab = tab_of(rail), lug = end - rail.width;
  BoxBody body;
  // the tabs stand over a third of each half
  body.lines = {{{-end, -lug, -lug + sheet, -0.6 * lug, -0.3 * lug, 0.2 * lug, 0.5 * lug,
                  lug - sheet, lug, end},
                 {-side, -side + sheet, side - sheet, side, side + tab},
                 {0, sheet, top - sheet, top, top + tab}}};
  body.is_solid = [=](const Vec3& p) {
    const double x = std::fabs(p.x), y = std::fabs(p.y);
    if (p.z > top) return p.x > -0.6 * lug && p.x < -0.3 * lug && p.y > side - sheet && p.y < side;
    if (p.y > side) return p.x > 0.2 * lug && p.x < 0.5 * lug && p.z < sheet;
    if (x > lug) return p.z < sheet;
    return x > lug - sheet || y > side - sheet || p.z > top - sheet;
  };
  return body;
}

BoxBody rest_boxes(const primitive::PinRest& rest) {
  const double pin = pin_distance(rest), half = 0.375 * rest.width, base = 2 * sheet_of(rest);
  const double post = rest.height, end = pin + rest.width, side = 2 * half;
  BoxBody body;
  body.lines = {{{-end, -pin - half, -pin + half, pin - half, pin + half, end},
                 {-side, -half, half, side},
                 {-post - base, -post, 0}}};
  body.is_solid = [=](const Vec3& p) {
    return p.z < -post || (std::fabs(std::fabs(p.x) - pin) < half && std::fabs(p.y) < half);
  };
  return body;
}

}  // namespace

Soup make_frame_rail(const primitive::FrameRail& rail) {
  const BoxBody body = rail_boxes(rail);
  BoxMesh mesh{body};
  const double pin = pin_distance(rail), sheet = sheet_of(rail);
  const Cell round = cell_at(body, {-pin, 0, 0.5 * sheet});
  const Cell slot = cell_at(body, {pin, 0, 0.5 * sheet});
  add_faces(mesh, [&](const Cell& cell, size_t axis, bool) {
    return axis == 2 && (cell == round || cell == slot);
  });
  const double radius = 0.5 * rail.diameter + rail.clearance;
  for (const Cell& cell : {round, slot}) {
    const double x = cell == slot ? pin : -pin, longer = cell == slot ? slot_of(rail) : 0;
    const Outline lower = add_outline(mesh.soup, {x, 0, 0}, radius, longer, rail.around);
    const Outline upper = add_outline(mesh.soup, {x, 0, sheet}, radius, longer, rail.around);
    add_around(mesh, cell, false, lower);
    add_around(mesh, cell, true, upper);
    add_side(mesh, lower, upper, false);
  }
  return mesh.soup;
}

Soup make_pin_rest(const primitive::PinRest& rest) {
  const BoxBody body = rest_boxes(rest);
  BoxMesh mesh{body};
  const double pin = pin_distance(rest), foot = 0.5 * rest.diameter;
  const double land = 1.5 * sheet_of(rest);
  const auto post_at = [&](double x) { return cell_at(body, {x, 0, -0.5 * rest.height}); };
  const Cell left = post_at(-pin), right = post_at(pin);
  add_faces(mesh, [&](const Cell& cell, size_t axis, bool is_upper) {
    return axis == 2 && is_upper && (cell == left || cell == right);
  });
  for (const double x : {-pin, pin}) {
    const auto ring = [&](double radius, double z) {
      return add_outline(mesh.soup, {x, 0, z}, radius, 0, rest.around);
    };
    const Outline base = ring(foot, 0), shoulder = ring(foot, land);
    const Outline tip = ring(0.5 * foot, land + foot);
    add_around(mesh, x < 0 ? left : right, true, base);
    add_side(mesh, base, shoulder, true);
    add_side(mesh, shoulder, tip, true);
    const auto centre = static_cast<uint32_t>(mesh.soup.vertices.size());
    mesh.soup.vertices.push_back({x, 0, land + foot});
    for (size_t i = 0; i < tip.points.size(); ++i) {
      mesh.add(centre, tip.points[i], tip.points[(i + 1) % tip.points.size()], false);
    }
  }
  return mesh.soup;
}

Soup make_window(const primitive::Window& window) {
  const auto& [extent, width, height] = window;
  HAPTIC_ASSERT(0 < width && width < extent.x && 0 < height && height < extent.y);
  const Vec3 half = 0.5 * extent;
  BoxBody body;
  body.lines = {{{-half.x, -0.5 * width, 0.5 * width, half.x},
                 {-half.y, -0.5 * height, 0.5 * height, half.y},
                 {-half.z, half.z}}};
  body.is_solid = [&](const Vec3& p) {
    return std::fabs(p.x) > 0.5 * width || std::fabs(p.y) > 0.5 * height;
  };
  BoxMesh mesh{body};
  add_faces(mesh, [](const Cell&, size_t, bool) { return false; });
  return mesh.soup;
}

}  // namespace haptic
