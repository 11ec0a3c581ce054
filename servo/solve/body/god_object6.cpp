// SPDX-License-Identifier: GPL-3.0-or-later
#include "servo/solve/body/god_object6.h"

#include <algorithm>
#include <cmath>

#include "proto/math/assert.h"
#include "proto/math/qp.h"
#include "servo/solve/point/shading.h"
#include "servo/solve/point/texture.h"

namespace haptic {
namespace {

constexpr double kTouching = 1e-6;     // nearer to a row than this is on it [m]
constexpr double kLeastSpring = 1e-6;  // that a metric can be made of [N/m]
constexpr double kLeastTurn = 1e-3;    // of k_T radius², the same of rotation
constexpr double kRoundings = 1e-9;    // of a step of force

/// What this tick is solved from. Motions are those from `base`, itself one from X_WG that all rows
/// allow, where friction holds: a program whose rows all allow zero has a solution whatever
/// rounding does.
struct Problem {
  VirtualCoupling coupling;  // with springs that a metric can be made of
  MotionMetric metric;
  RigidContacts contacts;                           // those that fade stand last
  std::array<MotionRow, kMaxRigidContacts> rows;    // eased
  std::array<Vec3, kMaxRigidContacts> carried_W{};  // way of the objects beside the carrier
  size_t n_lasting = 0;
  Twist base;         // a_P, put onto the rows
  Twist hand;         // a_u
  double let_in = 0;  // how far all rows at once would push the last proxy [m]
  bool has_last = false, has_friction = false;

