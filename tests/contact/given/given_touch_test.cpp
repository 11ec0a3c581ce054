// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/given/given_touch.h"

#include <catch2/catch.hpp>
#include <functional>
#include <limits>

using namespace haptic;

namespace {

constexpr int64_t kMsNs = 1'000'000;

/// Contact with a client that may push and touch, and one that may push alone.
struct Hearing {
  SessionConfig config;
  GivenTouchModel model;
  GivenTouchState state;
  int64_t t_ns = 1'000'000'000;
  GivenFrame frame{};

  Hearing() {
    config.n_objects = 2;
    config.n_clients = 3;
    config.clients[1].may = kMayPush | kMayTouch;
    config.clients[2].may = kMayPush;
    config.coupling.translational_stiffness = 1000;
    config.coupling.rotational_stiffness = 2;
    config.device.max_damping = 4;
    config.device.max_rotational_damping = 0.1;
    config.proxy.contact_stiffness = 500;
    model = build_given_touch(config);
    state = begin_given_touch(model);
    for (auto& client : state.clients) client.heard.follow(7);
    begin();
  }
  void begin() {
    frame.pushes.clear();
    frame.planes.clear();
  }
  /// The answer 10 ms after a frame of the k-th of those that contact hears.
  ContactSet heard(size_t k = 0, uint32_t held = kMaxObjects) {
    t_ns += 10 * kMsNs;
    ++frame.seq;
    frame.t_ns = t_ns;
    see_client(model, state, k, 7, frame, t_ns);
    ServoFrame servo{};
    servo.t_ns = t_ns;
    ContactSet set{};
    add_given(model, state, servo, {held, 0.01}, set);
    return set;
  }
  ContactSet open(size_t k = 0) {
    for (int n = 0; n < 20; ++n) heard(k);
    return heard(k);
  }
  GivenWrench& push() {
    frame.pushes.push_back({});
    frame.pushes.back().wrench.X_WT.q.w = 1;
    return frame.pushes.back();
  }
  GivenPlane& plane() {
    frame.planes.push_back({});
    frame.planes.back().normal_O.z = 1;
    return frame.planes.back();
  }
};

}  // namespace

TEST_CASE("given touch: contact passes on what a client gives to its hand") {
  Hearing hearing;
  CHECK(hearing.model.clients.size() == 2);
  GivenWrench& push = hearing.push();
  push.wrench.F0_W.f.z = 1.5;
  push.wrench.K[0] = -300;
  push.wrench.B[14] = 3;
  hearing.plane().object = 1;
  hearing.plane().object = kNoObject;
  hearing.plane().hand = 1;  // of another hand
  const ContactSet set = hearing.open();
  REQUIRE(set.wrenches.size() == 1);
  CHECK(set.wrenches[0].giver == moved_by_client(1));
  CHECK(set.wrenches[0].weight == 1);
  CHECK(set.wrenches[0].wrench.F0_W.f.z == 1.5);
  CHECK(set.wrenches[0].wrench.K[0] == -300);
  CHECK(set.wrenches[0].wrench.B[14] == 3);
  REQUIRE(set.contacts.size() == 2);
  CHECK(set.contacts[0].object == 1);
  CHECK(set.contacts[1].object == kNoObject);
  CHECK(set.contacts[0].giver == moved_by_client(1));
  CHECK(set.contacts[0].reduction == 0);
  CHECK((set.flags & kContactGiven) != 0);
  REQUIRE(set.givers.size() == 2);
  CHECK(set.givers[0].refused == 0);
  CHECK((set.givers[0].flags & kGiverLimited) == 0);
  // where the tool holds the object nothing pushes it
  CHECK(hearing.heard(0, 1).contacts.size() == 1);
}

TEST_CASE("given touch: a K or B beyond the session is scaled down, one that drives is left out") {
  Hearing hearing;
  GivenWrench& push = hearing.push();
  push.wrench.K[0] = -5000;
  push.wrench.K[7] = 2000;
  push.wrench.B[0] = 400;
  const ContactSet cut = hearing.open();
  CHECK(cut.wrenches[0].wrench.K[0] == Approx(-1000));
  CHECK(cut.wrenches[0].wrench.K[7] == Approx(400));
  CHECK(cut.wrenches[0].wrench.B[0] == Approx(4));
  CHECK((cut.givers[0].flags & kGiverLimited) != 0);
  // it brakes along each axis alone, but drives along (1, −1)
  push.wrench.B[0] = push.wrench.B[7] = 1;
  push.wrench.B[1] = push.wrench.B[6] = 2;
  CHECK(hearing.heard().wrenches[0].wrench.B[0] == 0);
}

