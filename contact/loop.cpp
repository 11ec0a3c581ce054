// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/loop.h"

#include <algorithm>
#include <cstdio>
#include <memory>
#include <utility>
#include <vector>

#include "contact/bake/cache.h"
#include "contact/bake/eye_files.h"
#include "contact/bake/session.h"
#include "contact/step.h"
#include "proto/os/message.h"
#include "proto/os/priorities.h"

namespace haptic {
namespace {

constexpr int64_t kWarmUpLookNs = 10'000'000;  // [ns], a look for the servo's first frame
constexpr int kWarmUpLooks = 20;   // a servo that runs answers the first; it need not run
constexpr int64_t kRestShare = 4;  // after a step of d rest d/4: never more than 80 % of a core
// after the servo's next frame is to be there: one wake-up late costs less than one in vain [ns]
constexpr int64_t kFrameMarginNs = 20'000;

void say(const std::string& line) {
  std::fprintf(stderr, "haptic-contact: %s\n", one_line(line).c_str());
}

BakedSession bake_told(const SessionConfig& config) {
  BakeTold told;
  told.begin = [](const std::string& mesh) { say(std::string(kPreparing) + mesh); };
  told.finding = say;
  bake_apart();
  return bake_session(config, told);
}

/// Offers how the scene is drawn. No hand needs it: what hapticd does not take is said, no more.
void offer_eyes(const Child<ContactChannels>& child, std::vector<SealedEye> eyes) {
  try {
    for (const SealedEye& eye : eyes) child.offer_file(eye.id, eye.name.c_str(), eye.file.get());
  } catch (const HandoutError& error) {
    say(error.what());
  }
}

/// Makes one step whose result is discarded, so that code and meshes are in memory for the first
/// real one. Waits a while for a question.
void warm_up(const ContactModel& model, ContactState& state,
             RingSource<&ServoChannels::frames>& hand) {
  ServoFrame question{};
  for (int i = 0; i < kWarmUpLooks && !stop_requested(); ++i) {
    sleep_until(now_ns() + kWarmUpLookNs);
    if (!hand.latest(question)) continue;
    contact_step(model, state, question, nullptr);
    return;
  }
}

/// When the servo's next frame will be there, if that tick goes like this one.
int64_t next_frame_ns(const ServoFrame& frame, int64_t servo_period) {
  return frame.t_ns + servo_period + frame.wake_late_ns + frame.busy_ns + kFrameMarginNs;
}

/// Its grid is the servo's: it wakes once a tick, when the frame is there, and looks again every
/// poll period where it is not.
class FrameClock {
 public:
  explicit FrameClock(const SessionConfig& config)
      : servo_period_(period_ns(config.servo_rate)),
        poll_period_(period_ns(config.contact_poll_rate)) {}

  /// Sleeps until the next look.
  Tick wait() {
    sleep_until(wake_ns_);
    const int64_t now = now_ns(), deadline_ns = wake_ns_;
    wake_ns_ = now + poll_period_;
    return {index_++, deadline_ns, now - deadline_ns, 0};
  }
  /// The frame has been answered; not before not_before_ns.
  void answered(const ServoFrame& frame, int64_t not_before_ns) {
    wake_ns_ = std::max(next_frame_ns(frame, servo_period_), not_before_ns);
  }

 private:
  int64_t servo_period_, poll_period_;
  int64_t wake_ns_ = now_ns();
  uint64_t index_ = 0;
};

/// The rings of the clients that may push or touch.
class GivenInboxes {
 public:
  explicit GivenInboxes(Child<ContactChannels>& child)
      : controls_(child.ring<&ControlChannels::frames>(Start::kOldest)) {
    for (const GivenTouchModel::Client& known : build_given_touch(child.config()).clients) {
      inboxes_.push_back(
          {known.client, child.ring<&ClientChannels::frames>(Start::kNewest, known.client)});
    }
  }

  /// Takes one frame at most, of the clients in turn: a step costs the same however many there are.
  void take(const GivenTouchModel& model, GivenTouchState& state, int64_t t_ns) {
    controls_.latest(control_);
    const size_t n = inboxes_.size();
    for (size_t k = 0; k < n; ++k) {
      state.clients[k].heard.follow(control_.giving[inboxes_[k].client]);
    }
    for (size_t i = 0; i < n; ++i) {
      const size_t k = (turn_ + i) % n;
      auto& [client, frames] = inboxes_[k];
      // a client that floods costs no more than one that does not
      if (!state.clients[k].heard.is_due(t_ns) || !frames.latest(frame_)) continue;
      see_client(model, state, k, frames.item_generation(), frame_, t_ns);
      turn_ = k + 1;
      return;
    }
  }

 private:
  struct Inbox {
    uint32_t client;
    RingSource<&ClientChannels::frames> frames;
  };
  RingSource<&ControlChannels::frames> controls_;
  std::vector<Inbox> inboxes_;
  ControlFrame control_{};
  GivenFrame frame_{};
  size_t turn_ = 0;  // the client that is looked at first
};

}  // namespace

int run_contact(const ChildArguments& arguments, ContactPublisher publish) {
  Child<ContactChannels> child(arguments);
  auto hand = child.ring<&ServoChannels::frames>(Start::kNewest);
  auto scenes = child.ring<&SimChannels::frames>(Start::kOldest);
  GivenInboxes given(child);
  const BakedSession baked = bake_told(child.config());
  const ContactModel model = build_contact_model(child.config(), baked.shapes());
  auto state = std::make_unique<ContactState>(model);
  std::vector<SealedEye> eyes = make_eye_files(child.config(), baked, say);
  child.attach();
  if (arguments.spare_fd >= 0) {
    warm_up(model, *state, hand);
    state = std::make_unique<ContactState>(model);
  }
  child.enter_realtime({.fifo_priority = kContactPriority, .lock_memory = true});

  ServoFrame question{};
  SceneFrame scene{};
  bool any_scene = false;
  const auto look = [&] {
    // reading frees the segments of writers that have died
    any_scene |= scenes.latest(scene);
    hand.latest(question);
    const int64_t t_ns = now_ns();
    given.take(model.given, state->given, t_ns);
    weigh_given(model.given, state->given, t_ns);
  };
  if (!await_turn(arguments.spare_fd, look)) return kExitClean;
  child.offer();
  offer_eyes(child, std::move(eyes));
  FrameClock clock(child.config());
  while (!child.stopping()) {
    child.beat(clock.wait());
    any_scene |= scenes.latest(scene);
    if (!hand.latest(question)) continue;

    const int64_t start_ns = now_ns();
    given.take(model.given, state->given, start_ns);
    ContactSet answer = contact_step(model, *state, question, any_scene ? &scene : nullptr);
    answer.busy_ns = now_ns() - start_ns;
    publish(child, answer);
    clock.answered(question, start_ns + answer.busy_ns + answer.busy_ns / kRestShare);
  }
  child.finish();
  return kExitClean;
}

}  // namespace haptic
