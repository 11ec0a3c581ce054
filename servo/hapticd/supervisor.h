// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "proto/config/config.h"
#include "proto/ipc/attachments.h"
#include "servo/hapticd/children.h"
#include "servo/hapticd/commands.h"
#include "servo/hapticd/giving/give_server.h"
#include "servo/hapticd/log.h"
#include "servo/hapticd/session_run.h"

namespace haptic {

/// Runs a session: waits for its children, for commands, for watchers and for signals, and gives
/// each its turn. Its main thread is real time, so neither a restart nor the signal of its own end
/// to its children waits for a processor.
class Supervisor {
 public:
  /// Takes the session's name. `config_text` is the session file as read. Throws HandoutError,
  /// SegmentError, or std::runtime_error if a program or a device is missing.
  Supervisor(std::vector<SessionConfig> hands, std::string config_text, const std::string& session,
             HapticdLog& log);

  /// Runs until a stop signal or a permanent failure; returns hapticd's exit code.
  int run();

 private:
  int64_t wait_for_work(int64_t until_ns);
  void serve_givers();
  void watch_place();

  SessionRun session_;
  FileDescriptor signals_;
  Attachments attachments_;  // hapticd reads its children's rings like any client
  Children children_;
  std::optional<GiveServer> givers_;  // none: no client may give
  Commands commands_;
};

}  // namespace haptic
