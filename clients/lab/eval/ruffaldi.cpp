// SPDX-License-Identifier: GPL-3.0-or-later
#include "clients/lab/eval/ruffaldi.h"

#include <algorithm>
#include <random>

#include "clients/lab/eval/mesh/renderer.h"
#include "clients/lab/support/measurement.h"
#include "clients/lab/support/offline_session.h"
#include "clients/lab/support/scripted_hand.h"
#include "clients/lab/support/soups.h"
#include "contact/bake/bake.h"
#include "contact/query/point/closest_point.h"
#include "proto/math/units.h"

namespace haptic {
namespace {

constexpr double kDeeper = 3;     // times the workload's depth: 1.8 to 4.2 mm, 0.9 to 2.1 N
constexpr double kShare = 0.005;  // goal: rms error relative to the mean force
constexpr int kLongestLag = 20;   // ticks

struct SurfacePoint {
  Vec3 p, normal;
};

SurfacePoint on_torus(double u, double v) {
  constexpr double kRing = 0.06, kTube = 0.02;
  const Vec3 out{std::cos(u), std::sin(u), 0};
  const Vec3 normal = std::cos(v) * out + Vec3{0, 0, std::sin(v)};
  return {kRing * out + kTube * normal, normal};
}

SurfacePoint on_bumps(double x, double y) {
  struct Wave {
    double amplitude, kx, ky;
  };
  constexpr std::array<Wave, 2> kWaves{{{2e-3, 60, 20}, {1e-3, -80, 70}}};
  double z = 0, slope_x = 0, slope_y = 0;
  for (const Wave& w : kWaves) {
    const double phase = w.kx * x + w.ky * y;
    z += w.amplitude * std::sin(phase);
    slope_x += w.amplitude * w.kx * std::cos(phase);
    slope_y += w.amplitude * w.ky * std::cos(phase);
  }
  return {{x, y, z}, normalized(Vec3{-slope_x, -slope_y, 1})};
}

/// A torus of n × m quads of two triangles.
Soup make_torus(uint32_t n, uint32_t m) {
  return make_closed_grid(
      n, m, [&](uint32_t i, uint32_t j) { return on_torus(2 * kPi * i / n, 2 * kPi * j / m).p; });
}

double longest_edge(const Soup& soup) {
  double longest = 0;
  for (const Triangle& t : soup.triangles) {
    for (size_t i = 0; i < 3; ++i) {
      longest = std::max(longest, norm(soup.vertices[t[i]] - soup.vertices[t[(i + 1) % 3]]));
    }
  }
  return longest;
}

/// Leads the probe over a surface, pressing along the normal.
void lead(RuffaldiWork& work, size_t ticks, const std::function<SurfacePoint(double)>& way) {
  for (size_t k = 0; k < ticks; ++k) {
    const double t = kTick * static_cast<double>(k);
    const SurfacePoint s = way(t);
    const double depth = kDeeper * workload_depth(t);
    const Vec3 force = kRuffaldiStiffness * std::max(depth, 0.0) * s.normal;
    work.probe.push_back({t, s.p, force});
    work.in_trajectory.push_back(s.p - depth * s.normal);
  }
}

constexpr double kBallRadius = 0.05;  // [m]

Soup make_bumps() {
  return mapped(make_grid(0.1, 400), [](const Vec3& v) { return on_bumps(v.x, v.y).p; });
}

/// A surface: its mesh, its largest curvature [1/m], and where the probe is on it at t [s].
struct Surface {
  std::string_view name;
  Soup (*make)();
  double curvature;
  SurfacePoint (*way)(double t);
};
constexpr std::array kSurfaces{
    Surface{"plane", [] { return make_grid(0.1, 50); }, 0,
            [](double t) {
              const Vec3 p = flat_slide(t);
              return SurfacePoint{{p.x, p.y, 0}, {0, 0, 1}};
            }},
    Surface{"sphere", [] { return make_icosphere(kBallRadius, 7); }, 1 / kBallRadius,
            [](double t) {
              return SurfacePoint{kBallRadius * sphere_direction(t), sphere_direction(t)};
            }},
    Surface{"torus", [] { return make_torus(900, 300); }, 1 / 0.02,
            [](double t) { return on_torus(2 * kPi * 0.11 * t, 2 * kPi * 0.31 * t); }},
    Surface{"bumpy", make_bumps, 2e-3 * (60 * 60 + 20 * 20) + 1e-3 * (80 * 80 + 70 * 70),
            [](double t) {
              const Vec3 p = flat_slide(t);
              return on_bumps(p.x, p.y);
            }}};

/// Root of the mean of error(k) over the samples in contact.
template <typename Error>
double rms_of(const std::vector<TrajSample>& probe, Error error) {
  double sum = 0;
  size_t n = 0;
  for (size_t k = 0; k < probe.size(); ++k) {
    if (probe[k].force_O == Vec3{}) continue;
    sum += error(k);
    ++n;
  }
  return n > 0 ? std::sqrt(sum / static_cast<double>(n)) : 0;
}

}  // namespace

RuffaldiWork make_ruffaldi_work(const std::string& surface, size_t ticks) {
  const auto kind = std::ranges::find(kSurfaces, surface, &Surface::name);
  if (kind == kSurfaces.end()) {
    throw std::runtime_error("--surface " + surface +
                             ": unknown; give plane, sphere, torus or bumpy");
  }
  RuffaldiWork work{kind->make(), {}, {}, 0};
  lead(work, ticks, kind->way);
  const double h = longest_edge(work.soup);
  work.facet_error = kRuffaldiStiffness * h * h * kind->curvature / 8;
  return work;
}

std::vector<Vec3> in_trajectory_of(const std::vector<TrajSample>& probe, const MeshShape& shape) {
  std::vector<Vec3> inside;
  for (const TrajSample& s : probe) {
    const ClosestPoint c = closest_point(shape, s.p_O, std::numeric_limits<double>::infinity());
    const Vec3 normal = c.found ? shape.mesh.face_normals[c.triangle] : Vec3{};
    const double force = dot(s.force_O, normal);
    inside.push_back(force > 0 ? c.point_O - (force / kRuffaldiStiffness) * normal : s.p_O);
  }
  return inside;
}

void add_noise(std::vector<Vec3>& positions, double sigma) {
  std::mt19937_64 engine(1);
  std::normal_distribution<double> error(0, 1);
  for (Vec3& p : positions) {
    const double x = error(engine), y = error(engine), z = error(engine);
    p += sigma * Vec3{x, y, z};
  }
}

ForceComparison compare_forces(const std::vector<TrajSample>& probe,
                               const std::vector<Vec3>& rendered) {
  ForceComparison out;
  const auto error = [&](size_t k, int lag) {
    const size_t late = std::min(k + static_cast<size_t>(lag), rendered.size() - 1);
    return rendered[late] - probe[k].force_O;
  };
  for (size_t k = 0; k < probe.size(); ++k) {
    if (probe[k].force_O == Vec3{}) continue;
    ++out.samples;
    out.mean_force += norm(probe[k].force_O);
    out.max = std::max(out.max, norm(error(k, 0)));
    if (k == 0 || rendered[k] == Vec3{} || rendered[k - 1] == Vec3{}) continue;
    const Vec3 across = cross(rendered[k], rendered[k - 1]);
    out.direction_jump =
        std::max(out.direction_jump, std::atan2(norm(across), dot(rendered[k], rendered[k - 1])));
  }
  if (out.samples > 0) out.mean_force /= static_cast<double>(out.samples);
  const auto along = [&](size_t k) { return dot(error(k, 0), normalized(probe[k].force_O)); };
  out.rms = rms_of(probe, [&](size_t k) { return norm_squared(error(k, 0)); });
  out.rms_normal = rms_of(probe, [&](size_t k) { return along(k) * along(k); });
  out.rms_tangential =
      std::sqrt(std::max(0.0, out.rms * out.rms - out.rms_normal * out.rms_normal));
  out.rms_aligned = out.rms;
  for (int lag = 1; lag <= kLongestLag; ++lag) {
    const double rms = rms_of(probe, [&](size_t k) { return norm_squared(error(k, lag)); });
    if (rms < out.rms_aligned) out.rms_aligned = rms, out.lag = lag;
  }
  return out;
}

std::vector<Vec3> render_trajectory(const MeshShape& shape, const std::vector<Vec3>& trajectory,
                                    const LockstepOptions& options) {
  ScriptedHand hand(path_through(trajectory));
  Lockstep lockstep(plain_session(kRuffaldiStiffness), std::span(&shape, 1), hand, options);
  std::vector<Vec3> forces;
  while (forces.size() < trajectory.size() && lockstep.step()) {
    forces.push_back(lockstep.frame().F_coupling_W.f);
  }
  return forces;
}

void eval_ruffaldi(const RuffaldiEval& eval, const Rows& all) {
  const bool scanned = !eval.traj.empty();
  RuffaldiWork work;
  BakedShape baked;
  MeshShapeData made;
  MeshShape shape;
  if (scanned) {
    work.probe = at_one_kilohertz(read_traj(eval.traj));
    baked = bake_scan(eval.mesh, eval.size);
    shape = baked.shape;
    work.in_trajectory = in_trajectory_of(work.probe, shape);
  } else {
    work = make_ruffaldi_work(eval.surface, eval.ticks);
    made = build_shape(std::move(work.soup));
    shape = made.view();
    add_noise(work.in_trajectory, eval.noise);
  }
  const std::vector<Vec3> forces = render_trajectory(shape, work.in_trajectory, eval.lockstep);
  const ForceComparison c = compare_forces(work.probe, forces);

  Rows rows = all.machine("ruffaldi on " + (scanned ? eval.traj : eval.surface));
  rows.add("triangles", shape.mesh.triangles.size());
  if (!scanned) rows.add("noise of the tracker", eval.noise, "m");
  rows.add({{"samples in contact", c.samples}, {"mean force", c.mean_force, "N"}});
  // only surfaces that a mesh represents (almost) exactly have a goal
  const bool judged = !scanned && (eval.surface == "plane" || eval.surface == "sphere");
  const double share = c.mean_force > 0 ? c.rms / c.mean_force : 0;
  rows.add({{"force error, rms, of the mean", share, "", at_most(goal_if(judged, kShare))},
            {"force error, rms", c.rms, "N"},
            {"force error, rms, normal", c.rms_normal, "N"},
            {"force error, rms, tangential", c.rms_tangential, "N"},
            {"force error, max", c.max, "N"},
            {"lag", c.lag, "ticks"},
            {"force error, rms, lag taken out", c.rms_aligned, "N"},
            {"direction jump in a tick, max", c.direction_jump, "rad"}});
  if (!scanned) rows.add("bound of the mesh's error, h²κ/8·k", work.facet_error, "N");
}

Measured suite_ruffaldi(Command& command) {
  const auto eval = std::make_shared<RuffaldiEval>();
  command.option("--surface", eval->surface, "plane, sphere, torus or bumpy")
      .one_of({"plane", "sphere", "torus", "bumpy"})
      .show_default();
  command
      .quantity("--noise", eval->noise, Dimension::kLength, {0, 1e-3},
                "of the tracker, σ; a number without unit is in metres", "m")
      .show_default();
  command.option("--mesh FILE", eval->mesh, "what was scanned");
  command.option("--traj FILE", eval->traj, "a scan of this mesh instead of a surface")
      .needs("--mesh");
  add_scan_size(command, eval->size);
  add_lockstep(command, eval->lockstep);
  return measured(eval_ruffaldi, eval);
}

}  // namespace haptic
