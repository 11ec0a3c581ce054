// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/given/given_touch.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <utility>

#include "proto/math/assert.h"
#include "proto/math/units.h"
#include "proto/wire/scene_pose.h"

namespace haptic {
namespace {

constexpr double kMostDistance = 100;          // of a place from its origin [m]
constexpr double kMostForce = 1e6;             // beyond all devices [N, N·m]
constexpr double kSymmetry = 1e-6;             // of K in the metric
constexpr double kRounding = 1e-9;             // by which a B may seem to drive, in the metric
constexpr double kUnitNormal = 1e-3;           // by which a normal's square may differ from one
constexpr double kFade = 0.050;                // between what one gives and its successor [s]
constexpr uint64_t kFeatureBits = ~0ull >> 2;  // of Contact::feature, beside its kind

/// A matrix in the metric: each direction by the root of what is the most of it. A direction that
/// may have none is left out.
Mat6 in_metric(const std::array<double, 36>& matrix, double translational, double rotational) {
  std::array<double, 6> scale;
  for (size_t i = 0; i < 6; ++i) {
    const double most = i < 3 ? translational : rotational;
    scale[i] = most > 0 ? 1 / std::sqrt(most) : 0;
  }
  Mat6 out;
  for (size_t i = 0; i < 6; ++i) {
    for (size_t j = 0; j < 6; ++j) out(i, j) = scale[i] * matrix[6 * i + j] * scale[j];
  }
  return out;
}

/// Largest sum of a row: no eigenvalue of a symmetric matrix is larger.
double largest_row(const Mat6& m) {
  double largest = 0;
  for (size_t i = 0; i < 6; ++i) {
    double sum = 0;
    for (size_t j = 0; j < 6; ++j) sum += std::fabs(m(i, j));
    largest = std::max(largest, sum);
  }
  return largest;
}

bool is_symmetric(const Mat6& m) {
  const double most = kSymmetry * std::max(1.0, largest_row(m));
  for (size_t i = 0; i < 6; ++i) {
    for (size_t j = 0; j < i; ++j) {
      if (!(std::fabs(m(i, j) - m(j, i)) <= most)) return false;
    }
  }
  return true;
}

/// True if V·(B V) is never below zero.
bool brakes(const Mat6& B) {
  using Matrix6 = Eigen::Matrix<double, 6, 6, Eigen::RowMajor>;
  const Eigen::Map<const Matrix6> b(B.a.data());
  const double rounding = kRounding * std::max(1.0, largest_row(B));
  const Matrix6 symmetric = 0.5 * (b + b.transpose()) + rounding * Matrix6::Identity();
  const Eigen::LLT<Matrix6> factors(symmetric);
  // NaN passes Eigen's comparison
  return factors.info() == Eigen::Success && factors.matrixLLT().allFinite();
}

/// The matrix as far as the most in each direction lets it be, and no direction that has none.
void scale_down(std::array<double, 36>& matrix, double by, double translational,
                double rotational) {
  for (size_t i = 0; i < 6; ++i) {
    for (size_t j = 0; j < 6; ++j) {
      const bool moves = translational > 0 || (i >= 3 && j >= 3);
      const bool turns = rotational > 0 || (i < 3 && j < 3);
      matrix[6 * i + j] *= moves && turns ? by : 0;
    }
  }
}

GiverRefusal refusal_of(const ToolWrench& w, const GivenTouchLimits& limits) {
  const bool are_numbers = is_finite(w.X_WT) && is_unit(w.X_WT.q) && is_finite(w.F0_W) &&
                           all_finite(w.K) && all_finite(w.B) && std::isfinite(w.trust_radius);
  if (!are_numbers) return GiverRefusal::kNotFinite;
  const bool is_near = norm(w.X_WT.p) <= kMostDistance && norm(w.F0_W.f) <= kMostForce &&
                       norm(w.F0_W.t) <= kMostForce && w.trust_radius >= 0;
  if (!is_near) return GiverRefusal::kTooFast;
  const Mat6 K = in_metric(w.K, limits.translational_stiffness, limits.rotational_stiffness);
  return is_symmetric(K) ? GiverRefusal::kNone : GiverRefusal::kNotSymmetric;
}

GiverRefusal refusal_of(const GivenPlane& plane, const GivenTouchModel& model, uint32_t n_hands) {
  const bool are_numbers = is_finite(plane.tool_point_T) && is_finite(plane.object_point_O) &&
                           is_finite(plane.normal_O) && std::isfinite(plane.extent) &&
                           std::isfinite(plane.stiffness);
  if (!are_numbers) return GiverRefusal::kNotFinite;
  const bool is_near =
      norm(plane.tool_point_T) <= kMostDistance && norm(plane.object_point_O) <= kMostDistance;
  if (!is_near) return GiverRefusal::kTooFast;
  const bool is_plane = std::fabs(norm_squared(plane.normal_O) - 1) < kUnitNormal &&
                        plane.extent >= 0 && plane.stiffness >= 0 && plane.hand < n_hands &&
                        (plane.object < model.n_objects || plane.object == kNoObject);
  return is_plane ? GiverRefusal::kNone : GiverRefusal::kNoPlane;
}

/// Why a frame cannot be used; the wrenches and planes for other hands are judged where they are
/// used, but for whom they are.
GiverRefusal refusal_of(const GivenTouchModel& model, const ClientConfig& client,
                        const GivenFrame& given) {
  if (!may_give(client, given)) return GiverRefusal::kNotAllowed;
  std::array<bool, kMostHands> is_pushed{};
  for (const GivenWrench& push : given.pushes) {
    if (push.hand >= kMostHands || std::exchange(is_pushed[push.hand], true)) {
      return GiverRefusal::kNoPlane;
    }
    if (push.hand != model.hand) continue;
    const GiverRefusal why = refusal_of(push.wrench, model.limits);
    if (why != GiverRefusal::kNone) return why;
  }
  for (const GivenPlane& plane : given.planes) {
    const GiverRefusal why = refusal_of(plane, model, kMostHands);
    if (why != GiverRefusal::kNone) return why;
  }
  return GiverRefusal::kNone;
}

/// A wrench within the limits. True: it has less than it said.
bool cut(const GivenTouchLimits& limits, ToolWrench& w) {
  const double k_T = limits.translational_stiffness, k_R = limits.rotational_stiffness;
  const double b_T = limits.translational_damping, b_R = limits.rotational_damping;
  const Mat6 K = in_metric(w.K, k_T, k_R), B = in_metric(w.B, b_T, b_R);
  const double stiff = std::max(largest_row(K), 1.0), hard = std::max(largest_row(B), 1.0);
  const bool is_brake = brakes(B);
  scale_down(w.K, 1 / stiff, k_T, k_R);
  scale_down(w.B, is_brake ? 1 / hard : 0, b_T, b_R);
  w.X_WT.q = normalized(w.X_WT.q);
  return stiff > 1 || hard > 1 || !is_brake;
}

/// Takes from a frame of a client what it gives to the hand.
GivenToHand taken(const GivenTouchModel& model, uint32_t client, const GivenFrame& given,
                  uint64_t generation) {
  GivenToHand out;
  out.generation = generation;
  for (const GivenWrench& push : given.pushes) {
    if (push.hand != model.hand) continue;
    out.wrench.emplace(AppliedWrench{push.wrench, 0, moved_by_client(client), 0});
    out.is_cut = cut(model.limits, out.wrench->wrench);
  }
  for (const GivenPlane& plane : given.planes) {
    if (plane.hand != model.hand) continue;
    out.is_cut |= plane.stiffness > model.limits.contact_stiffness;
    GivenPlane kept = plane;
    kept.stiffness = std::min(kept.stiffness, model.limits.contact_stiffness);
    kept.normal_O = kept.normal_O / norm(kept.normal_O);
    out.planes.push_back({kept, dot(kept.normal_O, kept.object_point_O) + norm(kept.tool_point_T)});
  }
  return out;
}

Contact contact_of(const GivenPlane& plane, uint32_t client, double weight) {
  Contact c{};
  c.tool_point_T = plane.tool_point_T;
  c.object_point_O = plane.object_point_O;
  c.normal_O = c.shading_normal_O = plane.normal_O;
  c.extent = plane.extent;
  c.stiffness = plane.stiffness;
  c.reduction = 1 - weight;
  c.object = plane.object;
  c.giver = moved_by_client(client);
  c.feature = plane.feature & kFeatureBits;
  return c;
}

/// The tool and its proxy, seen from an object; kNoObject: from the world.
struct SeenFrom {
  uint32_t object;
  Pose X_OT, X_OP;
};

/// Adds what clients give to a set, as far as it has room and the tool comes.
struct Adding {
  const ServoFrame& servo;
  const TouchedFrom& from;
  ContactSet& set;
  SeenFrom seen{kNoObject, servo.X_WT, servo.X_WP};
  // each the planes of a client on an object: the servo has room for as many
  UpTo<std::pair<uint32_t, uint32_t>, kMostSurfaces> surfaces = {};

