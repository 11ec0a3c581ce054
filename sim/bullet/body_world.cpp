// SPDX-License-Identifier: GPL-3.0-or-later
#include "sim/bullet/body_world.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <optional>

#include "proto/math/assert.h"
#include "sim/bullet/body_state.h"
#include "sim/bullet/collision_shape.h"
#include "sim/bullet/world_joints.h"

namespace haptic {
namespace {

constexpr int kIterations = 50;       // of the solver, at most: ten boxes on each other stand
constexpr double kResidual = 0.3e-3;  // change of a speed after which it iterates no more [m/s]
// Bullet's 20 mm and 50 mm are for scenes of metres: all that lies nearer than them to each other
// is one island, which only falls asleep, and wakes, as a whole [m]
constexpr double kNear = 5e-3;    // of bodies between which contacts are looked for
constexpr double kMargin = 1e-3;  // by which the boxes of the broad phase are larger
constexpr double kSlop = 10e-6;   // depth of a contact that is left alone [m]
// A deeper contact is mended without giving speed. Shallower ones are mended by their impulses: the
// other way lets a stack of ten boxes creep by 1.5 mm a second [m]
constexpr double kDeep = 0.1e-3;
constexpr double kBounceSpeed = 0.02;  // slower impacts do not bounce [m/s]
// slower bodies that touch something fall asleep after two seconds (Bullet's): a millimetre in that
// time, a twentieth of our boxes
constexpr double kSleepSpeed = 0.5e-3;  // [m/s]
constexpr double kSleepTurning = 0.02;  // [rad/s]
constexpr double kDiagonal = 1e-9;      // products of inertia over the trace that are rounding

/// The axes of a body's centre of mass in O: principal ones, those of O where they are principal.
struct PrincipalAxes {
  Pose X_OC;
  Vec3 moments;
};

PrincipalAxes principal_axes(const BodyMass& mass) {
  if (mass.mass == 0) return {};
  const Mat3& I = mass.inertia_O;
  const double trace = I.row[0].x + I.row[1].y + I.row[2].z;
  const double most =
      std::max({std::fabs(I.row[0].y), std::fabs(I.row[0].z), std::fabs(I.row[1].z)});
  if (most <= kDiagonal * trace) {
    return {{mass.centre_O, {}}, {I.row[0].x, I.row[1].y, I.row[2].z}};
  }
  Eigen::Matrix3d matrix;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) matrix(i, j) = I.row[i][j];
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(matrix);
  Eigen::Matrix3d axes = solver.eigenvectors();
  if (axes.determinant() < 0) axes.col(0) *= -1;
  const Eigen::Quaterniond q(axes);
  const Eigen::Vector3d moments = solver.eigenvalues();
  return {{mass.centre_O, normalized(Quat{q.x(), q.y(), q.z(), q.w()})},
          {moments.x(), moments.y(), moments.z()}};
}

bool is_held(const btManifoldPoint& point) {
  return reinterpret_cast<intptr_t>(point.m_userPersistentData) > 0;
}

/// Counts down the steps in which a contact without impulse goes on holding.
void note_impulse(btManifoldPoint& point) {
  auto steps = reinterpret_cast<intptr_t>(point.m_userPersistentData);
  steps = point.m_appliedImpulse > 0 ? intptr_t{kHeldSteps} : std::max<intptr_t>(steps - 1, 0);
  point.m_userPersistentData = reinterpret_cast<void*>(steps);
}

}  // namespace

struct BodyWorld::Parts {
  explicit Parts(const WorldModel& model);
  ~Parts();
  uint32_t object_of(const btCollisionObject* body) const {
    return static_cast<uint32_t>(body->getUserIndex());
  }
  bool is_mobile(const btCollisionObject* body) const { return !body->isStaticOrKinematicObject(); }
  void find_contacts();
  void find_rows(double dt);
  void note_push(const btManifoldPoint& point, const btRigidBody& a, const btRigidBody& b);
  void add_row(const btManifoldPoint& point, const btVector3& direction, const btRigidBody& a,
               const btRigidBody& b);