TEST_CASE("given touch: what cannot be used is refused, and nothing of it is given") {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  struct Wrong {
    std::function<void(Hearing&)> make;
    GiverRefusal why;
  };
  const auto wrench = [](const std::function<void(ToolWrench&)>& spoil) {
    return [=](Hearing& h) { spoil(h.push().wrench); };
  };
  const auto plane = [](const std::function<void(GivenPlane&)>& spoil) {
    return [=](Hearing& h) { spoil(h.plane()); };
  };
  using enum GiverRefusal;
  const std::vector<Wrong> all{
      {wrench([](ToolWrench& w) { w.F0_W.t.x = kNan; }), kNotFinite},
      {wrench([](ToolWrench& w) { w.K[35] = kNan; }), kNotFinite},
      {wrench([](ToolWrench& w) { w.B[3] = std::numeric_limits<double>::infinity(); }), kNotFinite},
      {wrench([](ToolWrench& w) { w.X_WT.q.w = 2; }), kNotFinite},
      {wrench([](ToolWrench& w) { w.K[1] = 5; }), kNotSymmetric},
      {wrench([](ToolWrench& w) { w.F0_W.f.x = 1e300; }), kTooFast},
      {wrench([](ToolWrench& w) { w.trust_radius = -1; }), kTooFast},
      {wrench([](ToolWrench& w) { w.X_WT.p.x = 1e9; }), kTooFast},
      {[](Hearing& h) { h.push().hand = 99; }, kNoPlane},
      {[](Hearing& h) { h.push(), h.push(); }, kNoPlane},
      {plane([](GivenPlane& p) { p.normal_O.z = 1.1; }), kNoPlane},
      {plane([](GivenPlane& p) { p.object = 2; }), kNoPlane},
      {plane([](GivenPlane& p) { p.extent = -1; }), kNoPlane},
      {plane([](GivenPlane& p) { p.object_point_O.x = kNan; }), kNotFinite},
      {[](Hearing& h) { h.frame.moves.push_back({}); }, kNotAllowed},
      {[](Hearing& h) { h.frame.seq -= 2; }, kBackInTime}};
  for (size_t i = 0; i < all.size(); ++i) {
    Hearing hearing;
    CHECK(hearing.open().givers[0].refused == 0);
    all[i].make(hearing);
    const ContactSet set = hearing.heard();
    CAPTURE(i);
    CHECK(set.givers[0].refused == 1);
    CHECK(set.givers[0].refusal == static_cast<uint32_t>(all[i].why));
    CHECK(set.contacts.empty());
    CHECK(set.wrenches.empty());
  }
  Hearing pushes_alone;
  pushes_alone.plane();
  const ContactSet set = pushes_alone.heard(1);
  CHECK(set.givers[1].refusal == static_cast<uint32_t>(kNotAllowed));
}

TEST_CASE("given touch: what a client has given fades before its successor's is felt") {
  Hearing hearing;
  hearing.push().wrench.F0_W.f.x = 1;
  REQUIRE(hearing.open().wrenches[0].weight == 1);
  for (auto& client : hearing.state.clients) client.heard.follow(8);
  double weight = 1;
  for (int n = 0; n < 60; ++n) {
    hearing.t_ns += kMsNs;
    hearing.begin();
    hearing.push().wrench.F0_W.f.x = -1;
    ++hearing.frame.seq;
    hearing.frame.t_ns = hearing.t_ns;
    see_client(hearing.model, hearing.state, 0, 8, hearing.frame, hearing.t_ns);
    ServoFrame servo{};
    servo.t_ns = hearing.t_ns;
    ContactSet set{};
    add_given(hearing.model, hearing.state, servo, {}, set);
    const double now = set.wrenches.empty() ? 0 : set.wrenches[0].weight;
    if (!set.wrenches.empty() && set.wrenches[0].wrench.F0_W.f.x > 0) CHECK(now <= weight);
    if (!set.wrenches.empty() && set.wrenches[0].wrench.F0_W.f.x < 0) CHECK(now <= 0.3);
    CHECK(std::fabs(now - weight) <= 0.05);
    weight = now;
  }
  CHECK(weight > 0);
}

TEST_CASE("given touch: eight clients with all their planes fill a set and no more") {
  SessionConfig config;
  config.n_objects = 3;
  config.n_clients = kMostClients;
  for (ClientConfig& client : config.clients) client.may = kMayTouch;
  const GivenTouchModel model = build_given_touch(config);
  GivenTouchState state = begin_given_touch(model);
  ContactSet set{};
  int64_t t_ns = 1'000'000'000;
  GivenFrame frame{};
  for (uint32_t i = 0; i < kMostGivenPlanes; ++i) {
    GivenPlane plane{};
    plane.normal_O.x = 1;
    plane.object = i % 4 < 3 ? i % 4 : kNoObject;
    frame.planes.push_back(plane);
  }
  for (int n = 0; n < 30; ++n, t_ns += 10 * kMsNs) {
    ++frame.seq;
    frame.t_ns = t_ns;
    for (size_t k = 0; k < kMostClients; ++k) {
      state.clients[k].heard.follow(1);
      see_client(model, state, k, 1, frame, t_ns);
    }
    ServoFrame servo{};
    servo.t_ns = t_ns;
    set = {};
    add_given(model, state, servo, {}, set);
  }
  CHECK(set.contacts.size() == kMaxContacts);
  CHECK((set.flags & kContactTruncated) != 0);
}

TEST_CASE("given touch: a plane is passed on as soon as the tool may reach it") {
  Hearing hearing;
  hearing.plane().object_point_O.z = -0.009;
  hearing.plane().object_point_O.z = -0.011;
  // beyond it, however far, the tool has reached it
  hearing.plane().object_point_O.z = 1;
  const ContactSet set = hearing.open();
  REQUIRE(set.contacts.size() == 2);
  CHECK(set.contacts[0].object_point_O.z == -0.009);
  CHECK(set.contacts[1].object_point_O.z == 1);
}
