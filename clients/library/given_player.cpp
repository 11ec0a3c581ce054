// SPDX-License-Identifier: Apache-2.0
#include "clients/library/given_player.h"

#include <exception>
#include <utility>

#include "proto/ipc/process.h"
#include "proto/ipc/sessions.h"
#include "proto/math/units.h"
#include "proto/os/priorities.h"
#include "proto/os/realtime.h"

namespace haptic {

GivenPlayer::GivenPlayer(const std::string& session, const SessionConfig& config,
                         std::unique_ptr<GivenReplay> replay)
    : session_(session),
      config_(config),
      replay_(std::move(replay)),
      attachments_(connect_session(session)) {
  for (uint32_t hand = 0; hand < kMostHands; ++hand) {
    hands_.push_back(attachments_.ring<&ServoChannels::frames>(Start::kOldest, hand));
  }
  attachments_.start();
  thread_ = std::jthread([this](const std::stop_token& stop) { run(stop); });
}

void GivenPlayer::end() {
  if (!thread_.joinable()) return;
  thread_.request_stop();
  thread_.join();
}

void GivenPlayer::run(const std::stop_token& stop) try {
  while (!stop.stop_requested() && attachments_.is_connected()) {
    see_hands();
    GivenAgain due;
    while (replay_->next(now_ns(), due)) play(due);
    sleep_until(now_ns() + kMs);
  }
  for (auto& seat : seats_) seat.reset();
} catch (const std::exception& error) {
  problem_ = error.what();
  for (auto& seat : seats_) seat.reset();
}

/// Tells the replay what the servos have played. A first servo that has begun anew plays the hand
/// from its beginning.
void GivenPlayer::see_hands() {
  ServoFrame frame;
  for (uint32_t hand = 0; hand < hands_.size(); ++hand) {
    while (hands_[hand].next(frame, Take::kFields)) {
      if (hand == kFirstHand && hands_[hand].item_generation() != servo_) {
        servo_ = hands_[hand].item_generation();
        replay_->begin(frame.t_ns);
        const SegmentHeader* header = hands_[hand].header();
        const bool is_realtime = (header->realtime_bits.load() & kRealtimeFifo) != 0;
        if (is_realtime) enter_realtime({.fifo_priority = kRecorderPriority, .lock_memory = false});
      }
      replay_->see(hand, frame);
    }
  }
}

void GivenPlayer::play(const GivenAgain& due) {
  std::unique_ptr<GivenSegment>& seat = seats_.at(due.client);
  if (due.is_frame) {
    if (seat != nullptr) seat->publish(due.frame);
    return;
  }
  seat.reset();
  if (due.generation == 0) return;
  const std::string name(view(config_.clients[due.client].name));
  seat = std::make_unique<GivenSegment>(ask_to_give(session_, name));
}

}  // namespace haptic
