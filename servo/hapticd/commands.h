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
  /// A fault outlives the servo that found it, until it is cleared.
  void keep_fault();
  /// Listens again if its socket was removed. Throws HandoutError.
  void restore() { socket_.restore(); }

 private:
  /// A requested change that the servo has not yet echoed.
  struct Unanswered {
    uint64_t peer;
    uint64_t revision;
    bool clears_fault;
    int64_t give_up_ns;
    std::string warning;
  };

  void take(uint64_t peer, std::string_view line);
  SessionStatus status();

  SessionRun& session_;
  Children& children_;
  const GiveServer* givers_ = nullptr;
  const std::time_t since_ = std::time(nullptr);
  ControlServer socket_;
  Leads leads_;
  std::vector<Unanswered> unanswered_;
  RingSource<&ServoChannels::frames> servo_frames_;
  RingSource<&SimChannels::frames> sim_frames_;
  RingSource<&ContactChannels::sets> contact_sets_;
  ServoFrame servo_frame_{};  // the newest
  SceneFrame scene_frame_{};  // the newest
  ContactSet contact_set_{};
};

}  // namespace haptic
