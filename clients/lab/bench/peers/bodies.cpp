// SPDX-License-Identifier: GPL-3.0-or-later
#include "clients/lab/bench/peers/bodies.h"

#ifdef HAPTICD_BULLET
#include <btBulletDynamicsCommon.h>

namespace haptic {
namespace {

btVector3 vector_of(const Vec3& a) {
  return {a.x, a.y, a.z};
}

class BulletBodies : public BodiesPeer {
 public:
  BulletBodies(const std::vector<PeerBox>& boxes, const Vec3& gravity_W, int iterations) {
    world_.setGravity(vector_of(gravity_W));
    world_.getSolverInfo().m_numIterations = iterations;
    for (const PeerBox& box : boxes) {
      shapes_.push_back(std::make_unique<btBoxShape>(vector_of(0.5 * box.extent)));
      shapes_.back()->setMargin(0.5e-3);  // its own, 40 mm, is larger than the boxes [m]
      btVector3 inertia(0, 0, 0);
      if (box.mass > 0) shapes_.back()->calculateLocalInertia(box.mass, inertia);
      bodies_.push_back(std::make_unique<btRigidBody>(btRigidBody::btRigidBodyConstructionInfo(
          box.mass, nullptr, shapes_.back().get(), inertia)));
      btRigidBody& body = *bodies_.back();
      const Quat& q = box.X_WO.q;
      body.setWorldTransform(btTransform(btQuaternion(q.x, q.y, q.z, q.w), vector_of(box.X_WO.p)));
      body.setFriction(box.friction);
      body.setActivationState(DISABLE_DEACTIVATION);
      world_.addRigidBody(&body);
    }
  }
  ~BulletBodies() override {
    for (const auto& body : bodies_) world_.removeRigidBody(body.get());
  }
  void push(size_t box, const Vec3& impulse_W) override {
    bodies_[box]->applyCentralImpulse(vector_of(impulse_W));
  }
  void step(double dt) override { world_.stepSimulation(dt, 0, dt); }

 private:
  btDefaultCollisionConfiguration configuration_;
  btCollisionDispatcher dispatcher_{&configuration_};
  btDbvtBroadphase broadphase_;
  btSequentialImpulseConstraintSolver solver_;
  btDiscreteDynamicsWorld world_{&dispatcher_, &broadphase_, &solver_, &configuration_};
  std::vector<std::unique_ptr<btBoxShape>> shapes_;
  std::vector<std::unique_ptr<btRigidBody>> bodies_;
};

}  // namespace

std::unique_ptr<BodiesPeer> make_bullet_bodies(const std::vector<PeerBox>& boxes,
                                               const Vec3& gravity_W, int iterations) {
  return std::make_unique<BulletBodies>(boxes, gravity_W, iterations);
}

}  // namespace haptic
#else
namespace haptic {

std::unique_ptr<BodiesPeer> make_bullet_bodies(const std::vector<PeerBox>&, const Vec3&, int) {
  return nullptr;
}

}  // namespace haptic
#endif
