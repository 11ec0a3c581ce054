// SPDX-License-Identifier: GPL-3.0-or-later
// A whole session in lockstep whose simulated hand is led.
#include <memory>

#include "clients/lockstep/lockstep.h"
#include "contact/bake/session.h"
#include "device-io/hand/simulated_hand.h"
#include "tests/support/data.h"
#include "tests/support/near.h"

using namespace haptic;
using namespace haptic::test;

namespace {

constexpr int64_t kSecondNs = 1'000'000'000;  // [ns]

/// The block of 80 mm about the origin, touched by a hand that somebody leads.
class LedSession {
 public:
  SessionConfig config;
  std::unique_ptr<SimulatedHand> hand;
  std::unique_ptr<Lockstep> lockstep;

  LedSession() : config(load_config(from_source("configs/plane.toml"))) {
    // sticking and the encoder's steps would hide a part of the spring's force
    config.device.hand.encoder_step = 0;
    config.device.hand.coulomb_friction = 0;
    baked_ = std::make_unique<BakedSession>(bake_session(config));
    shapes_ = baked_->shapes();
    hand = std::make_unique<SimulatedHand>(config.device);
    lockstep = std::make_unique<Lockstep>(config, shapes_, *hand);
  }

  const ServoFrame& frame() const { return lockstep->frame(); }
  void run(int ticks) {
    for (int k = 0; k < ticks; ++k) REQUIRE(lockstep->step());
  }
  /// Leads the tool with a command sixty times a second.
  void lead(const Vec3& tool_W, int ticks) {
    ControlFrame& control = lockstep->control();
    control.leading = 1;
    control.X_WT_intent.p = tool_W;
    for (int k = 0; k < ticks; ++k) {
      if (k % 17 == 0) control.intent_t_ns = frame().t_ns;
      run(1);
    }
  }

 private:
  std::unique_ptr<BakedSession> baked_;
  ContactShapes shapes_;
};

}  // namespace

TEST_CASE("lead: pressed against a wall, the hand lags the intent by the stiffness of its arm",
          "[lab]") {
  LedSession session;
  session.run(50);
  session.lead({0, 0.1, 0}, 1500);
  session.lead({0.01, 0.04 - 0.012, 0}, 4000);
  const ServoFrame& f = session.frame();
  const Vec3& p_B = session.hand->plant().p_B;
  const Vec3& intent_B = session.hand->plant().intent_B;
  CHECK_THAT(intent_B, IsNear({0.01, 0.028, 0}, 1e-9));
  REQUIRE((f.flags & kServoContact) != 0);
  // k_arm (intent − hand) + F = 0, in rest; and the wall pushes with k of the coupling
  const double k_arm = session.config.device.hand.hand_stiffness, k = 800;
  const Vec3 arm_B = k_arm * (intent_B - p_B);
  CHECK_THAT(arm_B + f.F_device_B.f, IsNear({}, 1e-6));
  // two springs in series between the wall and the intent
  const double way = 0.012 * k / (k + k_arm);
  CHECK(p_B.y - intent_B.y == Approx(way).epsilon(1e-6));
}

TEST_CASE("lead: the servo ends it after 200 ms of silence, in virtual time too", "[lab]") {
  LedSession session, alone;
  session.run(1000);
  session.lead({0, 0.12, 0}, 500);
  const int64_t last_ns = session.lockstep->control().intent_t_ns;
  // hapticd goes on publishing what it was told last
  while (session.frame().t_ns < last_ns + kLeadNs) {
    session.run(1);
    CHECK((session.frame().device.flags & kDeviceLed) != 0);
  }
  session.run(2);
  CHECK((session.frame().device.flags & kDeviceLed) == 0);
  while (session.frame().t_ns < last_ns + 2 * kSecondNs) session.run(1);
  while (alone.frame().t_ns < session.frame().t_ns) alone.run(1);
  CHECK(session.hand->plant().intent_B == alone.hand->plant().intent_B);
}

TEST_CASE("lead: a paused session's hand is led, and feels nothing", "[lab]") {
  LedSession session;
  session.run(100);
  ControlFrame& control = session.lockstep->control();
  control.paused = 1;
  session.lead({0, 0.1, 0}, 1500);
  session.lead({0, 0.02, 0}, 3000);
  CHECK_THAT(session.frame().X_WT.p, IsNear({0, 0.02, 0}, 1e-3));
  CHECK(session.frame().F_device_B == Wrench{});
}
