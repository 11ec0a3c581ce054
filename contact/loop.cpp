// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/loop.h"

#include <cstdio>
#include <memory>
#include <vector>

#include "contact/bake.h"
#include "contact/step.h"

namespace haptic {
namespace {

constexpr int kFifoPriority = 60;
constexpr int64_t kRestShare = 4;  // after a step of d rest d/4: never more than 80 % of a core

std::vector<BakedShape> bake_all(const SessionConfig& config) {
  std::vector<BakedShape> baked;
  for (uint32_t i = 0; i < config.n_objects; ++i) {
    baked.push_back(bake_object(config.objects[i], config.mesh_memory_limit));
    for (const std::string& line : baked.back().report.lines) {
      std::fprintf(stderr, "haptic-contact: %s\n", line.c_str());
    }
  }
  return baked;
}

std::vector<MeshShape> shapes_of(const std::vector<BakedShape>& baked) {
  std::vector<MeshShape> shapes;
  shapes.reserve(baked.size());
  for (const BakedShape& b : baked) shapes.push_back(b.shape);
  return shapes;
}

}  // namespace

int run_contact(const ChildArguments& arguments, ContactPublisher publish) {
  Child<ContactChannels> child(arguments);
  auto hand = child.ring<&ServoChannels::frames>(Start::kNewest);
  auto scenes = child.ring<&SimChannels::frames>(Start::kOldest);
  const std::vector<BakedShape> baked = bake_all(child.config());
  const ContactModel model = build_contact_model(child.config(), shapes_of(baked));
  const auto state = std::make_unique<ContactState>();
  child.start({.fifo_priority = kFifoPriority, .lock_memory = true});

  ServoFrame question{};
  SceneFrame scene{};
  bool any_scene = false;
  DeadlineClock clock(period_ns(child.config().contact_poll_rate));
  while (!child.stopping()) {
    child.beat(clock.wait());
    any_scene |= scenes.latest(scene);
    if (!hand.latest(question)) continue;

    const int64_t start_ns = now_ns();
    ContactSet answer = contact_step(model, *state, question, any_scene ? &scene : nullptr);
    answer.busy_ns = now_ns() - start_ns;
    publish(child, answer);
    sleep_until(start_ns + answer.busy_ns + answer.busy_ns / kRestShare);
  }
  child.finish();
  return kExitClean;
}

}  // namespace haptic
