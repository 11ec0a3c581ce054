// SPDX-License-Identifier: GPL-3.0-or-later
#include "sim/bullet/world_joints.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <optional>
#include <tuple>

#include "proto/math/assert.h"
#include "proto/math/motion_metric.h"
#include "sim/bullet/body_state.h"
#include "sim/bullet/swinging_body.h"

namespace haptic {
namespace {

// of what has been left open, mended in one step where Bullet's rows alone hold
constexpr double kMend = 0.5;

bool is_mobile(const btRigidBody& body) {
  return body.getInvMass() > 0;
}

/// Twists of the two bodies by an impulse of one along a row, where locks let nothing happen:
/// (M + κ AᵀA)⁻¹ g.
struct Response {
  Twist a, b;
};
Response response_to(const JointRow& along, const JointRows& rows, const btRigidBody& a,
                     const btRigidBody& b) {
  using Matrix = Eigen::Matrix<double, 12, 12>;
  using Vector = Eigen::Matrix<double, 12, 1>;
  Matrix inertia = Matrix::Identity();
  double heavier = 0;
  for (const auto& [body, at] : {std::pair{&a, 0}, std::pair{&b, 6}}) {
    if (!is_mobile(*body)) continue;
    heavier = std::max(heavier, body->getMass());
    const Mat3 I = inertia_of(*body);
    for (int i = 0; i < 3; ++i) {
      inertia(at + i, at + i) = body->getMass();
      for (int j = 0; j < 3; ++j) inertia(at + 3 + i, at + 3 + j) = I.row[i][j];
    }
  }
  const auto vector_of = [&](const JointRow& row) {
    Vector g = Vector::Zero();
    for (int k = 0; k < 3; ++k) {
      if (is_mobile(a)) g(k) = row.a.v[k], g(3 + k) = row.a.w[k];
      if (is_mobile(b)) g(6 + k) = row.b.v[k], g(9 + k) = row.b.w[k];
    }
    return g;
  };
  for (uint32_t i = 0; i < rows.n_locks; ++i) {
    inertia.selfadjointView<Eigen::Lower>().rankUpdate(vector_of(rows.locks[i]), kHold * heavier);
  }
  const Eigen::LLT<Matrix> factor(inertia.selfadjointView<Eigen::Lower>());
  const Vector x = factor.solve(vector_of(along));
  return {{{x(0), x(1), x(2)}, {x(3), x(4), x(5)}}, {{x(6), x(7), x(8)}, {x(9), x(10), x(11)}}};
}

}  // namespace

struct WorldJoints::Kept {
  Kept(const JointConfig& config, btRigidBody& body_a, btRigidBody& body_b)
      : joint(build_joint(config, pose_of(body_a), pose_of(body_b))),
        a(body_a),
        b(body_b),
        locks(a, b),
        friction(a, b),
        stop(a, b) {
    for (RowConstraint* each : {&locks, &friction, &stop}) each->enableFeedback(true);
  }
  const JointKindRow& kind() const { return row_of(joint.config.kind); }
  bool is_held() const { return stuck || stop_steps > 0; }
  bool is_awake() const { return (is_mobile(a) && a.isActive()) || (is_mobile(b) && b.isActive()); }
  double speed() const { return dot(rows.along.a, twist_of(a)) + dot(rows.along.b, twist_of(b)); }
  /// Twist of A by a unit of speed, of a joint that leads.
  Twist motion() const {
    if (!kind().turns()) return {rows.axis_W, {}};
    return {cross(rows.axis_W, pose_of(a).p - rows.anchor_W), rows.axis_W};
  }
  double lead_mobility() const { return 1 / dot(motion(), momentum_of(a, motion())); }

