// SPDX-License-Identifier: Apache-2.0
// A ball on a spring, integrated here, a hundred times a second: the hand pushes it and feels it
// swing. 04_give [SESSION]; start one with `hapticd configs/give.toml`.
#include <hapticd/client.h>

#include <cstdio>
#include <exception>

namespace {

constexpr double kMass = 0.1, kStiffness = 200, kDamping = 0.5;  // [kg, N/m, N·s/m]
constexpr double kPeriod = 0.01, kStep = 1e-4;                   // [s]

struct Ball {
  haptic::Vec3 p{}, v{};

  haptic::Vec3 own_force() const { return -kStiffness * p - kDamping * v; }

  void move(const haptic::GivenPush& push) {
    for (double t = 0; t < push.span; t += kStep) {
      v += kStep / kMass * (own_force() + push.at(t).f);
      p += kStep * v;
    }
  }
};

}  // namespace

int main(int argc, char** argv) try {
  const std::string session = argc > 1 ? argv[1] : "";
  haptic::Client client(session);
  haptic::Giver giver(client, session, "ball");
  client.start();

  haptic::GivenMotion motion{};
  motion.object = giver.object("ball");
  motion.mobility = haptic::free_mobility(kMass);
  motion.stiffness = haptic::same_in_all_directions(kStiffness);
  motion.damping = haptic::same_in_all_directions(kDamping);
  Ball ball;
  for (int n = 1; client.is_connected(); ++n) {
    ball.move(giver.pushed(motion.object));
    motion.X_WO.p = ball.p;
    motion.V_WO.v = ball.v;
    motion.acceleration_W.v = ball.own_force() / kMass;
    giver.move(motion);
    giver.publish();
    if (n % 20 == 0) std::printf("ball at %+.4f %+.4f %+.4f m\n", ball.p.x, ball.p.y, ball.p.z);
    client.sleep(kPeriod);
  }
} catch (const std::exception& error) {
  return std::fprintf(stderr, "04_give: %s\n", error.what()), 1;
}