  void look_from(uint32_t object) {
    if (object == seen.object) return;
    const Pose X_OW = object < set.objects.size() ? inverse(set.objects[object].X_WO) : Pose{};
    seen = {object, X_OW * servo.X_WT, X_OW * servo.X_WP};
  }

  /// True if the tool, or its proxy, may come to a plane.
  bool is_reached(const KeptPlane& kept) {
    const GivenPlane& plane = kept.plane;
    look_from(plane.object);
    const auto offset = [&](const Vec3& p_O) { return dot(plane.normal_O, p_O); };
    // the origins are off most planes by more than the tool is long
    if (std::min(offset(seen.X_OT.p), offset(seen.X_OP.p)) > kept.nearest + from.reach)
      return false;
    const Vec3& point_T = plane.tool_point_T;
    return std::min(offset(seen.X_OT * point_T), offset(seen.X_OP * point_T)) <=
           offset(plane.object_point_O) + from.reach;
  }

  void add(const KeptPlane& kept, uint32_t client, double weight) {
    const GivenPlane& plane = kept.plane;
    const bool is_held = plane.object != kNoObject && plane.object == from.held_object;
    // as of its own surfaces, contact passes on those that the tool may reach before the next sets
    if (is_held || !is_reached(kept)) return;
    const std::pair surface{client, plane.object};
    const bool is_new = std::ranges::find(surfaces, surface) == surfaces.end();
    if (set.contacts.full() || (is_new && surfaces.size() == kMostSurfaces)) {
      set.flags |= kContactTruncated;
      return;
    }
    if (is_new) surfaces.push_back(surface);
    set.contacts.push_back(contact_of(plane, client, weight));
    set.flags |= kContactGiven;
  }

