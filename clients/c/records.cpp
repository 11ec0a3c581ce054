// SPDX-License-Identifier: Apache-2.0
// C: what the present record of a ring holds.
#include "clients/c/reader.h"
#include "proto/wire/schema.h"

using namespace haptic;

// poses, twists and wrenches are the same bytes on both sides
static_assert(sizeof(hapticd_pose) == sizeof(Pose) && sizeof(hapticd_twist) == sizeof(Twist) &&
              sizeof(hapticd_wrench) == sizeof(Wrench));

namespace {

template <typename To, typename From>
To same_bytes(const From& from) {
  static_assert(sizeof(To) == sizeof(From));
  To to;
  std::memcpy(&to, &from, sizeof to);
  return to;
}
hapticd_pose pose(const Pose& X) {
  return same_bytes<hapticd_pose>(X);
}
hapticd_twist twist(const Twist& V) {
  return same_bytes<hapticd_twist>(V);
}
hapticd_wrench wrench(const Wrench& F) {
  return same_bytes<hapticd_wrench>(F);
}
void copy_vector(const Vec3& from, double (&to)[3]) {
  std::memcpy(to, &from, sizeof to);
}

/// Calls show(record), where the present record is a T.
template <typename T, typename Show>
hapticd_result show_record(hapticd_frames* frames, const Show& show) {
  return with(frames, [&] {
    if (frames->ring != kRingOf<T>) {
      throw BadArgument("this ring holds " + std::string(frames->kind->record) + "s, not " +
                        std::string(kind_of(kRingOf<T>)->record) + "s");
    }
    const T* record = frames->record<T>();
    if (record == nullptr) return HAPTICD_NOTHING;
    show(*record);
    return HAPTICD_OK;
  });
}

template <typename List>
const auto& at(const List& list, uint32_t index) {
  if (index < list.size()) return list[index];
  throw BadArgument("there is no number " + std::to_string(index) + ", there are " +
                    std::to_string(list.size()));
}

template <typename List>
uint32_t count(const List& list) {
  return static_cast<uint32_t>(list.size());
}

hapticd_object object_of(const SceneObject& object) {
  hapticd_object out{};
  out.mover = object.mover;
  out.t_ns = object.t_ns;
  out.X_WO = pose(object.X_WO);
  out.V_WO = twist(object.V_WO);
  return out;
}

hapticd_object object_of(const ObjectSeen& object) {
  hapticd_object out{};
  out.X_WO = pose(object.X_WO);
  out.clearance = object.clearance;
  return out;
}

}  // namespace

hapticd_result hapticd_frames_servo(hapticd_frames* frames, hapticd_servo* servo) {
  return show_record<ServoFrame>(frames, [&](const ServoFrame& frame) {
    hapticd_servo out{};
    out.flags = frame.flags;
    out.tick = frame.tick;
    out.t_ns = frame.t_ns;
    out.realtime_ns = frame.realtime_ns;
    out.X_WT = pose(frame.X_WT);
    out.V_WT = twist(frame.V_WT);
    out.X_WP = pose(frame.X_WP);
    out.F_coupling_W = wrench(frame.F_coupling_W);
    out.F_device_B = wrench(frame.F_device_B);
    out.X_BH = pose(frame.device.X_BH);
    out.V_BH = twist(frame.device.V_BH);
    out.depth = frame.depth;
    out.buttons = frame.device.buttons;
    out.device_flags = frame.device.flags;
    out.n_contacts = frame.n_contacts;
    out.fault = frame.fault;
    put(out, servo);
  });
}

hapticd_result hapticd_frames_contact_set(hapticd_frames* frames, hapticd_contact_set* set) {
  return show_record<ContactSet>(frames, [&](const ContactSet& contacts) {
    hapticd_contact_set out{};
    out.flags = contacts.flags;
    out.seq = contacts.seq;
    out.tick = contacts.answers_tick;
    out.t_ns = contacts.answers_t_ns;
    out.X_WT = pose(contacts.X_WT);
    out.X_WG = pose(contacts.X_WG);
    out.n_contacts = count(contacts.contacts);
    out.n_active = contacts.n_active;
    out.n_objects = count(contacts.objects);
    put(out, set);
  });
}

