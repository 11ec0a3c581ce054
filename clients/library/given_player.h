// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "clients/library/giver.h"
#include "clients/log/given_replay.h"
#include "proto/ipc/attachments.h"
#include "proto/ipc/give_message.h"

namespace haptic {

/// Gives to a session what clients gave in a recording, under their names, over the socket for
/// clients that give: hapticd, sim and contact check it as they check everyone's. A thread looks
/// every millisecond at what the servo has played and at what is due; a frame comes that late.
class GivenPlayer {
 public:
  /// A session that nobody else has connected to needs its own socket. The hand must not have been
  /// played for more than three seconds.
  GivenPlayer(const std::string& session, const SessionConfig& config,
              std::unique_ptr<GivenReplay> replay);
  ~GivenPlayer() { end(); }
  GivenPlayer(const GivenPlayer&) = delete;

  /// All its clients leave.
  void end();
  /// One line; empty: everything has been given. Valid after end().
  const std::string& problem() const { return problem_; }

 private:
  void run(const std::stop_token& stop);
  void see_hands();
  void play(const GivenAgain& due);

  std::string session_;
  const SessionConfig& config_;
  std::unique_ptr<GivenReplay> replay_;
  Attachments attachments_;
  std::vector<RingSource<&ServoChannels::frames>> hands_;
  uint64_t servo_ = 0;                                             // generation of the first hand's
  std::array<std::unique_ptr<GivenSegment>, kMostClients> seats_;  // of clients that are there
  std::string problem_;
  std::jthread thread_;
};

}  // namespace haptic