  btDefaultCollisionConfiguration configuration;
  btCollisionDispatcher dispatcher{&configuration};
  btDbvtBroadphase broadphase;
  btSequentialImpulseConstraintSolver solver;
  btDiscreteDynamicsWorld world{&dispatcher, &broadphase, &solver, &configuration};
  std::vector<Pose> X_OC;    // of each object
  std::vector<Pose> placed;  // last
  std::vector<OwnedShape> shapes;
  std::vector<std::unique_ptr<btRigidBody>> bodies;
  std::vector<uint8_t> touches;  // each object
  PushedMean pushed;
  std::vector<Wrench> by_bodies;  // on each object without mass, since it was taken
  std::optional<WorldJoints> joints;
  std::vector<ConstraintRow> rows;
  size_t n_contacts = 0;
};

BodyWorld::Parts::Parts(const WorldModel& model) {
  gContactBreakingThreshold = kNear;
  gDbvtMargin = kMargin;
  world.setGravity(to_bullet(model.gravity_W));
  btContactSolverInfo& info = world.getSolverInfo();
  info.m_numIterations = kIterations;
  info.m_solverMode = SOLVER_USE_WARMSTARTING | SOLVER_SIMD | SOLVER_USE_2_FRICTION_DIRECTIONS;
  info.m_splitImpulse = 1;
  info.m_splitImpulsePenetrationThreshold = -kDeep;
  info.m_linearSlop = kSlop;
  info.m_leastSquaresResidualThreshold = kResidual * kResidual;
  info.m_restitutionVelocityThreshold = kBounceSpeed;
  for (const WorldObject& object : model.objects) {
    const PrincipalAxes axes = principal_axes(object.mass);
    X_OC.push_back(axes.X_OC);
    placed.push_back(object.X_WO);
    shapes.push_back(make_shape(object, axes.X_OC));
    const btRigidBody::btRigidBodyConstructionInfo made(
        object.mass.mass, nullptr, shapes.back().whole(), to_bullet(axes.moments));
    auto body = std::make_unique<btRigidBody>(made);
    body->setUserIndex(static_cast<int>(bodies.size()));
    // Bullet multiplies the two coefficients
    body->setFriction(std::sqrt(object.friction));
    body->setRestitution(std::sqrt(object.restitution));
    body->setDamping(0, 0);
    body->setSleepingThresholds(kSleepSpeed, kSleepTurning);
    body->setWorldTransform(to_bullet(object.X_WO * axes.X_OC));
    body->setInterpolationWorldTransform(body->getWorldTransform());
    if (object.mass.mass == 0) {
      body->setCollisionFlags(body->getCollisionFlags() | btCollisionObject::CF_KINEMATIC_OBJECT);
    }
    world.addRigidBody(body.get());
    bodies.push_back(std::move(body));
  }
  touches.assign(bodies.size(), 0);
  by_bodies.resize(bodies.size());
  pushed.impulse_W.resize(bodies.size());
  pushed.late_W.resize(bodies.size());
  std::vector<uint8_t> never_moves;
  for (const WorldObject& object : model.objects) never_moves.push_back(object.never_moves ? 1 : 0);
  joints.emplace(model.joints, bodies, never_moves, model.gravity_W, world);
  joints->add_held(rows);
  joints->add_locks(rows);
}

BodyWorld::Parts::~Parts() {
  joints.reset();
  for (const auto& body : bodies) world.removeRigidBody(body.get());
}

void BodyWorld::Parts::add_row(const btManifoldPoint& point, const btVector3& direction,
                               const btRigidBody& a, const btRigidBody& b) {
  ConstraintRow row;
  const auto side = [&](const btRigidBody& body, const btVector3& at, double sign) {
    const Vec3 d_W = sign * from_bullet(direction);
    return Twist{d_W, cross(from_bullet(at - body.getCenterOfMassPosition()), d_W)};
  };
  if (is_mobile(&a)) {
    row.a = object_of(&a);
    row.row_a = side(a, point.getPositionWorldOnA(), 1);
  }
  if (is_mobile(&b)) {
    row.b = object_of(&b);
    row.row_b = side(b, point.getPositionWorldOnB(), -1);
  }
  rows.push_back(row);
}

