// SPDX-License-Identifier: GPL-3.0-or-later
#include "clients/view/frame.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <limits>

#include "proto/os/json.h"
#include "proto/wire/scene_pose.h"

namespace haptic {
namespace {

static_assert(std::endian::native == std::endian::little && sizeof(double) == 8);

/// Numbers written one after the other.
struct Out {
  double* at;
  template <typename T>
  requires std::is_arithmetic_v<T>
  void put(T number) { *at++ = static_cast<double>(number); }
  void put(const Vec3& v) {
    for (const double x : {v.x, v.y, v.z}) put(x);
  }
  void put(const Pose& X) {
    put(X.p);
    for (const double x : {X.q.w, X.q.x, X.q.y, X.q.z}) put(x);
  }
};

/// A field of a part: its name, how many numbers it has, and what writes them. T: what the part is
/// made of.
template <typename T>
struct FrameField {
  const char* name;
  uint32_t count;
  void (*write)(const T&, Out);
};

double seconds(int64_t ns) {
  return 1e-9 * static_cast<double>(ns);
}

/// That of the world where the scene has no such object.
Pose object_pose(const View& view, uint32_t object) {
  if (!view.has_scene || object >= view.scene.objects.size()) return {};
  return object_pose_at(view.scene, object, view.servo.t_ns, push_of(view.servo, kFirstHand));
}

size_t n_objects(const View& view) {
  return view.has_scene ? view.scene.objects.size() : 0;
}

size_t n_listed(const View& view) {
  return view.has_contacts ? view.contacts.contacts.size() + view.contacts.guides.size() : 0;
}

size_t n_joints(const View& view) {
  return view.has_scene ? view.scene.joints.size() : 0;
}

/// Age of the set that the servo used in its newest tick [s]; NaN: none.
double age_of_set_in_use(const View& view) {
  const bool has = (view.servo.flags & kServoNoContactSet) == 0 && view.tick_period > 0;
  if (!has) return std::numeric_limits<double>::quiet_NaN();
  return view.tick_period * static_cast<double>(view.servo.tick - view.servo.contact_tick);
}

#define FIELD(name, count, ...)                                               \
  {                                                                           \
    name, count, []([[maybe_unused]] const View& v, Out out) { __VA_ARGS__; } \
  }
constexpr FrameField<View> kFixed[] = {
    FIELD("sequence", 1, out.put(0)),
    FIELD("column", 1, out.put(0)),
    FIELD("tick", 1, out.put(v.servo.tick)),
    FIELD("time", 1, out.put(seconds(v.servo.t_ns))),
    FIELD("realtime", 1, out.put(seconds(v.servo.realtime_ns))),
    FIELD("tool", 7, out.put(v.servo.X_WT)),
    FIELD("proxy", 7, out.put(v.servo.X_WP)),
    FIELD("verified", 7, out.put(v.servo.X_WG)),
    FIELD("handle", 7, out.put(v.servo.device.X_BH)),
    FIELD("velocity", 6, out.put(v.servo.V_WT.v); out.put(v.servo.V_WT.w)),
    FIELD("force", 3, out.put(rotate(v.X_WB.q, v.servo.F_device_B.f))),
    FIELD("torque", 3, out.put(rotate(v.X_WB.q, v.servo.F_device_B.t))),
    FIELD("coupling_force", 3, out.put(v.servo.F_coupling_W.f)),
    FIELD("coupling_torque", 3, out.put(v.servo.F_coupling_W.t)),
    FIELD("depth", 1, out.put(v.servo.depth)),
    FIELD("fade", 1, out.put(v.servo.fade)),
    FIELD("flags", 1, out.put(v.servo.flags)),
    FIELD("fault", 1, out.put(v.servo.fault)),
    FIELD("renderer", 1, out.put(v.servo.renderer)),
    FIELD("solver", 1, out.put(solver_of(v))),
    FIELD("skipped", 1, out.put(v.servo.skipped)),
    FIELD("wake_late", 1, out.put(seconds(v.servo.wake_late_ns))),
    FIELD("busy", 1, out.put(seconds(v.servo.busy_ns))),
    FIELD("n_pushing", 1, out.put(v.servo.n_contacts)),
    FIELD("contact_age", 1, out.put(age_of_set_in_use(v))),
    FIELD("contact_flags", 1, out.put(v.contacts.flags)),
    FIELD("contact_renderer", 1, out.put(v.contacts.renderer)),
    FIELD("reseeds", 1, out.put(v.contacts.reseeds)),
    FIELD("contact_busy", 1, out.put(seconds(v.contacts.busy_ns))),
    FIELD("age_servo", 1, out.put(age_of(v, v.has_servo, v.servo.t_ns))),
    FIELD("age_contact", 1, out.put(age_of(v, v.has_contacts, v.contacts.answers_t_ns))),
    FIELD("age_sim", 1, out.put(age_of(v, v.has_scene, v.scene.t_ns))),
    FIELD("rate_servo", 1, out.put(v.rate_servo)),
    FIELD("rate_contact", 1, out.put(v.rate_contact)),
    FIELD("rate_sim", 1, out.put(v.rate_sim)),
    FIELD("unseen", 1, out.put(0)),
    FIELD("lost", 1, out.put(v.lost)),
    FIELD("revision", 1, out.put(v.control.revision)),
    FIELD("stiffness", 1, out.put(v.control.translational_stiffness)),
    FIELD("damping", 1, out.put(v.control.translational_damping)),
    FIELD("rotational_stiffness", 1, out.put(v.control.rotational_stiffness)),
    FIELD("rotational_damping", 1, out.put(v.control.rotational_damping)),
    FIELD("paused", 1, out.put(v.control.paused)),
    FIELD("armed", 1, out.put(v.control.armed)),
    FIELD("leading", 1, out.put(is_led(v))),
    FIELD("intent", 3, out.put(intent_of(v))),
    FIELD("buttons", 1, out.put(v.servo.device.buttons)),
    FIELD("n_objects", 1, out.put(n_objects(v))),
    FIELD("n_listed", 1, out.put(n_listed(v))),
    FIELD("n_joints", 1, out.put(n_joints(v))),
    FIELD("n_samples", 1, out.put(0)),
};
#undef FIELD

constexpr FrameField<Pose> kObject[] = {
    {"pose", 7, [](const Pose& X_WO, Out out) { out.put(X_WO); }}};

/// A contact, or a guide row, as the page shows it.
struct ListedContact {
  Vec3 point_W, normal_W;
  double extent, stiffness;
  uint32_t object, kind;
  bool is_active;
};
constexpr int kKindShift = 62;      // of Contact::feature
constexpr uint32_t kGuideKind = 3;  // beside face, edge and vertex

constexpr FrameField<ListedContact> kContact[] = {
    {"point", 3, [](const ListedContact& c, Out out) { out.put(c.point_W); }},
    {"normal", 3, [](const ListedContact& c, Out out) { out.put(c.normal_W); }},
    {"extent", 1, [](const ListedContact& c, Out out) { out.put(c.extent); }},
    {"stiffness", 1, [](const ListedContact& c, Out out) { out.put(c.stiffness); }},
    {"object", 1, [](const ListedContact& c, Out out) { out.put(c.object); }},
    {"active", 1, [](const ListedContact& c, Out out) { out.put(c.is_active); }},
    {"kind", 1, [](const ListedContact& c, Out out) { out.put(c.kind); }},
};

constexpr FrameField<JointState> kJoint[] = {
    {"position", 1, [](const JointState& joint, Out out) { out.put(joint.position); }},
    {"velocity", 1, [](const JointState& joint, Out out) { out.put(joint.velocity); }},
};

constexpr FrameField<Sample> kSample[] = {
    {"time", 1, [](const Sample& s, Out out) { out.put(s.time); }},
    {"force", 3, [](const Sample& s, Out out) { out.put(s.force_W); }},
    {"torque", 3, [](const Sample& s, Out out) { out.put(s.torque_W); }},
    {"depth", 1, [](const Sample& s, Out out) { out.put(s.depth); }},
    {"wake_late", 1, [](const Sample& s, Out out) { out.put(s.wake_late); }},
    {"contact_rate", 1, [](const Sample& s, Out out) { out.put(s.contact_rate); }},
    {"flags", 1, [](const Sample& s, Out out) { out.put(s.flags); }},
};

template <typename T, size_t N>
constexpr uint32_t size_of(const FrameField<T> (&fields)[N]) {
  uint32_t size = 0;
  for (const FrameField<T>& field : fields) size += field.count;
  return size;
}

template <typename T, size_t N>
void append_fields(std::vector<double>& out, const FrameField<T> (&fields)[N], const T& from) {
  const size_t begin = out.size();
  out.resize(begin + size_of(fields));
  double* at = out.data() + begin;
  for (const FrameField<T>& field : fields) {
    field.write(from, {at});
    at += field.count;
  }
}

void append_contacts(std::vector<double>& out, const View& view) {
  const auto append = [&](const auto& row, double extent, uint64_t kind, bool is_active) {
    const Pose X_WO = object_pose(view, row.object);
    append_fields(out, kContact,
                  ListedContact{X_WO * row.object_point_O, rotate(X_WO.q, row.normal_O), extent,
                                row.stiffness, row.object, static_cast<uint32_t>(kind), is_active});
  };
  const ContactSet& set = view.contacts;
  for (size_t i = 0; i < set.contacts.size(); ++i) {
    const Contact& c = set.contacts[i];
    append(c, c.extent, c.feature >> kKindShift, i < set.n_active);
  }
  for (const GuideRow& guide : set.guides) append(guide, 0, kGuideKind, false);
}

/// Place of a number of the fixed part; does not compile if there is none.
consteval uint32_t place_of(std::string_view name) {
  uint32_t offset = 0;
  for (const FrameField<View>& field : kFixed) {
    if (field.name == name) return offset;
    offset += field.count;
  }
  throw "no such field";
}

/// The place and the size of each field of a part.
template <typename T, size_t N>
Json places_json(const FrameField<T> (&fields)[N], Json places = Json::object()) {
  uint32_t offset = 0;
  for (const FrameField<T>& field : fields) {
    places[field.name] = {offset, field.count};
    offset += field.count;
  }
  return places;
}

template <typename T, size_t N>
Json part_json(const FrameField<T> (&fields)[N]) {
  return places_json(fields, {{"size", size_of(fields)}});
}

}  // namespace

std::string layout_json() {
  return json_line({{"fixed", places_json(kFixed)},
                    {"fixed_size", size_of(kFixed)},
                    {"object", part_json(kObject)},
                    {"contact", part_json(kContact)},
                    {"joint", part_json(kJoint)},
                    {"sample", part_json(kSample)}}) +
         "\n";
}

std::vector<double> common_frame(const View& view) {
  std::vector<double> out;
  const size_t objects = n_objects(view);
  out.reserve(size_of(kFixed) + objects * size_of(kObject) + n_listed(view) * size_of(kContact) +
              n_joints(view) * size_of(kJoint));
  append_fields(out, kFixed, view);
  for (uint32_t i = 0; i < objects; ++i) append_fields(out, kObject, object_pose(view, i));
  if (view.has_contacts) append_contacts(out, view);
  for (size_t i = 0; i < n_joints(view); ++i) append_fields(out, kJoint, view.scene.joints[i]);
  return out;
}

static_assert(place_of("sequence") == 0, "viewer.cpp puts that of each viewer there");

std::string frame_bytes(const std::vector<double>& common, const View& view, const FrameOf& of) {
  std::vector<double> numbers;
  const uint64_t n_samples = of.end_sample - of.first_sample;
  numbers.reserve(common.size() + n_samples * size_of(kSample));
  numbers = common;
  numbers[place_of("sequence")] = static_cast<double>(of.sequence);
  numbers[place_of("column")] = static_cast<double>(of.column);
  numbers[place_of("unseen")] = static_cast<double>(of.unseen);
  numbers[place_of("n_samples")] = static_cast<double>(n_samples);
  for (uint64_t i = of.first_sample; i < of.end_sample; ++i) {
    append_fields(numbers, kSample, view.samples.at(i));
  }
  std::string bytes(numbers.size() * sizeof(double), '\0');
  std::memcpy(bytes.data(), numbers.data(), bytes.size());
  return bytes;
}

FrameOf samples_since(const Samples& samples, uint64_t seen) {
  FrameOf of;
  of.end_sample = samples.end();
  const uint64_t n = std::min({samples.end() - std::min(seen, samples.end()), kMostSamples});
  of.first_sample = of.end_sample - n;
  return of;
}

}  // namespace haptic