  void add(uint32_t client, GivenTouchState::Client& known) {
    if (!(known.weight > 0)) return;
    if (known.given.wrench) {
      known.given.wrench->weight = known.weight;
      set.wrenches.push_back(*known.given.wrench);
      set.flags |= kContactGiven;
    }
    for (const KeptPlane& plane : known.given.planes) add(plane, client, known.weight);
  }
};

/// Reads what the hand has felt of the clients until this frame of the servo.
void see_felt(const GivenTouchModel& model, GivenTouchState& state, const ServoFrame& servo) {
  const bool is_anew = servo.impulses_since_ns != state.servo_since_ns;
  state.servo_since_ns = servo.impulses_since_ns;
  for (size_t k = 0; k < model.clients.size(); ++k) {
    GivenTouchState::Client& known = state.clients[k];
    known.is_short = false;
    const auto felt = std::ranges::find(servo.felt, model.clients[k].client, &FeltClient::client);
    if (felt == servo.felt.end() || !std::isfinite(felt->energy)) continue;
    if (is_anew) known.energy = felt->energy;
    known.power.add(felt->energy - known.energy, servo.t_ns);
    known.energy = felt->energy;
    known.is_short = felt->share < 0.5;
  }
}

}  // namespace

GivenTouchModel build_given_touch(const SessionConfig& config) {
  GivenTouchModel model;
  model.hand = config.hand;
  model.n_objects = config.n_objects - config.n_tools;
  for (uint32_t c = 0; c < config.n_clients; ++c) {
    const ClientConfig& client = config.clients[c];
    if ((client.may & (kMayPush | kMayTouch)) != 0) model.clients.push_back({c, client});
  }
  const DeviceMap& map = config.map;
  GivenTouchLimits& limits = model.limits;
  limits.translational_stiffness = config.coupling.translational_stiffness;
  limits.rotational_stiffness = config.coupling.rotational_stiffness;
  limits.translational_damping = config.device.max_damping / (map.motion_scale * map.force_scale);
  limits.rotational_damping = config.device.max_rotational_damping / map.force_scale;
  limits.contact_stiffness = config.proxy.contact_stiffness;
  return model;
}

GivenTouchState begin_given_touch(const GivenTouchModel& model) {
  GivenTouchState state;
  state.clients.resize(model.clients.size());
  return state;
}

void see_client(const GivenTouchModel& model, GivenTouchState& state, size_t k, uint64_t generation,
                const GivenFrame& given, int64_t t_ns) {
  HAPTIC_ASSERT(k < state.clients.size());
  GivenTouchState::Client& known = state.clients[k];
  if (!known.heard.look_at(generation, given, t_ns)) return;
  GiverRefusal why = known.heard.wrong_time(given, t_ns);
  if (why == GiverRefusal::kNone) why = refusal_of(model, model.clients[k].config, given);
  known.heard.conclude(given, why, t_ns);
  if (why != GiverRefusal::kNone) return;
  if (known.weight > 0 && known.given.generation != generation) return;
  known.given = taken(model, model.clients[k].client, given, generation);
}

void weigh_given(const GivenTouchModel& model, GivenTouchState& state, int64_t t_ns) {
  HAPTIC_ASSERT(state.clients.size() == model.clients.size());
  constexpr double kLeastStep = 1e-6, kMostStep = 0.01;  // [s]
  const double dt = std::clamp(seconds_of(t_ns - state.weighed_ns), kLeastStep, kMostStep);
  state.weighed_ns = t_ns;
  for (GivenTouchState::Client& known : state.clients) {
    const double weight = known.heard.weigh(t_ns, dt);
    const bool is_of_now = known.given.generation == known.heard.generation();
    known.weight =
        std::clamp(is_of_now ? weight : 0, known.weight - dt / kFade, known.weight + dt / kFade);
  }
}

void add_given(const GivenTouchModel& model, GivenTouchState& state, const ServoFrame& servo,
               const TouchedFrom& from, ContactSet& set) {
  if (model.clients.empty()) return;
  weigh_given(model, state, servo.t_ns);
  see_felt(model, state, servo);
  const bool is_rendered = (set.flags & kContactNoFreePose) == 0;
  Adding adding{servo, from, set};
  for (size_t k = 0; k < model.clients.size(); ++k) {
    GivenTouchState::Client& known = state.clients[k];
    if (is_rendered) adding.add(model.clients[k].client, known);
    GiverState out = known.heard.report(model.clients[k].client, servo.t_ns);
    out.given_power = known.power.energy(servo.t_ns);
    if (known.is_short) out.flags |= kGiverCut;
    if (known.given.is_cut) out.flags |= kGiverLimited;
    set.givers.push_back(out);
  }
}

}  // namespace haptic
