// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/step.h"

#include <algorithm>

#include "contact/query/plane_extent.h"
#include "proto/scene_pose.h"

namespace haptic {
namespace {

constexpr double kRelativeEpsilon = 1e-9;  // of the largest object: 10⁶ times its rounding
constexpr double kMinReach = 0.2e-3;       // look-ahead of a resting hand [m]
constexpr double kMaxReach = 20e-3;        // bound of the look-ahead's cost [m]
constexpr double kPeriodSmoothing = 0.1;   // weight of the newest interval
constexpr double kMaxPeriod = 0.1;         // longer intervals are pauses, not a rate [s]

PointScene scene_now(const ContactModel& model, const SceneFrame* scene, int64_t t_ns) {
  PointScene now;
  now.shapes = {model.shapes.data(), model.n_objects};
  now.X_WO = model.X_WO;
  now.epsilon = model.epsilon;
  if (scene == nullptr) return now;
  for (uint32_t i = 0; i < std::min(model.n_objects, scene->n_objects); ++i) {
    now.X_WO[i] = object_pose_at(*scene, i, t_ns);
  }
  return now;
}

/// A pose the servo still shows as verified and feels, else the tool itself.
uint32_t seed(const PointScene& scene, const ServoFrame& servo, PointProxy& proxy) {
  const bool known = (servo.flags & (kServoNoContactSet | kServoClosed)) == 0;
  if (known && seed_proxy(scene, servo.X_WG.p, proxy) == 0) return 0;
  return seed_proxy(scene, servo.X_WT.p, proxy);
}

Contact make_contact(const PointScene& scene, uint32_t object, uint32_t triangle,
                     const Feature& feature, const Vec3& point_O, const Vec3& normal_O) {
  Contact c{};
  c.object_point_O = point_O;
  c.normal_O = normal_O;
  c.shading_normal_O = normal_O;
  c.extent = plane_extent(scene.shapes[object].mesh, triangle, point_O);
  c.object = object;
  c.feature = feature.id();
  return c;
}

/// Across the way from where the slide was cut short to the tool: the proxy stays where it is for
/// this tick, which is sticky, but never a hole.
void add_hold(const PointScene& scene, const PointProxy& proxy, const ProxyMove& move,
              const Vec3& p_W, ContactSet& set) {
  const auto [object, triangle] = move.active[0];
  const Pose X_OW = inverse(scene.X_WO[object]);
  const Vec3 across_O = rotate(X_OW.q, normalized(proxy.g_W - p_W));
  set.contacts[set.n_contacts++] = make_contact(
      scene, object, triangle, {FeatureKind::kFace, triangle}, X_OW * proxy.g_W, across_O);
  set.n_active = set.n_contacts;
}

void add_active(const PointScene& scene, const PointProxy& proxy, const ProxyMove& move,
                ContactSet& set) {
  for (uint32_t i = 0; i < move.n_active; ++i) {
    const auto [object, triangle] = move.active[i];
    const TriangleMesh& mesh = scene.shapes[object].mesh;
    const Vec3 normal_O = mesh.face_normals[triangle];
    const Vec3 g_O = inverse(scene.X_WO[object]) * proxy.g_W;
    const Vec3 corner_O = mesh.vertices[mesh.triangles[triangle][0]];
    // on the facet's own plane: the force is taken from the un-offset proxy
    const Vec3 point_O = g_O - dot(normal_O, g_O - corner_O) * normal_O;
    set.contacts[set.n_contacts++] =
        make_contact(scene, object, triangle, {FeatureKind::kFace, triangle}, point_O, normal_O);
  }
  set.n_active = set.n_contacts;
}

bool is_reported(const ContactSet& set, uint32_t object, const Feature& feature) {
  return std::any_of(
      set.contacts.begin(), set.contacts.begin() + set.n_contacts,
      [&](const Contact& c) { return c.object == object && c.feature == feature.id(); });
}

void add_approaching(const PointScene& scene, const PointProxy& proxy, double reach,
                     ContactState& state, ContactSet& set) {
  for (uint32_t i = 0; i < scene.shapes.size(); ++i) {
    const Vec3 g_O = inverse(scene.X_WO[i]) * proxy.g_W;
    const NearResult near =
        near_features(scene.shapes[i], g_O, reach, state.scratch, state.features);
    if (near.truncated) set.flags |= kContactTruncated;
    for (size_t k = 0; k < near.count; ++k) {
      const auto& [closest, normal_O] = state.features[k];
      if (is_reported(set, i, closest.feature)) continue;
      if (set.n_contacts == kMaxContacts) {
        set.flags |= kContactTruncated;
        return;
      }
      set.contacts[set.n_contacts++] =
          make_contact(scene, i, closest.triangle, closest.feature, closest.point_O, normal_O);
    }
  }
}

double look_ahead(const ContactModel& model, ContactState& state, const ServoFrame& servo,
                  const SceneFrame* scene) {
  if (state.last_answered_ns != 0) {
    const double interval = static_cast<double>(servo.t_ns - state.last_answered_ns) * 1e-9;
    state.period += kPeriodSmoothing * (std::clamp(interval, 0.0, kMaxPeriod) - state.period);
  }
  state.last_answered_ns = servo.t_ns;
  double speed = norm(servo.V_WT.v);
  double scene_speed = 0;
  if (scene != nullptr) {
    for (uint32_t i = 0; i < scene->n_objects; ++i) {
      const Vec3 v_W = surface_velocity(*scene, i, scene->X_WO[i], servo.X_WT.p, servo.t_ns);
      scene_speed = std::max(scene_speed, norm(v_W));
    }
  }
  speed += scene_speed;
  return std::clamp(speed * (2 * state.period + model.servo_period), kMinReach, kMaxReach);
}

/// What will carry the proxy when the answer is used, and what it may reach.
void add_contacts(const ContactModel& model, ContactState& state, const ServoFrame& servo,
                  const SceneFrame* scene, ContactSet& set) {
  const auto ahead_ns = static_cast<int64_t>(model.prediction * 1e9);
  const PointScene then = scene_now(model, scene, servo.t_ns + ahead_ns);
  const Vec3 p_W = servo.X_WT.p + model.prediction * servo.V_WT.v;
  PointProxy proxy = state.proxy;
  const ProxyMove move = move_proxy(then, p_W, proxy);
  set.flags |= move.flags & (kContactIterationLimit | kContactTruncated);
  if ((move.flags & kContactIterationLimit) != 0 && move.n_active > 0) {
    add_hold(then, proxy, move, p_W, set);
  } else {
    add_active(then, proxy, move, set);
  }
  add_approaching(then, proxy, look_ahead(model, state, servo, scene), state, set);
}

}  // namespace

ContactModel build_contact_model(const SessionConfig& config, std::span<const MeshShape> shapes) {
  ContactModel model;
  model.n_objects = config.n_objects;
  model.servo_period = model.prediction = 1 / config.servo_rate;
  double largest = 0;
  for (uint32_t i = 0; i < config.n_objects; ++i) {
    model.shapes[i] = shapes[i];
    model.X_WO[i] = config.objects[i].X_WO;
    largest = std::max(largest, norm(shapes[i].mesh.upper - shapes[i].mesh.lower));
  }
  model.epsilon = kRelativeEpsilon * largest;
  return model;
}

ContactSet contact_step(const ContactModel& model, ContactState& state, const ServoFrame& servo,
                        const SceneFrame* scene) {
  ContactSet set{};
  set.seq = state.seq++;
  set.answers_tick = servo.tick;
  set.answers_t_ns = servo.t_ns;
  set.X_WT = servo.X_WT;
  set.n_objects = model.n_objects;
  if (scene == nullptr) {
    set.flags |= kContactNoScene;
  } else {
    set.scene_seq = scene->seq;
  }

  const PointScene now = scene_now(model, scene, servo.t_ns);
  set.X_WO = now.X_WO;
  bool usable = is_finite(servo.X_WT);
  for (uint32_t i = 0; i < model.n_objects; ++i) usable &= is_finite(now.X_WO[i]);
  if (!usable) set.flags |= kContactNoFreePose;
  // nothing is felt: the hand may pass through objects, and begins where it then is
  if ((servo.flags & kServoClosed) != 0) state.proxy.seeded = false;
  if (!state.proxy.seeded && usable) set.flags |= seed(now, servo, state.proxy);
  if (state.proxy.seeded && usable) {
    const ProxyMove move = move_proxy(now, servo.X_WT.p, state.proxy);
    set.flags |= move.flags;
    set.free_fraction = move.free_fraction;
    add_contacts(model, state, servo, scene, set);
  }
  // crushed between objects, or nowhere to start: seed anew next time
  if ((set.flags & kContactNoFreePose) != 0) {
    state.proxy.seeded = false;
    set.n_contacts = set.n_active = 0;
  }
  if ((set.flags & (kContactReseeded | kContactNoFreePose)) != 0) ++state.reseeds;
  set.reseeds = state.reseeds;
  set.X_WG = {state.proxy.g_W, servo.X_WT.q};
  return set;
}

}  // namespace haptic