  Wrench springs(const Twist& a) const {
    return {coupling.translational_stiffness * a.v, coupling.rotational_stiffness * a.w};
  }
  /// |a|_M as a translation [m].
  double length_of(const Twist& a) const {
    return spring_length(a, coupling.translational_stiffness, coupling.rotational_stiffness);
  }
  /// |F| in it [N].
  double size_of(const Wrench& F) const {
    return spring_force(F, coupling.translational_stiffness, coupling.rotational_stiffness);
  }
};

/// Some of the rows, moved, and the hand with them.
struct Selection {
  std::array<size_t, kMaxRigidContacts> index;
  std::array<Vec3, kMaxRigidContacts> moved_W;
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

/// diag(k_T, k_R), none of them zero.
void set_metric(const RigidProxyModel& model, Problem& problem) {
  VirtualCoupling& c = problem.coupling;
  c = model.coupling;
  c.translational_stiffness = std::max(c.translational_stiffness, kLeastSpring);
  const double r2 = model.tool.radius * model.tool.radius;
  c.rotational_stiffness =
      std::max(c.rotational_stiffness, kLeastTurn * c.translational_stiffness * r2);
  problem.metric = factor_metric(spring_matrix(c.translational_stiffness, c.rotational_stiffness));
}

RigidContact carried(const FadingPlane& plane, const RigidProxyTick& tick, const Pose& X_WG) {
  const Pose& X_WO = tick.X_WO[plane.object];
  RigidContact contact;
  contact.tool_point_T = plane.tool_point_T;
  contact.r_W = rotate(X_WG.q, plane.tool_point_T);
  contact.normal_W = contact.shading_W = rotate(X_WO.q, plane.normal_O);
  contact.gap = dot(contact.normal_W, X_WG.p + contact.r_W - X_WO * plane.object_point_O);
  contact.weight = plane.weight * tick.weight;
  contact.V_W = object_twist(tick, plane.object, X_WG.p);
  contact.object = plane.object;
  contact.material = plane.material;
  return contact;
}

/// Of the object that carried the last proxy, or the world.
Pose carrier_pose(const GodObject6State& state, const RigidProxyTick& tick) {
  HAPTIC_ASSERT(state.carrier <= kNoObject);
  return state.carrier == kNoObject ? Pose{} : tick.X_WO[state.carrier];
}

/// Where the last proxy is now.
Pose last_proxy(const GodObject6State& state, const RigidProxyTick& tick) {
  return carrier_pose(state, tick) * state.X_CP;
}

Wrench rotated(const Quat& q, const Wrench& F) {
  return {rotate(q, F.f), rotate(q, F.t)};
}
Twist rotated(const Quat& q, const Twist& a) {
  return {rotate(q, a.v), rotate(q, a.w)};
}

/// From now on motions are those from another base.
void rebase(Problem& problem, const Twist& by) {
  problem.base = problem.base + by;
  problem.hand = problem.hand - by;
  for (size_t i = 0; i < problem.contacts.size; ++i) {
    MotionRow& row = problem.rows[i];
    const bool overlaps = i < problem.n_lasting && problem.contacts.contacts[i].gap < 0;
    row.b -= dot(row.J, by);
    if (!overlaps) row.b = std::min(row.b, 0.0);
  }
}

/// All rows: relaxed towards the hand by their weight, and let in where the last proxy is behind.
void pose_problem(const RigidProxyModel& model, const GodObject6State& state,
                  const RigidProxyTick& tick, Problem& problem) {
  set_metric(model, problem);
  RigidContacts& contacts = problem.contacts;
  problem.n_lasting = contacts.size;
  for (size_t i = 0; i < state.n_fading && tick.weight > 0; ++i) {
    HAPTIC_ASSERT(contacts.size < contacts.contacts.size());
    RigidContact& c = contacts.contacts[contacts.size++];
    c = carried(state.fading[i], tick, contacts.X_WG);
    c.friction = friction_of(model, state.slides, c.material);
  }
  problem.hand = way_between(contacts.X_WG, tick.hand.X_WT);
  problem.has_last = state.started;
  Twist last;
  if (state.started) last = way_between(contacts.X_WG, last_proxy(state, tick));
  const double let_in = std::min(state.started ? tick.dt / model.blend_time : 1, 1.0);
  const Twist carrier = object_twist(tick, state.carrier, contacts.X_WG.p);
  std::array<MotionRow, kMaxRigidContacts> full;
  bool is_behind = false;
  for (size_t i = 0; i < contacts.size; ++i) {
    const RigidContact& c = contacts.contacts[i];
    full[i] = eased(row_of(c, {}), problem.hand, c.weight);
    problem.rows[i] = eased(full[i], last, let_in);
    is_behind |= i < problem.n_lasting && problem.rows[i].b != full[i].b;
    if (state.started) problem.carried_W[i] = tick.dt * velocity_at(c.V_W - carrier, c.r_W);
    problem.has_friction |= c.friction > 0;
  }
  // friction holds the proxy where it would be, had it been let in all at once
  if (is_behind) {
    const Twist out = least_constraint(problem.metric, last, {full.data(), problem.n_lasting}).a;
    problem.let_in = problem.length_of(out - last);
    last = out;
  }
  rebase(problem, last);
}

/// The motion nearest to `target` that the rows allow.
Answer slide(const Problem& problem, const Twist& target, const Selection& selection) {
  std::array<MotionRow, kMaxRigidContacts> rows;
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

/// The same with friction, which holds the proxy where it was.
Answer slide_or_stick(CoulombSolver& solver, const Problem& problem, const Twist& target,
                      const Selection& selection) {
  std::array<FrictionContact, kMaxRigidContacts> contacts;
  for (size_t j = 0; j < selection.size; ++j) {
    const size_t i = selection.index[j];
    const RigidContact& c = problem.contacts.contacts[i];
    const MotionRow& row = problem.rows[i];
    // the gap has the way of the object in it already
    const Vec3& carried_W = problem.carried_W[i];
    const double least = row.b - dot(row.J.v, carried_W);
    contacts[j] = {c.r_W, c.normal_W, least, c.friction, carried_W + selection.moved_W[j]};
  }
  const FrictionStep step = solver.step(problem.metric, target - selection.way,
                                        {contacts.data(), selection.size}, kMaxFrictionSolves);
  Answer answer;
  answer.a = step.v;
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

/// How far the damper lets an object pass the hand: b/k times their relative velocity.
Twist damped_way(const Problem& problem, const RigidProxyTick& tick, uint32_t object,
                 double weight) {
  const VirtualCoupling& c = problem.coupling;
  const Twist V = object_twist(tick, object, tick.hand.X_WT.p) - tick.hand.V_WT;
  return {weight * c.translational_damping / c.translational_stiffness * V.v,
          weight * c.rotational_damping / c.rotational_stiffness * V.w};
}

/// The rows that the proxy is on, each moved by its damped way: one that is only near must not
/// brake. What they have in common is moved as the hand, which contradicts nothing.
Selection touching_rows(const Problem& problem, const RigidProxyTick& tick, const Twist& a) {
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
    Vec3 moved_W = velocity_at(rest, c.r_W);
    // one that fades holds nothing that another lets go
    if (i >= problem.n_lasting) moved_W = std::min(dot(c.normal_W, moved_W), 0.0) * c.normal_W;
    touching.add(i, moved_W);
  }
  return touching;
}

/// The normal that a contact is felt with: interpolated, and tilted by the texture on the way.
Vec3 felt_normal(const RigidProxyModel& model, const RigidProxyTick& tick, const Problem& problem,
                 const RigidContact& contact, const Twist& a) {
  const MaterialConfig* material = material_of(model, contact.material);
  const bool is_smooth = material == nullptr || material->texture.kind == TextureKind::kNone;
  if (is_smooth) return contact.shading_W;
  const Pose X_OW = inverse(tick.X_WO[contact.object]);
  const auto place_O = [&](const Twist& motion) {
    const Vec3 way_W = velocity_at(problem.base + motion, contact.r_W);
    return X_OW * (problem.contacts.X_WG.p + contact.r_W + way_W);
  };
  const Vec3 to_O = place_O(a);
  const TexturePath path{problem.has_last ? place_O({}) : to_O, to_O,
                         rotate(X_OW.q, contact.normal_W)};
  const Vec3 gradient_O = steepest_gradient(material->texture, model.images, path);
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
Twist shaded_way(const RigidProxyModel& model, const RigidProxyTick& tick, const Problem& problem,
                 const Answer& plain) {
  std::array<MotionRow, kMaxRigidContacts> rows = problem.rows;
  bool any = false;
  for (size_t j = 0; j < plain.n_pushing; ++j) {
    const size_t i = plain.contact[j];
    const RigidContact& c = problem.contacts.contacts[i];
    const Vec3 felt_W = felt_normal(model, tick, problem, c, plain.a);
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

/// The largest of the ticks in which what it was may be let out.
double largest_of_late(const GodObject6State& state, double blend_ticks) {
  const double ticks = std::ceil(std::min(blend_ticks, static_cast<double>(state.sizes.size())));
  const size_t n = std::min({static_cast<size_t>(ticks) + 1, state.n_ticks, state.sizes.size()});
  double largest = 0;
  for (size_t i = 1; i <= n; ++i) {
    largest = std::max(largest, state.sizes[(state.n_ticks - i) % state.sizes.size()]);
  }
  return largest;
}

/// How much of this change of the force since the last tick is felt now: what is more than the
/// hand, shading and blending make is put off.
double share_felt(const RigidProxyModel& model, const GodObject6State& state,
                  const RigidProxyTick& tick, const Problem& problem, const Twist& shaded,
                  const Wrench& change_W) {
  const bool is_blended = problem.has_last && model.blend_time > tick.dt && tick.weight > 0;
  if (!is_blended || problem.has_friction) return 1;
  const Pose X_WC = carrier_pose(state, tick);
  const double step = problem.size_of(change_W);
  double moved = problem.length_of(way_between(X_WC * state.X_CH, tick.hand.X_WT)) +
                 problem.length_of(shaded - rotated(X_WC.q, state.shaded_C));
  for (size_t i = 0; i < problem.contacts.size; ++i) {
    moved = std::max(moved, norm(problem.carried_W[i]));
  }
  const double k_T = problem.coupling.translational_stiffness;
  const double blend_ticks = model.blend_time / tick.dt;
  const double blended = largest_of_late(state, blend_ticks) + k_T * problem.let_in;
  const double most = (1 + kRoundings) * (k_T * moved + blended / blend_ticks);
  return step > most ? most / step : 1;
}

/// Who carries the proxy, and what slides.
void remember(const RigidProxyModel& model, const RigidProxyTick& tick, const Problem& problem,
              const Answer& answer, const Twist& shaded, const Wrench& F_W, const BodySolution& out,
              GodObject6State& state) {
  const std::array<FadingPlane, kMaxCarrying> before = state.fading;
  state.n_fading = 0;
  state.slides = {};
  for (size_t j = 0; j < answer.n_pushing; ++j) {
    const size_t i = answer.contact[j];
    const RigidContact& c = problem.contacts.contacts[i];
    const Vec3 way_W = velocity_at(answer.a, c.r_W) - problem.carried_W[i];
    state.slides[c.material % kMaxObjects] |= problem.has_last && is_sliding(c, way_W / tick.dt);
    FadingPlane plane;
    if (i >= problem.n_lasting) {
      plane = before[i - problem.n_lasting];
    } else {
      const Pose X_OW = inverse(tick.X_WO[c.object]);
      // as far as the proxy is let onto the row, and as if that had not faded
      const double low = dot(problem.rows[i].J, problem.hand);
      const double rise = low + (dot(problem.rows[i].J, answer.a) - low) / c.weight;
      const double from_base = dot(problem.rows[i].J, problem.base);
      const Vec3 place_W = problem.contacts.X_WG.p + c.r_W + (from_base + rise) * c.normal_W;
      plane = {c.tool_point_T, X_OW * place_W, rotate(X_OW.q, c.normal_W), 1, c.object, c.material};
    }
    plane.weight -= model.blend_time > 0 ? tick.dt / model.blend_time : 1;
    HAPTIC_ASSERT(state.n_fading < state.fading.size());
    if (plane.weight > 0) state.fading[state.n_fading++] = plane;
  }
  state.started = true;
  state.carrier = problem.contacts.carrier;
  const Pose X_CW = inverse(carrier_pose(state, tick));
  state.X_CP = X_CW * out.proxy.X_WT;
  state.X_CH = X_CW * tick.hand.X_WT;
  state.shaded_C = rotated(X_CW.q, shaded);
  state.F_C = rotated(X_CW.q, F_W);
  state.sizes[state.n_ticks++ % state.sizes.size()] = problem.size_of(F_W);
}

/// What the hand feels, and who makes it: shading is of the contact that pushes hardest, what is
/// left of the last tick's force of who carried the tool then.
struct Felt {
  const Answer& contacts;
  Wrench shading_W, last_W;
  double share = 1;  // of what is new
  uint32_t last_carrier = kNoObject;
};

void add_force(const Problem& problem, const Felt& felt, BodySolution& out) {
  const double rest = 1 - felt.share;
  const Wrench F = felt.share * (felt.contacts.F_W + felt.shading_W) + rest * felt.last_W;
  const auto share_of = [](double most, double size) {
    return most > 0 && size > most ? most / size : 1;
  };
  const double share = std::min(share_of(problem.coupling.max_force, norm(F.f)),
                                share_of(problem.coupling.max_torque, norm(F.t)));
  out.F_hand_W = share * F;
  double hardest = 0;
  uint32_t object = kNoObject;
  const auto push = [&](uint32_t by, const Wrench& F_W) {
    if (by < kMaxObjects) out.push_W[by] = out.push_W[by] + share * F_W;
  };
  for (size_t j = 0; j < felt.contacts.n_pushing; ++j) {
    const RigidContact& c = problem.contacts.contacts[felt.contacts.contact[j]];
    const Vec3& push_W = felt.contacts.push_W[j];
    push(c.object, felt.share * Wrench{push_W, cross(c.r_W, push_W)});
    if (norm(push_W) > hardest) hardest = norm(push_W), object = c.object;
  }
  push(object, felt.share * felt.shading_W);
  push(felt.last_carrier, rest * felt.last_W);
}

/// Of the proxy, since the last tick.
Twist velocity_of(const GodObject6State& state, const RigidProxyTick& tick, const Pose& X_WP) {
  if (!state.started) return {};
  const Twist way = way_between(last_proxy(state, tick), X_WP);
  return 1 / tick.dt * way + object_twist(tick, state.carrier, X_WP.p);
}

}  // namespace

BodySolution solve_god_object6(const RigidProxyModel& model, GodObject6State& state,
                               CoulombSolver& solver, const RigidProxyTick& tick) {
  HAPTIC_ASSERT(tick.dt > 0 && model.blend_time >= 0);
  BodySolution out;
  out.proxy = tick.hand;
  Problem problem;
  problem.contacts = carry_rigid_contacts(model, tick, state.slides);
  out.finite = problem.contacts.finite;
  if (!out.finite) {
    state = {};
    return out;
  }
  pose_problem(model, state, tick, problem);
  const Pose X_WG = problem.contacts.X_WG;
  const Selection all = all_rows(problem);
  Answer held = slide(problem, problem.hand, all), felt;
  Twist shaded;
  if (held.n_pushing > 0) {
    shaded = shaded_way(model, tick, problem, held);
    Twist foot = held.a + shaded;
    if (problem.has_friction && !problem.has_last) {
      // it has not been held anywhere yet
      rebase(problem, foot);
      foot = {};
    }
    const Twist target = problem.hand + shaded;
    if (problem.has_friction || shaded != Twist{}) held = solve(solver, problem, target, all);
    if (problem.has_friction) out.held_back_W = held.a.v - foot.v;
    const VirtualCoupling& c = problem.coupling;
    const bool damps = c.translational_damping > 0 || c.rotational_damping > 0;
    felt = damps ? solve(solver, problem, target, touching_rows(problem, tick, held.a)) : held;
    out.converged = felt.converged;
  }
  const Wrench shading_W = problem.springs(shaded), new_W = held.F_W + shading_W;
  const Wrench last_W = rotated(carrier_pose(state, tick).q, state.F_C);
  const double share = share_felt(model, state, tick, problem, shaded, new_W + -last_W);
  const Wrench F_W = share < 1 ? share * new_W + (1 - share) * last_W : new_W;
  if (held.n_pushing > 0 || share < 1) {
    Twist a = held.a;
    if (share < 1) a = a + response(problem.metric, F_W + -new_W);
    out.proxy.X_WT = moved(X_WG, problem.base + a);
    add_force(problem, {felt, shading_W, last_W, share, state.carrier}, out);
  }
  out.converged &= held.converged;
  out.n_pushing = static_cast<int>(held.n_pushing);
  out.proxy.V_WT = velocity_of(state, tick, out.proxy.X_WT);
  remember(model, tick, problem, held, shaded, F_W, out, state);
  return out;
}

}  // namespace haptic
