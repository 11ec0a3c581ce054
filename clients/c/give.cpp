// SPDX-License-Identifier: Apache-2.0
// C: a client that gives and draws.
#include <cmath>
#include <optional>
#include <span>
#include <type_traits>
#include <vector>

#include "clients/c/calls.h"
#include "clients/library/drawer.h"
#include "clients/library/giver.h"
#include "proto/ipc/sessions.h"

using namespace haptic;

/// Bytes of a struct until behind a field.
#define HAPTIC_END(type, field) (offsetof(type, field) + sizeof(type::field))

struct hapticd_giver : Handle {
  hapticd_giver(const std::string& session, const std::string& name)
      : client(session), giver(client, session, name) {
    client.start();
  }
  /// Throws a Failure that says why nobody listens.
  hapticd_result state() {
    const bool connected = client.is_connected();
    return say_gone(connected, client.refusal(), !connected && client.has_ended());
  }
  /// Throws BadArgument.
  void check_moves(uint32_t object) const {
    const auto is_it = [=](const GivePlace::Object& one) { return one.index == object; };
    if (std::any_of(giver.objects().begin(), giver.objects().end(), is_it)) return;
    throw BadArgument("this client may not move the object " + std::to_string(object));
  }

  Client client;
  Giver giver;
  std::optional<Drawer> drawer;  // once it has drawn
  std::vector<DrawnPoint> points;
  std::vector<DrawnLine> lines;
};

namespace {

constexpr double kLengthError = 1e-3;  // of a quaternion, which is then made 1

template <typename To, typename From>
void copy(const From& from, To& to) {
  static_assert(sizeof to == sizeof from && std::is_trivially_copyable_v<To>);
  std::memcpy(static_cast<void*>(&to), &from, sizeof to);
}

void check_numbers(const char* name, std::span<const double> numbers) {
  if (std::any_of(numbers.begin(), numbers.end(), [](double x) { return !std::isfinite(x); })) {
    throw BadArgument(std::string(name) + " holds what is no finite number");
  }
}

Pose checked_pose(const std::string& name, const hapticd_pose& given) {
  check_numbers((name + ".p").c_str(), given.p);
  check_numbers((name + ".q").c_str(), given.q);
  Pose X;
  copy(given, X);
  const double length = std::hypot(std::hypot(given.q[0], given.q[1], given.q[2]), given.q[3]);
  if (std::abs(length - 1) > kLengthError) {
    throw BadArgument(name + ".q has the length " + std::to_string(length) + ", not 1 (x y z w)");
  }
  X.q = normalized(X.q);
  return X;
}

Twist checked_twist(const char* name, const hapticd_twist& given) {
  check_numbers(name, given.v);
  check_numbers(name, given.w);
  Twist V;
  copy(given, V);
  return V;
}

GivenMotion checked_motion(const hapticd_motion& given) {
  GivenMotion motion{};
  motion.object = given.object;
  motion.X_WO = checked_pose("X_WO", given.X_WO);
  motion.V_WO = checked_twist("V_WO", given.V_WO);
  motion.acceleration_W = checked_twist("acceleration_W", given.acceleration_W);
  check_numbers("mobility", given.mobility);
  check_numbers("stiffness", given.stiffness);
  check_numbers("damping", given.damping);
  check_numbers("power", {&given.power, 1});
  copy(given.mobility, motion.mobility);
  copy(given.stiffness, motion.stiffness);
  copy(given.damping, motion.damping);
  motion.power = given.power;
  return motion;
}

GivenWrench checked_wrench(const hapticd_tool_wrench& given) {
  GivenWrench push{};
  push.hand = given.hand;
  push.wrench.X_WT = checked_pose("X_WT", given.X_WT);
  check_numbers("F0_W.f", given.F0_W.f);
  check_numbers("F0_W.t", given.F0_W.t);
  check_numbers("K", given.K);
  check_numbers("B", given.B);
  check_numbers("trust_radius", {&given.trust_radius, 1});
  copy(given.F0_W, push.wrench.F0_W);
  copy(given.K, push.wrench.K);
  copy(given.B, push.wrench.B);
  push.wrench.trust_radius = given.trust_radius;
  return push;
}

GivenPlane checked_plane(const hapticd_plane& given) {
  GivenPlane plane{};
  check_numbers("tool_point_T", given.tool_point_T);
  check_numbers("point_O", given.point_O);
  check_numbers("normal_O", given.normal_O);
  check_numbers("extent", {&given.extent, 1});
  check_numbers("stiffness", {&given.stiffness, 1});
  copy(given.tool_point_T, plane.tool_point_T);
  copy(given.point_O, plane.object_point_O);
  copy(given.normal_O, plane.normal_O);
  const double length = norm(plane.normal_O);
  if (std::abs(length - 1) > kLengthError) {
    throw BadArgument("normal_O has the length " + std::to_string(length) + ", not 1");
  }
  plane.normal_O = plane.normal_O / length;
  plane.extent = given.extent;
  plane.stiffness = given.stiffness;
  plane.feature = given.feature;
  plane.object = given.object;
  plane.hand = given.hand;
  return plane;
}

static_assert(HAPTICD_WORLD == kNoObject);

template <typename To, typename From>
void copy_all(const From* from, size_t n, size_t most, std::vector<To>& to) {
  if (n > 0) check_given(from);
  // one more than may be is refused by its number
  to.resize(std::min(n, most + 1));
  for (size_t i = 0; i < to.size(); ++i) copy(from[i], to[i]);
}

}  // namespace

