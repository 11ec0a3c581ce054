// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/step.h"

#include <algorithm>

#include "contact/detect/nearest_surface.h"
#include "contact/query/triangle/plane_extent.h"
#include "contact/query/triangle/shading_normal.h"
#include "proto/wire/renderer.h"
#include "proto/wire/scene_pose.h"

namespace haptic {
namespace {

constexpr double kRelativeEpsilon = 1e-10;  // of the largest object: 10⁵ times its rounding
constexpr double kMinReach = 0.2e-3;        // look-ahead of a resting hand [m]
constexpr double kMaxReach = 20e-3;         // bound of the look-ahead's cost [m]
constexpr double kPeriodSmoothing = 0.1;    // weight of the newest interval
constexpr double kMaxPeriod = 0.1;          // longer intervals are pauses, not a rate [s]

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

/// The same place for another renderer, whose proxy may need more room.
uint32_t seed_again(const PointScene& scene, const ServoFrame& servo, PointProxy& proxy) {
  const uint32_t flags = seed_proxy(scene, proxy.seeded ? proxy.g_W : servo.X_WT.p, proxy);
  return flags | kContactReseeded;
}

/// Shading is for the virtual proxy.
double crease_cosine(const ContactModel& model, const ContactSet& set, uint32_t object) {
  const bool shades = set.renderer == static_cast<uint32_t>(Renderer::kVirtualProxy3);
  return shades ? model.crease_cosine[object] : 1;
}

/// What touches or may touch: where on which facet.
struct Touch {
  uint32_t object;
  uint32_t triangle;
  Feature feature;
  Vec3 point_O;
  Vec3 normal_O;
};

Contact make_contact(const PointScene& scene, const Touch& touch, double crease_cosine) {
  const TriangleMesh& mesh = scene.shapes[touch.object].mesh;
  Contact c{};
  c.tool_point_T = -scene.radius * touch.normal_O;
  c.object_point_O = touch.point_O;
  c.normal_O = touch.normal_O;
  c.shading_normal_O = crease_cosine < 1
                           ? shading_normal(mesh, touch.triangle, touch.point_O, crease_cosine)
                           : touch.normal_O;
  c.extent = plane_extent(mesh, touch.triangle, touch.point_O);
  c.object = c.material = touch.object;
  c.feature = touch.feature.id();
  return c;
}

/// Across the way from where the slide was cut short to the tool: the proxy stays where it is for
/// this tick, which is sticky, but never a hole.
void add_hold(const PointScene& scene, const PointProxy& proxy, const ProxyMove& move,
              const Vec3& p_W, ContactSet& set) {
  const auto [object, triangle] = move.active[0];
  const Pose X_OW = inverse(scene.X_WO[object]);
  const Vec3 across_O = rotate(X_OW.q, normalized(proxy.g_W - p_W));
  // the proxy's own place, less the stand-off of a sphere that the servo adds
  const Vec3 point_O = X_OW * proxy.g_W - scene.radius * across_O;
  const Feature face{FeatureKind::kFace, triangle};
  set.contacts[set.n_contacts++] =
      make_contact(scene, {object, triangle, face, point_O, across_O}, 1);
  set.n_active = set.n_contacts;
}

void add_active(const ContactModel& model, const PointScene& scene, const PointProxy& proxy,
                const ProxyMove& move, ContactSet& set) {
  for (uint32_t i = 0; i < move.n_active; ++i) {
    const ProxyPlane& plane = move.active[i];
    // on the facet itself: the force is taken from the un-offset proxy
    const auto [feature, point_O, normal_O] = support_of(scene, plane, proxy.g_W);
    set.contacts[set.n_contacts++] =
        make_contact(scene, {plane.object, plane.triangle, feature, point_O, normal_O},
                     crease_cosine(model, set, plane.object));
  }
  set.n_active = set.n_contacts;
}

bool is_reported(const ContactSet& set, uint32_t object, const Feature& feature) {
  return std::any_of(
      set.contacts.begin(), set.contacts.begin() + set.n_contacts,
      [&](const Contact& c) { return c.object == object && c.feature == feature.id(); });
}

void add_approaching(const ContactModel& model, const PointScene& scene, const PointProxy& proxy,
                     double reach, ContactState& state, ContactSet& set) {
  for (uint32_t i = 0; i < scene.shapes.size(); ++i) {
    const Vec3 g_O = inverse(scene.X_WO[i]) * proxy.g_W;
    NearResult near =
        near_features(scene.shapes[i], g_O, scene.radius + reach, state.scratch, state.features);
    if (near.truncated || near.left_out > 0) set.flags |= kContactTruncated;
    // a large sphere over small facets: what is nearest counts more than what is far
    for (double less = reach; near.truncated && less > kMinReach / 8;) {
      less /= 2;
      near =
          near_features(scene.shapes[i], g_O, scene.radius + less, state.scratch, state.features);
    }
    for (size_t k = 0; k < near.count; ++k) {
      const auto& [closest, normal_O] = state.features[k];
      if (is_reported(set, i, closest.feature)) continue;
      if (set.n_contacts == kMaxContacts) {
        set.flags |= kContactTruncated;
        return;
      }
      set.contacts[set.n_contacts++] =
          make_contact(scene, {i, closest.triangle, closest.feature, closest.point_O, normal_O},
                       crease_cosine(model, set, i));
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
  // a body's rim may be faster than its hand, and its proxy than both
  if (is_of_body(state.renderer)) {
    const double rim = norm(model.bodies.body.centre_T) + model.bodies.body.radius;
    speed =
        std::max(speed + rim * norm(servo.V_WT.w), norm(servo.V_WP.v) + rim * norm(servo.V_WP.w));
  }
  double scene_speed = 0;
  if (scene != nullptr) {
    for (uint32_t i = 0; i < scene->n_objects; ++i) {
      const Vec3 v_W = surface_velocity(*scene, i, scene->X_WO[i], servo.X_WT.p, servo.t_ns);
      scene_speed = std::max(scene_speed, norm(v_W));
    }
  }
  speed += scene_speed;
  const double least = is_of_body(state.renderer) ? kLeastBodyReach : kMinReach;
  return std::clamp(speed * (2 * state.period + model.servo_period), least, kMaxReach);
}

/// The penalty method: the nearest surfaces of where the tool is now.
void answer_stateless(const PointScene& scene, const ServoFrame& servo, double reach,
                      ContactState& state, ContactSet& set) {
  std::array<NearestSurface, kMaxObjects> surfaces;
  const size_t count = nearest_surfaces(scene, servo.X_WT.p, reach, surfaces);
  for (size_t i = 0; i < count; ++i) {
    const auto& [object, triangle, feature, point_O, normal_O, depth] = surfaces[i];
    set.contacts[set.n_contacts++] =
        make_contact(scene, {object, triangle, feature, point_O, normal_O}, 1);
    set.n_active += depth > 0;
  }
  state.proxy.seeded = false;
  state.proxy.g_W = servo.X_WT.p;
  // no proxy is kept: the free place next to the tool stands for it
  if (set.n_active > 0) {
    const NearestSurface& deepest = surfaces[0];
    state.proxy.g_W =
        scene.X_WO[deepest.object] * (deepest.point_O + scene.epsilon * deepest.normal_O);
  }
  set.free_fraction = 1;
}

/// What will carry a proxy that goes on to p_W, where the tool will be when the answer is used, and
/// what it may reach.
void add_contacts(const ContactModel& model, const PointScene& then, const Vec3& p_W, double reach,
                  ContactState& state, ContactSet& set) {
  // it goes ahead and is put back; what its queries found serves the next step as well
  PointProxy& proxy = state.proxy;
  const ProxyPlace verified = proxy;
  const ProxyMove move = move_proxy(then, p_W, proxy);
  set.flags |= move.flags & (kContactIterationLimit | kContactTruncated);
  if ((move.flags & kContactIterationLimit) != 0 && move.n_active > 0) {
    add_hold(then, proxy, move, p_W, set);
  } else {
    add_active(model, then, proxy, move, set);
  }
  add_approaching(model, then, proxy, reach, state, set);
  static_cast<ProxyPlace&>(proxy) = verified;
}

/// A tool with six degrees of freedom, where the servo has its proxy.
void answer_with_body(const ContactModel& model, const PointScene& scene, const ServoFrame& servo,
                      const SceneFrame* frame, double reach, ContactState& state, ContactSet& set) {
  VoxelQuestion question;
  question.X_WT = servo.X_WP;
  question.V_WT = servo.V_WP;
  question.X_WO = scene.X_WO;
  question.reach = reach;
  for (uint32_t i = 0; frame != nullptr && i < std::min(model.n_objects, frame->n_objects); ++i) {
    question.V_WO[i] = object_twist_at(*frame, i, servo.t_ns);
  }
  set.X_WT = servo.X_WP;
  set.X_WG = servo.X_WP;
  if (!detect_bodies(model.bodies, scene.shapes, state.renderer, state.bodies, question, servo.X_WT,
                     set)) {
    set.flags |= kContactNoDetector | kContactNoFreePose;
  }
  // it keeps no proxy: that is the servo's
  state.proxy.seeded = false;
  state.proxy.g_W = set.X_WG.p;
  set.free_fraction = 1;
}

RigidToolModel rigid_model(const ContactModel& model) {
  return {{model.shapes.data(), model.n_objects},
          model.bodies.tool,
          model.bodies.body,
          model.rigid,
          model.crease_cosine,
          model.has_friction};
}

/// A tool with six degrees of freedom that never enters an object.
void answer_with_rigid(const ContactModel& model, const PointScene& scene, const ServoFrame& servo,
                       double reach, ContactState& state, ContactSet& set) {
  state.proxy.seeded = false;
  set.X_WG = servo.X_WP;
  if (!state.rigid) {
    set.flags |= kContactNoDetector | kContactNoFreePose;
    return;
  }
  state.rigid->answer(rigid_model(model), servo, {scene.X_WO.data(), model.n_objects}, reach, set);
}

struct ProxyAsk {
  PointScene then;  // when the answer is used
  double reach;     // of the look-ahead [m]
  bool reseed;      // the renderer is another one than in the last answer
};

/// The hard renderers: a proxy that is never inside.
void answer_with_proxy(const ContactModel& model, const PointScene& scene, const ServoFrame& servo,
                       const ProxyAsk& ask, ContactState& state, ContactSet& set) {
  // nothing is felt: the hand may pass through objects, and begins where it then is
  if ((servo.flags & kServoClosed) != 0) state.proxy.seeded = false;
  if (ask.reseed) {
    set.flags |= seed_again(scene, servo, state.proxy);
  } else if (!state.proxy.seeded) {
    set.flags |= seed(scene, servo, state.proxy);
  }
  if (!state.proxy.seeded) return;
  const Vec3 goal_W = servo.X_WT.p + servo.held_back_W;
  const ProxyMove move = move_proxy(scene, goal_W, state.proxy);
  set.flags |= move.flags;
  set.free_fraction = move.free_fraction;
  add_contacts(model, ask.then, goal_W + model.prediction * servo.V_WT.v, ask.reach, state, set);
}

}  // namespace

ContactModel build_contact_model(const SessionConfig& config, const ContactShapes& shapes) {
  ContactModel model;
  model.n_objects = config.n_objects;
  model.servo_period = model.prediction = 1 / config.servo_rate;
  model.radius = config.proxy_radius;
  double largest = 0;
  for (uint32_t i = 0; i < config.n_objects; ++i) {
    model.shapes[i] = shapes.objects[i];
    model.X_WO[i] = config.objects[i].X_WO;
    const MaterialConfig& material = config.objects[i].material;
    model.crease_cosine[i] = std::cos(material.crease_angle);
    model.has_friction |= material.friction_static > 0 || material.friction_dynamic > 0;
    largest = std::max(largest, norm(model.shapes[i].mesh.upper - model.shapes[i].mesh.lower));
  }
  model.epsilon = kRelativeEpsilon * largest;
  model.bodies = build_body_model(config, shapes.bodies, shapes.objects);
  model.rigid = god_object_options(config, model.bodies.body);
  return model;
}

ContactState::ContactState(const ContactModel& model) : bodies(model.bodies) {
  if (model.bodies.has_tool()) rigid.emplace(rigid_model(model));
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

  PointScene now = scene_now(model, scene, servo.t_ns);
  set.X_WO = now.X_WO;
  bool usable = is_finite(servo.X_WT) && is_finite(servo.held_back_W) && is_finite(servo.X_WP) &&
                is_finite(servo.V_WP);
  for (uint32_t i = 0; i < model.n_objects; ++i) usable &= is_finite(now.X_WO[i]);
  if (!usable) set.flags |= kContactNoFreePose;

  const auto renderer =
      is_renderer(servo.renderer) ? static_cast<Renderer>(servo.renderer) : state.renderer;
  const bool changed = renderer != state.renderer && state.seq > 1;
  state.renderer = renderer;
  if (changed && state.rigid) state.rigid->lose();
  set.renderer = static_cast<uint32_t>(renderer);
  now.radius = renderer == Renderer::kVirtualProxy3 ? model.radius : 0;
  const double reach = look_ahead(model, state, servo, scene);
  if (usable && renderer == Renderer::kPenalty3) {
    if (changed) set.flags |= kContactReseeded;
    answer_stateless(now, servo, reach, state, set);
  } else if (usable && is_rigid(renderer)) {
    if (changed) set.flags |= kContactReseeded;
    answer_with_rigid(model, now, servo, reach, state, set);
  } else if (usable && is_of_body(renderer)) {
    if (changed) set.flags |= kContactReseeded;
    answer_with_body(model, now, servo, scene, reach, state, set);
  } else if (usable) {
    const auto ahead_ns = static_cast<int64_t>(model.prediction * 1e9);
    PointScene then = scene_now(model, scene, servo.t_ns + ahead_ns);
    then.radius = now.radius;
    answer_with_proxy(model, now, servo, {then, reach, changed}, state, set);
  }
  if (!is_of_body(renderer)) {
    set.X_WG = {state.proxy.g_W, servo.X_WT.q};
  } else if (!usable && is_finite(servo.X_WT)) {
    set.X_WG = servo.X_WT;
  }
  // crushed between objects, or nowhere to start: seed anew next time
  if ((set.flags & kContactNoFreePose) != 0) {
    state.proxy.seeded = false;
    set.n_contacts = set.n_active = 0;
  }
  if ((set.flags & (kContactReseeded | kContactNoFreePose)) != 0) ++state.reseeds;
  set.reseeds = state.reseeds;
  return set;
}

}  // namespace haptic
