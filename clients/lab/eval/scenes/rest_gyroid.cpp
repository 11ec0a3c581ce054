// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <utility>

#include "clients/lab/eval/scenes/rest_work.h"

namespace haptic {
namespace {

constexpr double kRadius = kRestRadius;  // of the ball that bounds it [m]
constexpr double kPeriod = 0.04;         // of the gyroid [m]
constexpr double kWall = 0.5;            // half its thickness, in units of the field

/// Negative inside; never zero, so that no cut falls on a grid point.
double wall_of_gyroid(const Vec3& p) {
  const Vec3 q = 2 * std::numbers::pi / kPeriod * p;
  const double gyroid =
      std::sin(q.x) * std::cos(q.y) + std::sin(q.y) * std::cos(q.z) + std::sin(q.z) * std::cos(q.x);
  const double field = std::max(std::fabs(gyroid) - kWall, 10 * (norm(p) / kRadius - 1));
  return field != 0 ? field : 1e-9;
}

/// The zero surface of the field by marching tetrahedra. Cuts of edges are shared, so it is closed.
class Marching {
 public:
  explicit Marching(uint32_t n) : n_(n) {}

  Soup surface() {
    for (uint32_t z = 0; z < n_; ++z) {
      for (uint32_t y = 0; y < n_; ++y) {
        for (uint32_t x = 0; x < n_; ++x) add_cube(x, y, z);
      }
    }
    return std::move(soup_);
  }

 private:
  Vec3 at(uint32_t corner) const {
    const uint32_t m = n_ + 1;
    const double cube = 2.2 * kRadius / n_;
    const auto along = [&](uint32_t i) { return cube * i - 1.1 * kRadius; };
    return {along(corner % m), along(corner / m % m), along(corner / m / m)};
  }

  /// Six tetrahedra around the diagonal (Kuhn 1960).
  void add_cube(uint32_t x, uint32_t y, uint32_t z) {
    const uint32_t m = n_ + 1, first = (z * m + y) * m + x;
    const std::array<uint32_t, 3> steps{1, m, m * m};
    constexpr std::array<std::array<size_t, 3>, 6> kOrders{
        {{0, 1, 2}, {0, 2, 1}, {1, 0, 2}, {1, 2, 0}, {2, 0, 1}, {2, 1, 0}}};
    for (const auto& [a, b, c] : kOrders) {
      add_tetrahedron({first, first + steps[a], first + steps[a] + steps[b],
                       first + steps[a] + steps[b] + steps[c]});
    }
  }

  void add_tetrahedron(const std::array<uint32_t, 4>& corners) {
    std::array<uint32_t, 4> in{}, out{};
    size_t n_in = 0, n_out = 0;
    for (const uint32_t c : corners) {
      wall_of_gyroid(at(c)) < 0 ? in[n_in++] = c : out[n_out++] = c;
    }
    if (n_in == 0 || n_out == 0) return;
    const Vec3 outward = at(out[0]) - at(in[0]);
    if (n_in == 2) {
      add({cut(in[0], out[0]), cut(in[0], out[1]), cut(in[1], out[1])}, outward);
      add({cut(in[0], out[0]), cut(in[1], out[1]), cut(in[1], out[0])}, outward);
    } else if (n_in == 1) {
      add({cut(in[0], out[0]), cut(in[0], out[1]), cut(in[0], out[2])}, outward);
    } else {
      add({cut(in[0], out[0]), cut(in[1], out[0]), cut(in[2], out[0])}, outward);
    }
  }

  void add(Triangle t, const Vec3& outward) {
    const std::vector<Vec3>& v = soup_.vertices;
    const Vec3 normal = cross(v[t[1]] - v[t[0]], v[t[2]] - v[t[0]]);
    if (dot(normal, outward) < 0) std::swap(t[1], t[2]);
    soup_.triangles.push_back(t);
  }

  uint32_t cut(uint32_t inside, uint32_t outside) {
    const auto next = static_cast<uint32_t>(soup_.vertices.size());
    const auto [it, is_new] = cuts_.try_emplace(std::minmax(inside, outside), next);
    if (!is_new) return it->second;
    const Vec3 a = at(inside), b = at(outside);
    const double low = wall_of_gyroid(a), high = wall_of_gyroid(b);
    // keeps edges from degenerating
    const double share = std::clamp(low / (low - high), 0.05, 0.95);
    soup_.vertices.push_back(a + share * (b - a));
    return next;
  }

  uint32_t n_;
  Soup soup_;
  std::map<std::pair<uint32_t, uint32_t>, uint32_t> cuts_;
};

}  // namespace

Soup make_gyroid(uint32_t n) {
  return Marching(n).surface();
}

}  // namespace haptic
