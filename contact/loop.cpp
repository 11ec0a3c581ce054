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
#include "proto/config/hand_config.h"
#include "proto/ipc/seen_scene.h"
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
  GivenInboxes(Child<ContactChannels>& child, uint32_t hand)
      : controls_(child.ring<&ControlChannels::frames>(Start::kOldest, hand)) {
    for (const GivenTouchModel::Client& known : build_given_touch(child.config(hand)).clients) {
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

/// All that answers the servo of a hand.
class ContactOfHand {
 public:
  /// Bakes. Before child.attach().
  ContactOfHand(Child<ContactChannels>& child, uint32_t hand)
      : questions_(child.ring<&ServoChannels::frames>(Start::kNewest, hand)),
        config_(with_tools(child.hands(), hand)),
        scenes_(child, hand, child.n_hands(), config_.n_tools > 0),
        given_(child, hand),
        baked_(bake_told(config_)),
        model_(build_contact_model(config_, baked_.shapes())),
        state_(std::make_unique<ContactState>(model_)),
        eyes_(make_eye_files(config_, baked_, say)) {}

  /// Makes one step whose result is discarded, so that code and meshes are in memory for the first
  /// real one. Waits a while for a question.
  void warm_up() {
    for (int i = 0; i < kWarmUpLooks && !stop_requested(); ++i) {
      sleep_until(now_ns() + kWarmUpLookNs);
      if (!questions_.latest(question_)) continue;
      contact_step(model_, *state_, question_, nullptr);
      break;
    }
    state_ = std::make_unique<ContactState>(model_);
  }

  /// A spare's, while it waits: reading frees the segments of writers that have died.
  void look() {
    questions_.latest(question_);
    scenes_.latest();
    const int64_t t_ns = now_ns();
    given_.take(model_.given, state_->given, t_ns);
    weigh_given(model_.given, state_->given, t_ns);
  }

  /// Answers the servo from now on, until the child is to stop.
  void run(Child<ContactChannels>& child, ContactPublisher publish) {
    child.offer();
    offer_eyes(child, std::move(eyes_));
    FrameClock clock(config_);
    while (!child.stopping()) {
      child.beat(clock.wait());
      const SceneFrame* const scene = scenes_.latest();
      if (!questions_.latest(question_)) continue;

      const int64_t start_ns = now_ns();
      given_.take(model_.given, state_->given, start_ns);
      ContactSet answer = contact_step(model_, *state_, question_, scene);
      answer.busy_ns = now_ns() - start_ns;
      publish(child, answer);
      clock.answered(question_, start_ns + answer.busy_ns + answer.busy_ns / kRestShare);
    }
  }

 private:
  RingSource<&ServoChannels::frames> questions_;
  const SessionConfig config_;
  SeenScene scenes_;
  GivenInboxes given_;
  const BakedSession baked_;
  const ContactModel model_;
  std::unique_ptr<ContactState> state_;
  std::vector<SealedEye> eyes_;
  ServoFrame question_{};
};

constexpr RealtimeOptions kRealtime{.fifo_priority = kContactPriority, .lock_memory = true};

/// A spare of all hands: sleeps until a contact is dead, and is that one from then on.
int run_spare(Child<ContactChannels>& child, int spare_fd, ContactPublisher publish) {
  std::vector<std::unique_ptr<ContactOfHand>> hands;
  for (uint32_t hand = 0; hand < child.n_hands(); ++hand) {
    hands.push_back(std::make_unique<ContactOfHand>(child, hand));
  }
  child.attach();
  for (const auto& hand : hands) hand->warm_up();
  child.enter_realtime(kRealtime);
  const auto turn = await_turn(spare_fd, [&] {
    for (const auto& hand : hands) hand->look();
  });
  if (!turn || *turn >= hands.size()) return kExitClean;
  child.become(*turn);
  hands[*turn]->run(child, publish);
  child.finish();
  return kExitClean;
}

}  // namespace

int run_contact(const ChildArguments& arguments, ContactPublisher publish) {
  Child<ContactChannels> child(arguments);
  if (arguments.spare_fd >= 0) return run_spare(child, arguments.spare_fd, publish);
  const auto hand = std::make_unique<ContactOfHand>(child, child.hand());
  child.attach();
  child.enter_realtime(kRealtime);
  hand->run(child, publish);
  child.finish();
  return kExitClean;
}

}  // namespace haptic
