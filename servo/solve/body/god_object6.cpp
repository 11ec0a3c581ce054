// SPDX-License-Identifier: GPL-3.0-or-later
#include "servo/solve/body/god_object6.h"

#include <algorithm>
#include <cmath>

#include "proto/math/assert.h"
#include "proto/math/qp.h"
#include "servo/solve/coupled_body.h"
#include "servo/solve/point/shading.h"
#include "servo/solve/point/texture.h"

namespace haptic {
namespace {

constexpr double kTouching = 1e-6;  // nearer to a row than this is on it [m]

/// The problem of this tick. Motions start from X_WG.
struct Problem {
  Coupling coupling;  // with springs that a metric can be made of
  MotionMetric metric;
  RigidContacts contacts;
  std::array<MotionRow, kMaxContacts> rows;    // relaxed towards the hand by their weight
  std::array<Vec3, kMaxContacts> carried_W{};  // motion of the objects relative to the carrier
  Twist hand;                                  // a_u
  Twist last;                                  // a_P; with friction put onto the rows
  bool has_last = false, has_friction = false;

  Wrench springs(const Twist& a) const {
    return {coupling.translational_stiffness * a.v, coupling.rotational_stiffness * a.w};
  }
};

/// Some of the rows, moved, and the hand with them.
struct Selection {
  std::array<size_t, kMaxContacts> index;
  std::array<Vec3, kMaxContacts> moved_W;
  size_t size = 0;
  Twist way;  // of the hand against all

  void add(size_t i, const Vec3& by_W) {
    HAPTIC_ASSERT(size < index.size());
    index[size] = i;
    moved_W[size++] = by_W;
  }
};

struct Answer {
  Twist a;
  Wrench F_W;  // of the contacts
  std::array<size_t, kMaxCarrying> contact{};
  std::array<Vec3, kMaxCarrying> push_W{};
  size_t n_pushing = 0;
  bool converged = true;