/// Counts what a contact has pushed an object without mass with; of two that sleep it is that of
/// the step in which they fell asleep, and still true.
void BodyWorld::Parts::note_push(const btManifoldPoint& point, const btRigidBody& a,
                                 const btRigidBody& b) {
  if (is_mobile(&a) == is_mobile(&b) || point.m_appliedImpulse == 0) return;
  const btVector3 on_a = point.m_appliedImpulse * point.m_normalWorldOnB +
                         point.m_appliedImpulseLateral1 * point.m_lateralFrictionDir1 +
                         point.m_appliedImpulseLateral2 * point.m_lateralFrictionDir2;
  const bool is_a = !is_mobile(&a);
  const btRigidBody& still = is_a ? a : b;
  const btVector3& at = is_a ? point.getPositionWorldOnA() : point.getPositionWorldOnB();
  const Vec3 J_W = (is_a ? 1 : -1) * from_bullet(on_a);
  Wrench& sum_W = by_bodies[object_of(&still)];
  sum_W = sum_W + Wrench{J_W, cross(from_bullet(at - still.getCenterOfMassPosition()), J_W)};
}

void BodyWorld::Parts::find_contacts() {
  rows.clear();
  n_contacts = 0;
  for (int m = 0; m < dispatcher.getNumManifolds(); ++m) {
    btPersistentManifold& manifold = *dispatcher.getManifoldByIndexInternal(m);
    const btRigidBody& a = *btRigidBody::upcast(manifold.getBody0());
    const btRigidBody& b = *btRigidBody::upcast(manifold.getBody1());
    for (int i = 0; i < manifold.getNumContacts(); ++i) {
      btManifoldPoint& point = manifold.getContactPoint(i);
      ++n_contacts;
      // an impulse that is kept while both sleep was carried when they fell asleep
      if (a.isActive() || b.isActive()) note_impulse(point);
      note_push(point, a, b);
      if (!is_held(point)) continue;
      add_row(point, point.m_normalWorldOnB, a, b);
      const double most = kSticks * point.m_combinedFriction * point.m_appliedImpulse;
      if (std::fabs(point.m_appliedImpulseLateral1) >= most) continue;
      if (std::fabs(point.m_appliedImpulseLateral2) >= most) continue;
      add_row(point, point.m_lateralFrictionDir1, a, b);
      add_row(point, point.m_lateralFrictionDir2, a, b);
    }
  }
}

/// Contacts, then joints, which put their bodies where they belong. A body that neither holds goes
/// on for ever, however slow it is.
void BodyWorld::Parts::find_rows(double dt) {
  find_contacts();
  const auto note = [&] {
    std::fill(touches.begin(), touches.end(), 0);
    for (const ConstraintRow& row : rows) {
      if (row.a != kNoMass) touches[row.a] = 1;
      if (row.b != kNoMass) touches[row.b] = 1;
    }
  };
  note();
  joints->after(dt, touches);
  joints->add_held(rows);
  note();
  for (size_t i = 0; i < bodies.size(); ++i) {
    if (touches[i] == 0) bodies[i]->setDeactivationTime(0);
  }
  joints->add_locks(rows);
}

BodyWorld::BodyWorld(const WorldModel& model) : parts_(std::make_unique<Parts>(model)) {}
BodyWorld::~BodyWorld() = default;
BodyWorld::BodyWorld(BodyWorld&&) noexcept = default;
BodyWorld& BodyWorld::operator=(BodyWorld&&) noexcept = default;

void BodyWorld::place(uint32_t object, const Pose& X_WO, const Twist& V_WO) {
  HAPTIC_ASSERT(object < parts_->bodies.size());
  btRigidBody& body = *parts_->bodies[object];
  const Pose X_WC = X_WO * parts_->X_OC[object];
  if (body.isKinematicObject()) {
    // one that moves keeps its neighbours awake
    const bool is_still = X_WO == parts_->placed[object];
    parts_->placed[object] = X_WO;
    body.setWorldTransform(to_bullet(X_WC));
    body.forceActivationState(is_still ? ISLAND_SLEEPING : DISABLE_DEACTIVATION);
    if (!is_still) return;
    body.setInterpolationWorldTransform(body.getWorldTransform());
    body.setLinearVelocity({0, 0, 0});
    body.setAngularVelocity({0, 0, 0});
    return;
  }
  body.setCenterOfMassTransform(to_bullet(X_WC));
  body.setLinearVelocity(to_bullet(velocity_at(V_WO, X_WC.p - X_WO.p)));
  body.setAngularVelocity(to_bullet(V_WO.w));
}

