// SPDX-License-Identifier: GPL-3.0-or-later
#include "sim/bodies.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

#include "contact/shape/mesh/mass_properties.h"
#include "proto/math/assert.h"
#include "proto/wire/packing.h"
#include "proto/wire/scene_pose.h"
#include "sim/mobility.h"

namespace haptic {
namespace {

// a body that a hand has pushed within this time is looked at together with what it touches [ns]
constexpr int64_t kTouchedNs = 500'000'000;
// most that a hand takes to map the segment of a new sim, which is some 10 ms [ns]
constexpr int64_t kReturnNs = 100'000'000;
constexpr double kLongest = 2.2;  // of the period: a longer step is cut

BodyMass mass_of(const ObjectConfig& object, const TriangleMesh& mesh) {
  if (!has_mass(object.body)) return {};
  const std::string name(view(object.name));
  if (object.body.density > 0 && !mesh.closed) {
    throw std::invalid_argument("the object '" + name +
                                "' has a density, and its mesh is not closed; give its mass");
  }
  const MassProperties solid = solid_properties(mesh);
  BodyMass body;
  body.centre_O = solid.centre_O;
  body.mass = object.body.density > 0 ? object.body.density * solid.volume : object.body.mass;
  const Vec3& moments = object.body.inertia;
  body.inertia_O = {{{moments.x, 0, 0}, {0, moments.y, 0}, {0, 0, moments.z}}};
  if (moments == Vec3{}) body.inertia_O = (body.mass / solid.volume) * solid.inertia_O;
  if (!(body.mass > 0) || !std::isfinite(body.mass) || !(body.inertia_O.row[0].x > 0)) {
    throw std::invalid_argument("the object '" + name +
                                "' is flat and has no volume; give its mass and inertia");
  }
  return body;
}

bool is_cube_like(const Vec3& d) {
  constexpr double kRound = 1e-9;  // relative
  return std::fabs(d.x - d.y) <= kRound * d.x && std::fabs(d.x - d.z) <= kRound * d.x;
}

CollisionShape shape_of(const ObjectConfig& object, const TriangleMesh& mesh) {
  if (is_any_of<primitive::Box>(object.primitive)) return CollisionShape::kBox;
  if (is_any_of<primitive::Sphere>(object.primitive) && is_cube_like(mesh.upper - mesh.lower)) {
    return CollisionShape::kBall;
  }
  return has_mass(object.body) ? CollisionShape::kPieces : CollisionShape::kTriangles;
}

/// The vertices of each piece of the original surface; without pieces those of the mesh.
std::vector<std::span<const Vec3>> pieces_of(const PieceTree& tree, const TriangleMesh& mesh) {
  if (tree.pieces.empty()) return {mesh.vertices};
  std::vector<std::span<const Vec3>> all;
  for (const Piece& piece : tree.pieces) {
    if (piece.n_children == 0) all.push_back(tree.hull(piece).vertices);
  }
  return all;
}

/// Puts the world where the last frame says, and readers have carried it on since.
void restart(const BodiesModel& model, BodiesState& state, const HandFrames& hands,
             SceneFrame& frame) {
  const SceneFrame& last = state.last;
  for (const uint32_t i : model.with_mass) {
    SceneObject& object = frame.objects[i];
    // each hand has seen it where its own pushes had brought it
    UnseenPush unseen;
    for (uint32_t hand = 0; hand < hands.size(); ++hand) {
      if (hands[hand] == nullptr) continue;
      const UnseenPush of_hand = unseen_push(last, i, frame.t_ns, push_of(*hands[hand], hand));
      unseen.impulse_time_W = unseen.impulse_time_W + of_hand.impulse_time_W;
    }
    object.X_WO = object_pose_at(last, i, frame.t_ns, unseen);
    object.V_WO = last.objects[i].V_WO;
    state.world->place(i, object.X_WO, object.V_WO);
    if (const ObjectResponse* response = response_of(last, i)) {
      frame.responses[object.response] = *response;
    }
  }
  for (uint32_t j = 0; j < std::min(frame.joints.size(), last.joints.size()); ++j) {
    state.world->resume_joint(j, last.joints[j].position);
  }
  for (uint32_t hand = 0; hand < hands.size(); ++hand) {
    state.seen[hand] = {};
    if (hands[hand] != nullptr) forget_pushes(state.seen[hand], *hands[hand], last, hand);
  }
}

/// Returns true while some servo has not used a frame of sim since sim was away. Until then the
/// servo counts no pushes, so a body that the hand holds would fall. The wait ends after kReturnNs,
/// and a servo whose last frame is older than that is not waited for.
bool is_awaited(const BodiesState& state, const HandFrames& hands, int64_t t_ns) {
  if (t_ns - state.returned_ns > kReturnNs) return false;
  return std::ranges::any_of(hands, [&](const ServoFrame* hand) {
    return hand != nullptr && t_ns - hand->t_ns <= kReturnNs &&
           hand->scene_seq < state.returned_seq;
  });
}

/// Leaves all bodies where they were, with the twist that they go on with.
void stand_still(const BodiesModel& model, const SceneFrame& last, SceneFrame& frame) {
  for (const uint32_t i : model.with_mass) {
    frame.objects[i].X_WO = last.objects[i].X_WO;
    frame.objects[i].V_WO = last.objects[i].V_WO;
  }
  frame.responses.assign({last.responses.data(), last.responses.size()});
}

/// The same, until the hands know; what they push meanwhile is forgotten.
void await_hands(const BodiesModel& model, BodiesState& state, const HandFrames& hands,
                 SceneFrame& frame) {
  stand_still(model, state.last, frame);
  for (uint32_t hand = 0; hand < hands.size(); ++hand) {
    if (hands[hand] != nullptr) forget_pushes(state.seen[hand], *hands[hand], state.last, hand);
  }
}

/// Gives the bodies what the hands have pushed; returns what their places lack of it.
NewPushes give_pushes(const BodiesModel& model, BodiesState& state, const HandFrames& hands,
                      int64_t t_ns, double dt) {
  NewPushes all{};
  const size_t n = model.with_mass.size();
  for (uint32_t hand = 0; hand < hands.size(); ++hand) {
    if (hands[hand] == nullptr) continue;
    const NewPushes pushes = take_pushes(state.seen[hand], *hands[hand], state.last.t_ns);
    for (size_t k = 0; k < n; ++k) {
      all[k].impulse_W = all[k].impulse_W + pushes[k].impulse_W;
      all[k].late_W = all[k].late_W + pushes[k].late_W;
    }
  }
  for (size_t k = 0; k < n; ++k) {
    if (all[k].impulse_W == Wrench{}) continue;
    state.world->push(model.with_mass[k], all[k].impulse_W, 1 / dt * all[k].late_W);
    state.touched_ns[k] = t_ns;
  }
  return all;
}

/// Steps of equal length to the frame's instant; scripted objects go along.
double step_world(const BodiesModel& model, BodyWorld& world, double dt, const SceneFrame& frame) {
  const int n = steps_between(dt, model.period);
  for (int k = 1; k <= n; ++k) {
    for (uint32_t i = 0; i < frame.objects.size(); ++i) {
      if (model.world.objects[i].mass.mass > 0) continue;
      const SceneObject& object = frame.objects[i];
      const double until_end = (k - n) * (dt / n);
      world.place(i, extrapolate(object.X_WO, object.V_WO, until_end), object.V_WO);
    }
    world.step(dt / n);
  }
  return dt / n;
}

/// Acceleration of the origin by gravity, joints and the body's own turning, as far as contacts and
/// joints let it.
Twist acceleration_of(const BodiesModel& model, const MovingBody& motion, double mass,
                      const Mat6& held, const Vec3& arm_W) {
  if (motion.asleep) return {};
  // M a + w × I w = F + Aᵀλ and A (a − b) = 0: a = b + M⁻¹ (F − w × I w − M b)
  const Vec3 w = motion.V_WO.w;
  const Twist& b = motion.bias_W;
  const Wrench smooth{mass * (model.world.gravity_W - b.v),
                      -cross(w, motion.inertia_W * w) - motion.inertia_W * b.w};
  Twist a = moved_by(held.a, smooth + motion.joints_W);
  a.v += b.v;
  a.w += b.w;
  return {a.v + cross(a.w, arm_W) + cross(w, cross(w, arm_W)), a.w};
}

void note_responses(const BodiesModel& model, BodiesState& state, const NewPushes& pushes,
                    double dt, double step, SceneFrame& frame) {
  BodyWorld& world = *state.world;
  std::array<BodyInertia, kMaxObjects> inertias{};
  for (const uint32_t i : model.with_mass) {
    inertias[i] = {model.world.objects[i].mass.mass, world.motion(i).inertia_W};
  }
  const std::span<const BodyInertia> bodies(inertias.data(), frame.objects.size());
  for (size_t k = 0; k < model.with_mass.size(); ++k) {
    const uint32_t i = model.with_mass[k];
    SceneObject& object = frame.objects[i];
    ObjectResponse& response = frame.responses[k];
    const MovingBody motion = world.motion(i);
    if (is_out_of_reach(motion.X_WO, model.world.objects[i].X_WO, model.reach)) {
      world.freeze(i);
      object.X_WO = world.motion(i).X_WO;
      object.V_WO = {};
      response = {};
      continue;
    }
    const bool is_touched =
        state.touched_ns[k] != 0 && frame.t_ns - state.touched_ns[k] < kTouchedNs;
    const bool has_slept = k < state.last.responses.size() && state.last.objects[i].V_WO == Twist{};
    if (motion.asleep && has_slept && !is_touched) {
      object.X_WO = motion.X_WO;
      object.V_WO = motion.V_WO;
      response = state.last.responses[k];
      continue;
    }
    const Vec3 arm_W = motion.X_WO.p - motion.centre_W;
    const bool is_free = std::ranges::none_of(
        world.rows(), [&](const ConstraintRow& row) { return row.a == i || row.b == i; });
    const Mat6 alone = mobility_at_centre(bodies, world.rows(), i, 1);
    const Mat6 held =
        is_touched ? mobility_at_centre(bodies, world.rows(), i, kMostNeighbours) : alone;
    response.mobility = mobility_at(held, arm_W).a;
    response.acceleration_W = acceleration_of(model, motion, inertias[i].mass, alone, arm_W);
    // Bullet moves by the velocity at the end of a step: by an impulse as if it had come at once,
    // and a falling body by half a step of acceleration too far. What something holds is left where
    // it is, or it would creep: its velocity is that of half a step ago
    const Twist late = moved_by(response.mobility, pushes[k].late_W);
    const Twist& a = response.acceleration_W;
    const double half = is_free ? -0.5 * step * dt : 0;
    const Twist displacement{late.v + half * a.v, late.w + half * a.w};
    if (displacement != Twist{}) world.shift(i, displacement);
    const MovingBody now = world.motion(i);
    object.X_WO = now.X_WO;
    object.V_WO = now.V_WO;
    if (!is_free && !now.moves_by_mean) object.V_WO = now.V_WO + 0.5 * step * a;
  }
}

/// How far the counters of each hand are used.
void note_seen(const BodiesModel& model, const BodiesState& state, SceneFrame& frame) {
  for (size_t k = 0; k < model.with_mass.size(); ++k) {
    for (uint32_t hand = 0; hand < frame.n_hands; ++hand) {
      frame.seen.push_back(state.seen[hand].pushes[k]);
    }
  }
}

}  // namespace

int steps_between(double dt, double period) {
  HAPTIC_ASSERT(period > 0);
  return std::max(1, static_cast<int>(std::ceil(dt / (kLongest * period))));
}

BodiesModel build_bodies(const SessionConfig& config, std::span<const MeshShape> shapes,
                         std::span<const PieceTree> pieces) {
  BodiesModel model;
  for (uint32_t i = 0; i < config.n_objects; ++i) {
    if (has_mass(config.objects[i].body)) model.with_mass.push_back(i);
  }
  if (model.with_mass.empty()) return model;
  HAPTIC_ASSERT(shapes.size() >= config.n_objects);
  model.period = 1 / config.sim_rate;
  model.reach = config.sim_reach;
  model.world.gravity_W = config.gravity_W;
  for (uint32_t i = 0; i < config.n_objects; ++i) {
    const ObjectConfig& object = config.objects[i];
    WorldObject made;
    made.X_WO = object.X_WO;
    made.mesh = shapes[i].mesh;
    made.mass = mass_of(object, made.mesh);
    made.shape = shape_of(object, made.mesh);
    made.pieces = pieces_of(i < pieces.size() ? pieces[i] : PieceTree{}, made.mesh);
    made.never_moves = !has_mass(object.body) && row_of(object.motion.kind).is_still &&
                       !is_moved_by_client(config, i);
    made.friction = object.material.friction_dynamic;
    made.restitution = object.body.restitution;
    model.world.objects.push_back(std::move(made));
  }
  model.world.joints.assign(config.joints.begin(), config.joints.begin() + config.n_joints);
  return model;
}

bool is_of(const BodiesModel& model, size_t n_objects, size_t n_given, const SceneFrame& frame) {
  const size_t n = model.with_mass.size();
  if (frame.objects.size() != n_objects || frame.responses.size() != n + n_given) return false;
  if (frame.joints.size() != model.world.joints.size()) return false;
  if (frame.n_hands == 0 || frame.seen.size() != (n + n_given) * frame.n_hands) return false;
  for (size_t k = 0; k < n; ++k) {
    if (frame.objects[model.with_mass[k]].response != k) return false;
  }
  return true;
}

void step_bodies(const BodiesModel& model, BodiesState& state, const HandFrames& hands,
                 SceneFrame& frame) {
  HAPTIC_ASSERT(hands.size() <= frame.n_hands && frame.n_hands <= kMostHands);
  const double dt = 1e-9 * static_cast<double>(frame.t_ns - state.last.t_ns);
  const bool is_new = !state.world && !state.resumed;
  const bool was_away = !state.world || state.resumed || dt > seconds_of(kExtrapolationNs);
  if (!state.world) state.world.emplace(model.world);
  for (uint32_t k = 0; k < model.with_mass.size(); ++k) {
    frame.objects[model.with_mass[k]].response = k;
  }
  if (is_new) {
    state.last = frame;
    for (const uint32_t i : model.with_mass) {
      state.last.objects[i].X_WO = model.world.objects[i].X_WO;
    }
  }
  frame.responses.resize(model.with_mass.size());
  frame.joints.resize(model.world.joints.size());
  state.resumed = false;
  if (was_away) {
    restart(model, state, hands, frame);
    if (is_new) note_responses(model, state, {}, 0, 0, frame);
    state.returned_seq = is_new ? 0 : frame.seq;
    state.returned_ns = frame.t_ns;
  } else if (is_awaited(state, hands, frame.t_ns)) {
    await_hands(model, state, hands, frame);
  } else if (dt > 0) {
    const NewPushes pushes = give_pushes(model, state, hands, frame.t_ns, dt);
    const double step = step_world(model, *state.world, dt, frame);
    note_responses(model, state, pushes, dt, step, frame);
  } else {
    stand_still(model, state.last, frame);
  }
  for (uint32_t j = 0; j < frame.joints.size(); ++j) frame.joints[j] = state.world->joint(j);
  note_seen(model, state, frame);
  copy_in_use(frame, state.last);
}

}  // namespace haptic
