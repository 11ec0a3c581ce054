// SPDX-License-Identifier: GPL-3.0-or-later
#include "clients/lab/eval/scenes/workload.h"

#include <array>
#include <charconv>
#include <stdexcept>

#include "clients/lab/support/soups.h"
#include "proto/math/units.h"

namespace haptic {
namespace {

constexpr double kFieldHalf = 0.1;       // [m]
constexpr double kWorkloadRadius = 0.1;  // [m]
constexpr uint32_t kFinest = 1500;       // 4.5 or 45 million triangles

struct FieldWave {
  double amplitude, kx, ky, phase;  // [m], [rad/m], [rad]
};
constexpr std::array<FieldWave, 6> kField{{{3.0e-3, 40, 25, 0.3},
                                           {1.5e-3, -70, 90, 1.1},
                                           {0.8e-3, 180, 150, 2.2},
                                           {0.5e-3, -310, 260, 0.7},
                                           {0.25e-3, 620, 540, 1.9},
                                           {0.15e-3, 900, -1100, 2.7}}};

struct SphereWave {
  double share;  // relative to the radius
  Vec3 k;
  double phase;
};
constexpr std::array<SphereWave, 5> kSphere{{{0.04, {4, 3, -2}, 0.4},
                                             {0.02, {-9, 7, 5}, 1.3},
                                             {0.008, {17, -14, 21}, 2.1},
                                             {0.004, {41, 37, -29}, 0.2},
                                             {0.0015, {97, -83, 71}, 1.7}}};

/// The number after the colon of "hf:742"; 0 if there is none or it is out of range.
uint32_t fineness(const std::string& name, const std::string& family) {
  if (name.rfind(family + ":", 0) != 0) return 0;
  uint32_t n = 0;
  const char* const end = name.data() + name.size();
  const auto [rest, error] = std::from_chars(name.data() + family.size() + 1, end, n);
  return error == std::errc{} && rest == end && n <= kFinest ? n : 0;
}

}  // namespace

double field_height(double x, double y) {
  double z = 0;
  for (const FieldWave& w : kField) z += w.amplitude * std::sin(w.kx * x + w.ky * y + w.phase);
  return z;
}

double bumpy_radius(const Vec3& u) {
  double sum = 1;
  for (const SphereWave& w : kSphere) sum += w.share * std::sin(dot(w.k, u) + w.phase);
  return kWorkloadRadius * sum;
}

Soup make_height_field(uint32_t n) {
  return mapped(make_grid(kFieldHalf, n), [](const Vec3& v) {
    return Vec3{v.x, v.y, field_height(v.x, v.y)};
  });
}

Soup make_bumpy_sphere(uint32_t f) {
  return mapped(make_geodesic(f), [](const Vec3& u) { return bumpy_radius(u) * u; });
}

Vec3 field_slide(double t, double tool_radius) {
  const Vec3 flat = flat_slide(t);
  return {flat.x, flat.y, field_height(flat.x, flat.y) + tool_radius + flat.z};
}

Vec3 sphere_direction(double t) {
  const double polar = 0.5 * kPi + 1.1 * std::sin(2 * kPi * 0.11 * t);
  const double azimuth = 2 * kPi * 0.19 * t;
  return {std::sin(polar) * std::cos(azimuth), std::sin(polar) * std::sin(azimuth),
          std::cos(polar)};
}

Vec3 sphere_slide(double t, double tool_radius) {
  const Vec3 u = sphere_direction(t);
  return (bumpy_radius(u) + tool_radius - workload_depth(t)) * u;
}

bool is_eval_work(const std::string& name) {
  return fineness(name, "hf") > 0 || fineness(name, "sphere") > 0 || fineness(name, "flat") > 0;
}

std::string eval_work_names() {
  return "hf:N, sphere:N or flat:N with N from 1 to " + std::to_string(kFinest);
}

EvalWork make_eval_work(const std::string& name, double tool_radius) {
  if (const uint32_t n = fineness(name, "hf"); n > 0) {
    return {name, make_height_field(n), [=](double t) { return field_slide(t, tool_radius); }};
  }
  if (const uint32_t f = fineness(name, "sphere"); f > 0) {
    return {name, make_bumpy_sphere(f), [=](double t) { return sphere_slide(t, tool_radius); }};
  }
  if (const uint32_t n = fineness(name, "flat"); n > 0) {
    return {name, make_grid(kFieldHalf, n), [=](double t) {
              return flat_slide(t) + Vec3{0, 0, tool_radius};
            }};
  }
  throw std::runtime_error(name + ": no such mesh; give " + eval_work_names() + ", or a file");
}

}  // namespace haptic
