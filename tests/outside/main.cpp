// SPDX-License-Identifier: GPL-3.0-or-later
// A session of the renderer "hold" in lockstep: the tool goes into a plate, half out again, and
// out. Says what is wrong, and exits with 1.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <memory>

#include "contact/shape/mesh/primitives.h"
#include "contact/step.h"
#include "proto/config/config.h"
#include "proto/config/renderer_needs.h"
#include "servo/step.h"

namespace {

using namespace haptic;

constexpr double kStiffness = 800;  // [N/m]
constexpr double kTop = 0.01;       // of the plate [m]
constexpr double kRounding = 1e-12;
constexpr const char* kSession = R"(
[session]
name = "outside"
renderer = "hold"
[device]
kind = "simulated-hand"
max_force = "100 N"
[coupling]
stiffness = "800 N/m"
[[object]]
name = "plate"
primitive = "box"
extent = ["200 mm", "200 mm", "20 mm"]
)";

/// Height of the tool over the plate [m]: from 1 mm above to 2 mm below, and back.
double height_at(uint64_t tick) {
  constexpr double kStep = 1e-5;  // [m] in a tick
  return kStep * std::fabs(300 - static_cast<double>(tick)) - 2e-3;
}

struct Session {
  SessionConfig config = parse_config(kSession, "outside.toml");
  MeshShapeData plate = build_shape(make_mesh(config.objects[0].primitive));
  ContactModel contact_model = build_contact_model(config, std::array{plate.view()});
  ServoModel servo_model = build_servo_model(config, {100, 0});
  ContactState contact{contact_model};
  ServoState servo;
  ControlFrame control{};
  ContactSet set{};

  Session() {
    control.armed = 1;
    control.translational_stiffness = kStiffness;
    control.renderer = static_cast<uint32_t>(config.renderer);
  }

  ServoFrame tick(uint64_t tick) {
    ServoInput input;
    input.tick = tick;
    input.t_ns = static_cast<int64_t>(tick) * 1'000'000;
    input.device.t_ns = input.t_ns;
    input.device.flags = kDeviceFresh | kDeviceHomed;
    input.device.X_BH.p = {0.02, 0.01, kTop + height_at(tick)};
    input.control = &control;
    if (tick > 1) input.contacts = &set;
    const ServoFrame frame = servo_step(servo_model, servo, input);
    set = contact_step(contact_model, contact, frame, nullptr);
    return frame;
  }
};

}  // namespace

int main() {
  const RendererRow* row = find_renderer("hold");
  const auto session = std::make_unique<Session>();
  if (row == nullptr || session->config.renderer != row->id) {
    std::puts("the config does not know the renderer; known are:");
    std::puts(renderer_names().c_str());
    return 1;
  }
  double deepest = 0, worst = 0;
  int touching = 0;
  for (uint64_t k = 1; k < 600; ++k) {
    const ServoFrame frame = session->tick(k);
    const double depth = kTop - frame.X_WT.p.z;
    deepest = depth > 0 ? std::max(deepest, depth) : 0;
    touching += depth > 0;
    worst = std::max(worst, norm(frame.F_coupling_W.f - Vec3{0, 0, kStiffness * deepest}));
  }
  std::printf("touching in %d ticks, force wrong by at most %g N\n", touching, worst);
  return touching > 390 && worst <= kRounding ? 0 : 1;
}