  void add(size_t i, const Vec3& by_W) {
    if (n_pushing == kMaxCarrying) return;
    contact[n_pushing] = i;
    push_W[n_pushing++] = by_W;
  }
};

/// The pose that the last proxy has now.
Pose last_proxy(const GodObject6State& state, const BodyTick& tick) {
  return tick.pose_of(state.carrier) * state.X_CP;
}

void pose_motion_problem(const GodObject6State& state, const BodyTick& tick, Problem& problem) {
  const RigidContacts& contacts = problem.contacts;
  problem.hand = way_between(contacts.X_WG, tick.hand.X_WT);
  const Twist carrier = object_twist(tick, state.carrier, contacts.X_WG.p);
  for (size_t i = 0; i < contacts.size; ++i) {
    const RigidContact& c = contacts.contacts[i];
    problem.rows[i] = eased(row_of(c, {}), problem.hand, c.weight);
    if (state.started) problem.carried_W[i] = tick.dt * velocity_at(c.V_W - carrier, c.r_W);
    problem.has_friction |= c.friction > 0;
  }
  problem.has_last = state.started;
  if (!state.started) return;
  problem.last = way_between(contacts.X_WG, last_proxy(state, tick));
  // friction holds the proxy on the rows, and rows that all allow its place have a solution
  if (problem.has_friction) {
    problem.last =
        least_constraint(problem.metric, problem.last, {problem.rows.data(), contacts.size}).a;
  }
}

/// The motion nearest to `target` that the rows allow.
Answer slide(const Problem& problem, const Twist& target, const Selection& selection) {
  std::array<MotionRow, kMaxContacts> rows;
  for (size_t j = 0; j < selection.size; ++j) {
    rows[j] = problem.rows[selection.index[j]];
    rows[j].b += dot(rows[j].J.v, selection.moved_W[j]);
  }
  const ConstrainedMotion motion =
      least_constraint(problem.metric, target - selection.way, {rows.data(), selection.size});
  Answer answer;
  answer.a = motion.a;
  answer.F_W = motion.constraint;
  answer.converged = motion.converged && !motion.contradictory;
  for (size_t j = 0; j < static_cast<size_t>(motion.n_active); ++j) {
    const auto k = static_cast<size_t>(motion.active[j]);
    HAPTIC_ASSERT(k < selection.size);
    if (motion.multiplier[j] > 0)
      answer.add(selection.index[k], motion.multiplier[j] * rows[k].J.v);
  }
  return answer;
}

/// The motion with friction, which holds the proxy where it was.
Answer slide_or_stick(CoulombSolver& solver, const Problem& problem, const Twist& target,
                      const Selection& selection) {
  std::array<FrictionContact, kMaxContacts> contacts;
  for (size_t j = 0; j < selection.size; ++j) {
    const size_t i = selection.index[j];
    const RigidContact& c = problem.contacts.contacts[i];
    const MotionRow& row = problem.rows[i];
    // the gap has the way of the object in it already
    const Vec3& carried_W = problem.carried_W[i];
    const double from_last = std::min(row.b - dot(row.J, problem.last), 0.0);
    const double least = from_last - dot(row.J.v, carried_W);
    contacts[j] = {c.r_W, c.normal_W, least, c.friction, carried_W + selection.moved_W[j]};
  }
  const FrictionStep step = solver.step(problem.metric, target - selection.way - problem.last,
                                        {contacts.data(), selection.size}, kMaxFrictionSolves);
  Answer answer;
  answer.a = problem.last + step.v;
  answer.F_W = step.impulse;
  answer.converged = step.converged && !step.contradictory;
  for (size_t j = 0; j < step.impulses.size(); ++j) {
    if (step.impulses[j] != Vec3{}) answer.add(selection.index[j], step.impulses[j]);
  }
  return answer;
}

Answer solve(CoulombSolver& solver, const Problem& problem, const Twist& target,
             const Selection& selection) {
  return problem.has_friction ? slide_or_stick(solver, problem, target, selection)
                              : slide(problem, target, selection);
}

Selection all_rows(const Problem& problem) {
  Selection all;
  for (size_t i = 0; i < problem.contacts.size; ++i) all.add(i, {});
  return all;
}

/// Poses the problem again where surfaces bend or end beside the contacts, as seen from the place
/// of the first answer and from where friction may hold the proxy. A contact holds while the hand
/// is within its extent as well: where another pushes the proxy away it would come and go. False
/// if nothing changes.
bool sees_surfaces(const GodObject6State& state, const BodyTick& tick, const Answer& first,
                   Problem& problem) {
  std::array<Pose, 3> places_W{moved(problem.contacts.X_WG, first.a), {}, {}};
  size_t n = 1;
  if (problem.has_friction && state.started) places_W[n++] = last_proxy(state, tick);
  places_W[n] = tick.hand.X_WT;
  const SurfacePlaces places{{places_W.data(), n}, {places_W.data(), n + 1}};
  if (!follow_surfaces(tick, places, problem.contacts)) return false;
  pose_motion_problem(state, tick, problem);
  return true;
}

/// How far the damper lets an object pass the hand: b/k times their relative velocity.
Twist damped_way(const Problem& problem, const BodyTick& tick, uint32_t object, double weight) {
  const Coupling& c = problem.coupling;
  const Twist V = object_twist(tick, object, tick.hand.X_WT.p) - tick.hand.V_WT;
  return {weight * c.translational_damping / c.translational_stiffness * V.v,
          weight * c.rotational_damping / c.rotational_stiffness * V.w};
}

/// The rows that the proxy is on, each moved by its damped way: one that is only near must not
/// brake. What they have in common is moved as the hand, which contradicts nothing.
Selection touching_rows(const Problem& problem, const BodyTick& tick, const Twist& a) {
  const uint32_t carrier = problem.contacts.carrier;
  Selection touching;
  touching.way = damped_way(problem, tick, carrier, tick.weight);
  for (size_t i = 0; i < problem.contacts.size; ++i) {
    const MotionRow& row = problem.rows[i];
    if (dot(row.J, a) - row.b > kTouching) continue;
    const RigidContact& c = problem.contacts.contacts[i];
    const bool is_common = c.object == carrier && c.weight == tick.weight;
    const Twist rest =
        is_common ? Twist{} : damped_way(problem, tick, c.object, c.weight) - touching.way;
    touching.add(i, velocity_at(rest, c.r_W));
  }
  return touching;
}

/// The normal that a contact is felt with: interpolated, and tilted by the texture on the way.
Vec3 felt_normal(const Materials& materials, const BodyTick& tick, const Problem& problem,
                 const RigidContact& contact, const Twist& a) {
  const TextureConfig& texture = materials.of(tick.object_of(contact.object)).texture;
  if (texture.kind == TextureKind::kNone) return contact.shading_W;
  const Pose X_OW = inverse(tick.X_WO[contact.object]);
  const auto place_O = [&](const Twist& motion) {
    const Vec3 way_W = velocity_at(motion, contact.r_W);
    return X_OW * (problem.contacts.X_WG.p + contact.r_W + way_W);
  };
  const Vec3 to_O = place_O(a);
  const TexturePath path{problem.has_last ? place_O(problem.last) : to_O, to_O,
                         rotate(X_OW.q, contact.normal_W)};
  const Vec3 gradient_O = steepest_gradient(texture, materials.images, path);
  return rotate(tick.X_WO[contact.object].q,
                tilted_normal(rotate(X_OW.q, contact.shading_W), gradient_O));
}

/// A row turned so that, were it alone, a motion from the hand along it ends on the true row.
MotionRow turned(const Problem& problem, const RigidContact& contact, const MotionRow& row,
                 const Vec3& normal_W) {
  const Vec3 m_W = limited_normal(normal_W, contact.normal_W);
  const Twist J{m_W, cross(contact.r_W, m_W)};
  const Twist way = response(problem.metric, {J.v, J.w});
  const double violation = row.b - dot(row.J, problem.hand);
  const double rise = dot(row.J, way);
  if (!(violation > 0 && rise > 0)) return row;
  return {J, dot(J, problem.hand) + violation / rise * dot(J, way)};
}

/// How far shading and texture move the proxy from where the true rows alone put it.
Twist shaded_way(const Materials& materials, const BodyTick& tick, const Problem& problem,
                 const Answer& plain) {
  std::array<MotionRow, kMaxContacts> rows = problem.rows;
  bool any = false;
  for (size_t j = 0; j < plain.n_pushing; ++j) {
    const size_t i = plain.contact[j];
    const RigidContact& c = problem.contacts.contacts[i];
    const Vec3 felt_W = felt_normal(materials, tick, problem, c, plain.a);
    if (felt_W == c.normal_W) continue;
    rows[i] = turned(problem, c, rows[i], felt_W);
    any = true;
  }
  if (!any) return {};
  const size_t n = problem.contacts.size;
  const ConstrainedMotion first = least_constraint(problem.metric, problem.hand, {rows.data(), n});
  if (!first.converged || first.contradictory) return {};
  return slide(problem, first.a, all_rows(problem)).a - plain.a;
}

/// Keeps for the next tick which object carries the proxy, and which materials slide.
void remember(const BodyTick& tick, const Problem& problem, const Answer& answer, const Pose& X_WP,
              GodObject6State& state) {
  state.slides = {};
  for (size_t j = 0; j < answer.n_pushing && problem.has_last; ++j) {
    const RigidContact& c = problem.contacts.contacts[answer.contact[j]];
    const Vec3 way_W =
        velocity_at(answer.a - problem.last, c.r_W) - problem.carried_W[answer.contact[j]];
    state.slides[c.object] |= is_sliding(c, way_W / tick.dt);
  }
  state.started = true;
  state.carrier = problem.contacts.carrier;
  state.X_CP = inverse(tick.pose_of(state.carrier)) * X_WP;
}

/// Sums what the hand feels, within the bounds of the coupling, by the objects that push: shading
/// is attributed to the contact that pushes hardest.
void add_force(const Problem& problem, const Answer& felt, const Wrench& shading_W,
               BodySolution& out) {
  const Wrench F = felt.F_W + shading_W;
  const auto share_of = [](double most, double size) {
    return most > 0 && size > most ? most / size : 1;
  };
  const double share = std::min(share_of(problem.coupling.max_force, norm(F.f)),
                                share_of(problem.coupling.max_torque, norm(F.t)));
  out.F_hand_W = share * F;
  double hardest = 0;
  uint32_t object = kNoBody;
  const auto push = [&](uint32_t by, const Wrench& F_W) {
    if (by < out.push_W.size()) out.push_W[by] = out.push_W[by] + share * F_W;
  };
  for (size_t j = 0; j < felt.n_pushing; ++j) {
    const RigidContact& c = problem.contacts.contacts[felt.contact[j]];
    const Vec3& push_W = felt.push_W[j];
    push(c.object, {push_W, cross(c.r_W, push_W)});
    if (norm(push_W) > hardest) hardest = norm(push_W), object = c.object;
  }
  push(object, shading_W);
}

/// The velocity of the proxy since the last tick.
Twist velocity_of(const GodObject6State& state, const BodyTick& tick, const Pose& X_WP) {
  if (!state.started) return {};
  const Twist way = way_between(last_proxy(state, tick), X_WP);
  return 1 / tick.dt * way + object_twist(tick, state.carrier, X_WP.p);
}

}  // namespace

BodySolution solve_god_object6(const Materials& materials, GodObject6State& state,
                               CoulombSolver& solver, const BodyTick& tick) {
  HAPTIC_ASSERT(tick.dt > 0);
  BodySolution out(tick);
  Problem problem;
  problem.contacts = carry_rigid_contacts(materials, tick, state.slides);
  out.finite = problem.contacts.finite;
  if (!out.finite) {
    state = {};
    return out;
  }
  problem.coupling = with_least_springs(tick.coupling, tick.tool.radius);
  problem.metric = spring_metric(problem.coupling);
  pose_motion_problem(state, tick, problem);
  Selection all = all_rows(problem);
  Answer held = slide(problem, problem.hand, all);
  if (held.n_pushing > 0 && sees_surfaces(state, tick, held, problem)) {
    all = all_rows(problem);
    held = slide(problem, problem.hand, all);
  }
  if (held.n_pushing > 0) {
    const Twist shaded = shaded_way(materials, tick, problem, held);
    const Twist foot = held.a + shaded;
    // what friction has not held anywhere yet is held where it arrives
    if (!problem.has_last) problem.last = foot;
    const Twist target = problem.hand + shaded;
    if (problem.has_friction || shaded != Twist{}) held = solve(solver, problem, target, all);
    if (problem.has_friction) out.held_back_W = held.a.v - foot.v;
    const Coupling& c = problem.coupling;
    const bool damps = c.translational_damping > 0 || c.rotational_damping > 0;
    const Answer felt =
        damps ? solve(solver, problem, target, touching_rows(problem, tick, held.a)) : held;
    out.converged = felt.converged;
    out.proxy.X_WT = moved(problem.contacts.X_WG, held.a);
    add_force(problem, felt, problem.springs(shaded), out);
  }
  out.converged &= held.converged;
  out.n_pushing = static_cast<int>(held.n_pushing);
  out.proxy.V_WT = velocity_of(state, tick, out.proxy.X_WT);
  remember(tick, problem, held, out.proxy.X_WT, state);
  return out;
}

}  // namespace haptic
