// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/loop.h"

#include <cstdio>
#include <memory>

#include "contact/bake_session.h"
#include "proto/message.h"

namespace haptic {
namespace {

constexpr int kFifoPriority = 60;
constexpr int64_t kRestShare = 4;  // after a step of d rest d/4: never more than 80 % of a core

BakedSession bake_told(const SessionConfig& config) {
  BakeTold told;
  told.finding = [](const std::string& line) {
    std::fprintf(stderr, "haptic-contact: %s\n", one_line(line).c_str());
  };
  return bake_session(config, told);
}

}  // namespace

int run_contact(const ChildArguments& arguments, ContactPublisher publish) {
  Child<ContactChannels> child(arguments);
  auto hand = child.ring<&ServoChannels::frames>(Start::kNewest);
  auto scenes = child.ring<&SimChannels::frames>(Start::kOldest);
  const BakedSession baked = bake_told(child.config());
  const ContactModel model = build_contact_model(child.config(), baked.shapes());
  const auto state = std::make_unique<ContactState>(model);
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