hapticd_result hapticd_frames_scene(hapticd_frames* frames, hapticd_scene* scene) {
  return show_record<SceneFrame>(frames, [&](const SceneFrame& frame) {
    hapticd_scene out{};
    out.flags = frame.flags;
    out.seq = frame.seq;
    out.t_ns = frame.t_ns;
    out.n_objects = count(frame.objects);
    out.n_hands = frame.n_hands;
    put(out, scene);
  });
}

hapticd_result hapticd_frames_control(hapticd_frames* frames, hapticd_control* control) {
  return show_record<ControlFrame>(frames, [&](const ControlFrame& frame) {
    hapticd_control out{};
    out.armed = frame.armed;
    out.revision = frame.revision;
    out.t_ns = frame.t_ns;
    out.translational_stiffness = frame.translational_stiffness;
    out.translational_damping = frame.translational_damping;
    out.rotational_stiffness = frame.rotational_stiffness;
    out.rotational_damping = frame.rotational_damping;
    out.scene_time_scale = frame.scene_time_scale;
    out.paused = frame.paused;
    out.fault = frame.fault;
    out.renderer = frame.renderer;
    out.solver = frame.solver;
    put(out, control);
  });
}

uint32_t hapticd_frames_n_contacts(const hapticd_frames* frames) {
  const auto* set = frames != nullptr ? frames->record<ContactSet>() : nullptr;
  return set != nullptr ? count(set->contacts) : 0;
}

uint32_t hapticd_frames_n_objects(const hapticd_frames* frames) {
  if (frames == nullptr) return 0;
  if (const auto* set = frames->record<ContactSet>()) return count(set->objects);
  if (const auto* frame = frames->record<SceneFrame>()) return count(frame->objects);
  return 0;
}

hapticd_result hapticd_frames_contact(hapticd_frames* frames, uint32_t index,
                                      hapticd_contact* contact) {
  return show_record<ContactSet>(frames, [&](const ContactSet& set) {
    const Contact& one = at(set.contacts, index);
    hapticd_contact out{};
    out.object = one.object;
    copy_vector(one.tool_point_T, out.tool_point_T);
    copy_vector(one.object_point_O, out.object_point_O);
    copy_vector(one.normal_O, out.normal_O);
    out.stiffness = one.stiffness;
    out.feature = one.feature;
    put(out, contact);
  });
}

hapticd_result hapticd_frames_object(hapticd_frames* frames, uint32_t index,
                                     hapticd_object* object) {
  const auto show = [&](const auto& record) { put(object_of(at(record.objects, index)), object); };
  if (frames != nullptr && frames->ring == HAPTICD_CONTACT) {
    return show_record<ContactSet>(frames, show);
  }
  return show_record<SceneFrame>(frames, show);
}

hapticd_result hapticd_frames_record(hapticd_frames* frames, const void** bytes, size_t* size) {
  return with(frames, [&] {
    check_given(bytes, size);
    *bytes = frames->reader->record();
    *size = *bytes != nullptr ? frames->kind->fixed : 0;
    return *bytes != nullptr ? HAPTICD_OK : HAPTICD_NOTHING;
  });
}

hapticd_result hapticd_frames_list(hapticd_frames* frames, const char* name, const void** values,
                                   size_t* count, size_t* size_of_one) {
  return with(frames, [&] {
    check_given(name, values, count, size_of_one);
    *values = nullptr;
    *count = *size_of_one = 0;
    const std::byte* record = frames->reader->record();
    const RecordPart* part = frames->kind->parts.data();
    for (const RecordField& field : find_record(frames->kind->record)->fields) {
      if (!field.is_part) continue;
      if (field.name == name) {
        if (record == nullptr) return HAPTICD_NOTHING;
        uint32_t n;
        std::memcpy(&n, record + part->offset, sizeof n);
        *values = record + part->offset + kPartHeader;
        *count = std::min<size_t>(n, part->most);
        *size_of_one = part->element;
        return HAPTICD_OK;
      }
      ++part;
    }
    throw BadArgument("a " + std::string(frames->kind->record) + " has no list '" + shown(name) +
                      "'");
  });
}