void BodyWorld::push(uint32_t object, const Wrench& impulse_W, const Wrench& late_W) {
  btRigidBody& body = *parts_->bodies[object];
  HAPTIC_ASSERT(!body.isKinematicObject());
  if (body.isStaticObject()) return;  // frozen
  const Vec3 origin_W =
      from_bullet(body.getCenterOfMassTransform()) * inverse(parts_->X_OC[object]).p;
  const Vec3 arm_W = origin_W - from_bullet(body.getCenterOfMassPosition());
  const Wrench at_centre_W = haptic::shift(impulse_W, arm_W);
  parts_->pushed.impulse_W[object] = at_centre_W;
  parts_->pushed.late_W[object] = haptic::shift(late_W, arm_W);
  body.activate(true);
  if (parts_->joints->push(object, at_centre_W)) return;
  body.applyCentralImpulse(to_bullet(at_centre_W.f));
  body.applyTorqueImpulse(to_bullet(at_centre_W.t));
}

void BodyWorld::shift(uint32_t object, const Twist& displacement_W) {
  btRigidBody& body = *parts_->bodies[object];
  const Pose& X_OC = parts_->X_OC[object];
  const Pose X_WO = pose_of(body) * inverse(X_OC);
  const Vec3 arm_W = pose_of(body).p - X_WO.p;
  const Twist of_centre{velocity_at(displacement_W, arm_W), displacement_W.w};
  if (parts_->joints->shift(object, of_centre)) return;
  body.setCenterOfMassTransform(to_bullet(extrapolate(X_WO, displacement_W, 1) * X_OC));
}

void BodyWorld::freeze(uint32_t object) {
  btRigidBody& body = *parts_->bodies[object];
  body.setLinearVelocity({0, 0, 0});
  body.setAngularVelocity({0, 0, 0});
  // to others it is a wall from now on
  body.setMassProps(0, {0, 0, 0});
  body.updateInertiaTensor();
  body.setCollisionFlags(body.getCollisionFlags() | btCollisionObject::CF_STATIC_OBJECT);
  body.forceActivationState(DISABLE_SIMULATION);
}

void BodyWorld::step(double dt) {
  HAPTIC_ASSERT(dt > 0);
  parts_->joints->before(dt, parts_->pushed);
  std::ranges::fill(parts_->pushed.impulse_W, Wrench{});
  std::ranges::fill(parts_->pushed.late_W, Wrench{});
  parts_->world.stepSimulation(dt, 0, dt);
  parts_->find_rows(dt);
}

MovingBody BodyWorld::motion(uint32_t object) const {
  HAPTIC_ASSERT(object < parts_->bodies.size());
  const btRigidBody& body = *parts_->bodies[object];
  MovingBody motion;
  const Pose X_WC = from_bullet(body.getCenterOfMassTransform());
  motion.X_WO = X_WC * inverse(parts_->X_OC[object]);
  motion.centre_W = X_WC.p;
  motion.V_WO.w = from_bullet(body.getAngularVelocity());
  motion.V_WO.v =
      velocity_at({from_bullet(body.getLinearVelocity()), motion.V_WO.w}, motion.X_WO.p - X_WC.p);
  motion.asleep = !body.isActive();
  motion.inertia_W = inertia_of(body);
  const JointEffect effect = parts_->joints->effect(object);
  motion.joints_W = effect.load_W;
  motion.bias_W = effect.bias_W;
  motion.moves_by_mean = effect.moves_by_mean;
  return motion;
}

Wrench BodyWorld::take_pushed_by_bodies(uint32_t object) {
  return std::exchange(parts_->by_bodies[object], Wrench{});
}

std::span<const ConstraintRow> BodyWorld::rows() const {
  return parts_->rows;
}

JointState BodyWorld::joint(size_t joint) const {
  return parts_->joints->state(joint);
}

void BodyWorld::resume_joint(size_t joint, double position) {
  parts_->joints->resume(joint, position);
}

size_t BodyWorld::n_contacts() const {
  return parts_->n_contacts;
}

}  // namespace haptic