  Joint joint;
  btRigidBody& a;
  btRigidBody& b;
  bool leads = false;                    // A has a coordinate of its own
  std::optional<SwingingBody> swinging;  // A, of a ball
  RowConstraint locks, friction, stop;
  JointRows rows;
  double position = 0;
  // of the step under way
  Twist along;  // of a joint that leads: row of the speed along the coordinate, by its momentum
  double mobility = 0;      // change of the speed along the coordinate per impulse
  double weight = 0;        // gravity along it, of a joint that drives
  double pushed_speed = 0;  // what pushes add to the mean speed beyond that at the end
  double pushed_load = 0;   // of the hand, along it, in the mean
  // of a joint that drives: load of locks and contacts along it, and the speed without them
  double others = 0, without_others = 0;
  double drag = 0;      // of the damper: c w dt
  double smooth = 0;    // change of the speed by springs, damper and gravity
  bool is_free = true;  // of a joint that leads: nothing but these has acted
  bool stuck = false;
  int stop_steps = 0;
};

WorldJoints::WorldJoints(std::span<const JointConfig> joints,
                         std::span<const std::unique_ptr<btRigidBody>> bodies,
                         std::span<const uint8_t> never_moves, const Vec3& gravity_W,
                         btDynamicsWorld& world)
    : bodies_(bodies), gravity_W_(gravity_W), world_(world) {
  for (const JointConfig& config : joints) {
    const bool is_to_world = config.to == kToWorld;
    btRigidBody& a = *bodies[config.object];
    btRigidBody& b = is_to_world ? *ground_ : *bodies[config.to];
    auto kept = std::make_unique<Kept>(config, a, b);
    const auto n_of_a = std::ranges::count_if(joints, [&](const JointConfig& other) {
      return other.object == config.object || other.to == config.object;
    });
    const bool is_fixed = is_to_world || never_moves[config.to] != 0;
    kept->leads = kept->kind().is_led() && n_of_a == 1 && is_fixed;
    if (kept->leads) {
      // both act along the coordinate alone
      a.setGravity({0, 0, 0});
      a.setFlags(0);
    }
    if (kept->kind().swings && n_of_a == 1 && is_fixed) {
      kept->swinging.emplace(a, -kept->joint.X_AJ.p, gravity_W);
    }
    kept->rows = rows_of(*kept);
    kept->stuck = config.friction > 0;
    world.addConstraint(&kept->locks, !is_to_world);
    world.addConstraint(&kept->friction, false);
    world.addConstraint(&kept->stop, false);
    joints_.push_back(std::move(kept));
  }
}

WorldJoints::~WorldJoints() {
  for (const auto& kept : joints_) {
    for (RowConstraint* rows : {&kept->locks, &kept->friction, &kept->stop}) {
      world_.removeConstraint(rows);
    }
  }
}

JointRows WorldJoints::rows_of(const Kept& kept) const {
  return joint_rows(kept.joint, pose_of(kept.a), pose_of(kept.b), kept.position);
}

/// Gravity along the coordinate of a joint that leads.
double WorldJoints::weight_at(const Kept& kept, double position) const {
  const Vec3 weight_W = kept.a.getMass() * gravity_W_;
  const JointRows& rows = kept.rows;
  const Pose X_WB = pose_of(kept.b);
  if (!kept.kind().turns()) return dot(weight_W, direction_on(kept.joint, X_WB, position));
  return dot(weight_W, cross(rows.axis_W, pose_on(kept.joint, X_WB, position).p - rows.anchor_W));
}

/// A body by its own coordinate: changes its speed, and gives Bullet rows that only act along it.
/// One that something holds moves by the speed at the end of a step, as Bullet has it.
void WorldJoints::lead(Kept& kept, double dt, const PushedMean& pushed) {
  const Twist motion = kept.motion();
  const Twist momentum = momentum_of(kept.a, motion);
  const double mobility = 1 / dot(motion, momentum), damping = kept.joint.config.damping;
  const Wrench mean_W = pushed.beyond_end(kept.a, kept.is_free);
  const double speed = mobility * dot(momentum, twist_of(kept.a));
  const CoordinateStep step{dt, kept.position, speed, mobility, mobility * dot(mean_W, motion)};
  const auto load = [&](double position) {
    JointLoad at = load_at(kept.joint, position);
    at.load += weight_at(kept, position);
    return at;
  };
  const double next = kept.is_free ? speed_by_mean_load(step, damping, load)
                                   : speed_by_end(kept.joint, step, weight_at(kept, kept.position));
  kept.smooth = next - speed;
  set_twist(kept.a, next * motion);
  kept.mobility = mobility;
  kept.pushed_speed = step.pushed_speed;
  kept.pushed_load = dot(pushed.of(kept.a), motion) / dt;
  kept.along = mobility * momentum;
  kept.friction.rows[0].a = kept.stop.rows[0].a = kept.along;
}

/// Two bodies, or one of several joints: changes their twists as their locks let them.
void WorldJoints::drive(Kept& kept, double dt, const PushedMean& pushed) {
  const Response response = response_to(kept.rows.along, kept.rows, kept.a, kept.b);
  const double mobility = dot(kept.rows.along.a, response.a) + dot(kept.rows.along.b, response.b);
  double change = 0, pushed_speed = 0, pushed_change = 0;
  for (const auto& [body, row, twist] : {std::tuple{&kept.a, &kept.rows.along.a, &response.a},
                                         std::tuple{&kept.b, &kept.rows.along.b, &response.b}}) {
    if (!is_mobile(*body)) continue;
    change += dt * dot(row->v, from_bullet(body->getGravity()));
    pushed_speed += dot(pushed.beyond_end(*body, false), *twist);
    pushed_change += dot(pushed.of(*body), *twist);
  }
  // the spring gives way to gravity, which is Bullet's, and the damper also to what other joints
  // and contacts do, as if that went on as in the last step
  const CoordinateStep step{dt, kept.position, kept.speed() + change, mobility,
                            pushed_speed + dt * mobility * kept.others};
  kept.smooth = speed_by_end(kept.joint, step, 0) - step.speed;
  kept.without_others = step.speed + kept.smooth;
  kept.mobility = mobility;
  kept.weight = change / (dt * mobility);
  kept.pushed_speed = pushed_speed;
  kept.pushed_load = pushed_change / (dt * mobility);
  const double impulse = kept.smooth / mobility;
  set_twist(kept.a, twist_of(kept.a) + impulse * response.a);
  if (is_mobile(kept.b)) set_twist(kept.b, twist_of(kept.b) + impulse * response.b);
  for (RowConstraint* one : {&kept.friction, &kept.stop}) {
    one->rows[0].a = kept.rows.along.a;
    one->rows[0].b = kept.rows.along.b;
  }
}

/// Speeds and bounds of the rows of friction and the nearer end stop.
void WorldJoints::bound(Kept& kept, double dt) {
  const JointConfig& config = kept.joint.config;
  kept.friction.n = config.friction > 0 ? 1 : 0;
  kept.friction.rows[0].lower = -config.friction * dt;
  kept.friction.rows[0].upper = config.friction * dt;
  const double below = kept.position - config.lower, above = config.upper - kept.position;
  RowConstraint::Row& stop = kept.stop.rows[0];
  kept.stop.n = is_stop(below < above ? config.lower : config.upper) ? 1 : 0;
  const double gap = std::min(below, above);
  const double reach = (gap > 0 ? gap : kMend * gap) / dt;
  const bool is_lower = below < above;
  stop.speed = is_lower ? -reach : reach;
  stop.lower = is_lower ? 0 : -SIMD_INFINITY;
  stop.upper = is_lower ? SIMD_INFINITY : 0;
}

void WorldJoints::before(double dt, const PushedMean& pushed) {
  for (const auto& kept : joints_) {
    kept->rows = rows_of(*kept);
    kept->position = kept->rows.position;
    kept->locks.n = kept->rows.n_locks;
    for (uint32_t i = 0; i < kept->rows.n_locks; ++i) {
      const JointRow& lock = kept->rows.locks[i];
      kept->locks.rows[i] = {.a = lock.a, .b = lock.b, .speed = -kMend / dt * lock.error};
    }
    if (kept->swinging && kept->is_awake()) {
      kept->swinging->before(dt);
      if (kept->swinging->is_free()) kept->locks.n = 0;
    }
    if (!kept->kind().has_coordinate() || !kept->is_awake()) continue;
    if (kept->leads) {
      lead(*kept, dt, pushed);
    } else {
      drive(*kept, dt, pushed);
    }
    kept->drag = dt * kept->mobility * kept->joint.config.damping;
    bound(*kept, dt);
  }
}

void WorldJoints::after(double dt, std::span<const uint8_t> touches) {
  for (const auto& kept : joints_) {
    const JointConfig& config = kept->joint.config;
    if (kept->swinging && kept->is_awake()) {
      kept->swinging->after(kept->rows.anchor_W, touches[config.object] != 0);
    }
    if (kept->kind().has_coordinate() && kept->is_awake()) {
      const double slid = kept->friction.n > 0 ? kept->friction.getAppliedImpulse() : 0;
      const bool stops = kept->stop.n > 0 && kept->stop.getAppliedImpulse() != 0;
      kept->stuck = config.friction > 0 && std::fabs(slid) < kSticks * config.friction * dt;
      kept->stop_steps = stops ? kHeldSteps : std::max(kept->stop_steps - 1, 0);
      if (!kept->leads) {
        kept->others = (kept->speed() - kept->without_others) / (dt * kept->mobility);
      } else {
        const double speed = dot(kept->along, twist_of(kept->a));
        // Bullet moves by the speed at the end of a step; half of what it has gained came too late.
        // What rests or touches is left alone, or it would creep
        kept->is_free = !kept->stuck && !stops && touches[config.object] == 0;
        const double gained = kept->is_free ? kept->smooth + kept->mobility * slid : 0;
        place(*kept, kept->position + dt * (speed - 0.5 * gained), speed);
      }
    }
    kept->rows = rows_of(*kept);
    kept->position = kept->rows.position;
  }
}

/// Puts a body that has a coordinate where it says, within the end stops, which take its speed.
void WorldJoints::place(Kept& kept, double position, double speed) {
  const JointConfig& config = kept.joint.config;
  if (position <= config.lower) speed = std::max(speed, 0.0);
  if (position >= config.upper) speed = std::min(speed, 0.0);
  kept.position = std::clamp(position, config.lower, config.upper);
  kept.a.setCenterOfMassTransform(to_bullet(pose_on(kept.joint, pose_of(kept.b), kept.position)));
  kept.rows = rows_of(kept);
  set_twist(kept.a, speed * kept.motion());
}

WorldJoints::Kept* WorldJoints::leading(uint32_t object) const {
  const auto found = std::ranges::find_if(joints_, [&](const auto& kept) {
    return (kept->leads || kept->swinging) && kept->joint.config.object == object;
  });
  if (found == joints_.end()) return nullptr;
  (*found)->rows = rows_of(**found);
  return found->get();
}

bool WorldJoints::push(uint32_t object, const Wrench& impulse_W) {
  Kept* const kept = leading(object);
  if (kept == nullptr || !kept->leads) return false;
  const double gained = kept->lead_mobility() * dot(impulse_W, kept->motion());
  set_twist(kept->a, twist_of(kept->a) + gained * kept->motion());
  return true;
}

bool WorldJoints::shift(uint32_t object, const Twist& displacement_W) {
  Kept* const kept = leading(object);
  if (kept == nullptr) return false;
  if (kept->swinging) {
    if (kept->swinging->is_free()) kept->swinging->shift(kept->rows.anchor_W, displacement_W);
    return kept->swinging->is_free();
  }
  const double mobility = kept->lead_mobility();
  const double speed = mobility * dot(momentum_of(kept->a, twist_of(kept->a)), kept->motion());
  const double way = mobility * dot(momentum_of(kept->a, displacement_W), kept->motion());
  place(*kept, kept->rows.position + way, speed);
  return true;
}

JointState WorldJoints::state(size_t joint) const {
  Kept& kept = *joints_[joint];
  kept.rows = rows_of(kept);
  return {kept.rows.position, kept.speed()};
}

void WorldJoints::resume(size_t joint, double position) {
  joints_[joint]->position = position;
  joints_[joint]->rows = rows_of(*joints_[joint]);
  joints_[joint]->position = joints_[joint]->rows.position;
}

JointEffect WorldJoints::effect(uint32_t object) const {
  JointEffect effect;
  const btRigidBody* const body = bodies_[object].get();
  for (const auto& kept : joints_) {
    if (kept->swinging && &kept->a == body) effect.moves_by_mean = kept->swinging->is_free();
    if ((&kept->a != body && &kept->b != body) || !kept->kind().has_coordinate()) continue;
    const JointConfig& config = kept->joint.config;
    const double speed = kept->speed();
    const double weight = kept->leads ? weight_at(*kept, kept->rows.position) : kept->weight;
    double load = load_at(kept->joint, kept->rows.position).load + weight;
    if (!kept->stuck && speed != 0) load -= std::copysign(config.friction, speed);
    // of the next step, whose damper acts by the speed that it ends with, if hand and others go on
    const double hand = kept->pushed_load + kept->others;
    const double drag = config.damping * (speed + kept->pushed_speed);
    load = (load + hand - drag) / (1 + kept->drag) - hand - weight;
    const Twist& row = &kept->a == body ? kept->rows.along.a : kept->rows.along.b;
    effect.load_W = effect.load_W + Wrench{load * row.v, load * row.w};
    if (!kept->leads || &kept->a != body) continue;
    effect.moves_by_mean = kept->is_free;
    const Vec3 arm_W = pose_of(kept->a).p - kept->rows.anchor_W;
    const Vec3& axis_W = kept->rows.axis_W;
    effect.bias_W.v +=
        speed * speed *
        (kept->kind().turns() ? cross(axis_W, cross(axis_W, arm_W)) : kept->rows.curvature_W);
  }
  return effect;
}

namespace {

/// Of a joint's row what moves.
ConstraintRow constraint_of(const JointRow& row, const btRigidBody& a, const btRigidBody& b) {
  ConstraintRow out;
  if (is_mobile(a)) {
    out.a = static_cast<uint32_t>(a.getUserIndex());
    out.row_a = row.a;
  }
  if (!is_mobile(b)) return out;
  out.b = static_cast<uint32_t>(b.getUserIndex());
  out.row_b = row.b;
  return out;
}

}  // namespace

void WorldJoints::add_held(std::vector<ConstraintRow>& rows) const {
  for (const auto& kept : joints_) {
    if (kept->is_held()) rows.push_back(constraint_of(kept->rows.along, kept->a, kept->b));
  }
}

void WorldJoints::add_locks(std::vector<ConstraintRow>& rows) const {
  for (const auto& kept : joints_) {
    for (uint32_t i = 0; i < kept->rows.n_locks; ++i) {
      rows.push_back(constraint_of(kept->rows.locks[i], kept->a, kept->b));
    }
  }
}

}  // namespace haptic
