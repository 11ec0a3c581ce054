// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <ctime>
#include <string>
#include <string_view>
#include <vector>

#include "proto/ipc/attachments.h"
#include "proto/ipc/control_socket.h"
#include "servo/hapticd/children.h"
#include "servo/hapticd/command.h"
#include "servo/hapticd/echoes.h"
#include "servo/hapticd/giving/give_server.h"
#include "servo/hapticd/leads.h"
#include "servo/hapticd/session_run.h"
#include "servo/hapticd/status.h"

namespace haptic {

/// Takes the requests of people to a session. A request is received; a question, a stop or a lead
/// is answered at once; a change is published, and answered when the servo has echoed its revision
/// or a second has passed.
class Commands {
 public:
  /// Listens. Construct it before attachments.start(). Throws HandoutError.
  Commands(SessionRun& session, Attachments& attachments, Children& children);

  /// Readable when serve() has something to do.
  int poll_fd() const { return socket_.poll_fd(); }
  /// When to call turn() next, whatever happens; far away if nobody waits for an answer.
  int64_t next_turn_ns() const;

  void serve();
  /// Answers the request of a watcher: the status, and nothing else.
  std::string answer_watcher(std::string_view line);
  /// Answers what the servo has echoed, and publishes the desired state from time to time.
  void turn(int64_t t_ns);
  /// Looks at the scene and at who leads the hand.
  void look(int64_t t_ns);
  /// Whose seats the status shows; null: no client may give.
  void show_givers(const GiveServer* givers) { givers_ = givers; }
  /// A hand's fault outlives the servo that found it, until it is cleared.
  void keep_fault(uint32_t hand);
  /// Listens again if its socket was removed. Throws HandoutError.
  void restore() { socket_.restore(); }

 private:
  void take(uint64_t peer, std::string_view line);
  void change(uint64_t peer, std::string_view line, const ControlCommand& command,
              const std::vector<uint32_t>& hands, const std::vector<ControlFrame>& wanted);
  SessionStatus status();

  SessionRun& session_;
  Children& children_;
  const GiveServer* givers_ = nullptr;
  const std::time_t since_ = std::time(nullptr);
  ControlServer socket_;
  Leads leads_;
  Echoes echoes_;
  /// What is heard of a hand.
  struct Heard {
    RingSource<&ServoChannels::frames> servo_frames;
    RingSource<&ContactChannels::sets> contact_sets;
    ServoFrame servo{};  // the newest
    ContactSet contact{};
  };
  std::vector<Heard> heard_;  // by hand
  RingSource<&SimChannels::frames> sim_frames_;
  SceneFrame scene_frame_{};  // the newest
};

}  // namespace haptic