hapticd_result hapticd_give(hapticd_session* session, const char* name, hapticd_giver** giver) {
  if (giver != nullptr) *giver = nullptr;
  return with(session, [&] {
    check_given(name, giver);
    try {
      *giver = new hapticd_giver(session->name, name);
    } catch (const HandoutError& error) {
      find_session(session->name);  // throws: it is not there
      throw Failure(HAPTICD_REFUSED, error.what());
    }
    return HAPTICD_OK;
  });
}

void hapticd_giver_close(hapticd_giver* giver) {
  close_handle(giver);
}

const char* hapticd_giver_message(const hapticd_giver* giver) {
  return giver != nullptr ? giver->message.data() : last_message();
}

hapticd_result hapticd_giver_object(hapticd_giver* giver, const char* name, uint32_t* index) {
  return with(giver, [&] {
    check_given(name, index);
    try {
      *index = giver->giver.object(name);
    } catch (const HandoutError& error) {
      throw BadArgument(error.what());
    }
    return HAPTICD_OK;
  });
}

hapticd_result hapticd_giver_pushed(hapticd_giver* giver, uint32_t object, hapticd_push* push) {
  return with(giver, [&] {
    size_of_given(push);
    giver->check_moves(object);
    const GivenPush given = giver->giver.pushed(object);
    hapticd_push out{};
    out.t_ns = giver->giver.instant_ns();
    out.span = given.span;
    copy(given.mean_W, out.mean);
    copy(given.slope_W, out.slope);
    put(out, push);
    return HAPTICD_OK;
  });
}

hapticd_result hapticd_giver_move(hapticd_giver* giver, const hapticd_motion* motion) {
  return with(giver, [&] {
    // the first version ends with the power
    const hapticd_motion given = taken(motion, HAPTIC_END(hapticd_motion, power));
    giver->check_moves(given.object);
    giver->giver.move(checked_motion(given));
    return HAPTICD_OK;
  });
}

hapticd_result hapticd_giver_push(hapticd_giver* giver, const hapticd_tool_wrench* push) {
  return with(giver, [&] {
    // the first version ends with the trust radius
    const hapticd_tool_wrench given = taken(push, HAPTIC_END(hapticd_tool_wrench, trust_radius));
    giver->giver.push(checked_wrench(given));
    return HAPTICD_OK;
  });
}

hapticd_result hapticd_giver_touch(hapticd_giver* giver, const hapticd_plane* plane) {
  return with(giver, [&] {
    // the first version ends with the feature
    const hapticd_plane given = taken(plane, HAPTIC_END(hapticd_plane, feature));
    try {
      giver->giver.touch(checked_plane(given));
    } catch (const HandoutError& error) {
      throw BadArgument(error.what());
    }
    return HAPTICD_OK;
  });
}

hapticd_result hapticd_giver_publish(hapticd_giver* giver) {
  return with(giver, [&] {
    giver->giver.publish();
    return giver->state();
  });
}

hapticd_result hapticd_giver_draw(hapticd_giver* giver, const hapticd_point* points,
                                  size_t n_points, const hapticd_line* lines, size_t n_lines) {
  return with(giver, [&] {
    copy_all(points, n_points, kMostDrawnPoints, giver->points);
    copy_all(lines, n_lines, kMostDrawnLines, giver->lines);
    try {
      check_drawing(giver->points, giver->lines);
    } catch (const MessageError& error) {
      throw BadArgument(error.what());
    }
    try {
      if (!giver->drawer) giver->drawer.emplace(giver->giver.seat());
    } catch (const HandoutError& error) {
      throw Failure(HAPTICD_REFUSED, error.what());
    }
    const bool is_shown = giver->drawer->draw(giver->points, giver->lines);
    const hapticd_result state = giver->state();
    return is_shown || state != HAPTICD_OK ? state : HAPTICD_NOTHING;
  });
}
