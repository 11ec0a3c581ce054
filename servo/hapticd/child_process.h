// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <sys/types.h>

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "proto/os/file_descriptor.h"
#include "proto/os/programs.h"
#include "servo/hapticd/log.h"

namespace haptic {

/// The exit code of a child whose program could not be executed.
inline constexpr int kExitNoProgram = 127;

/// The signals that end hapticd. It blocks them and reads them from a descriptor; its children do
/// not.
sigset_t stop_signals();

/// For poll(): the milliseconds until t_ns, rounded up; 0 once it is past.
int poll_ms(int64_t t_ns);

/// A program started by hapticd. It must have ended (wait_for_exit, ended) before this is
/// destroyed.
struct ChildProcess {
  const char* program = "";
  pid_t pid = -1;  // −1: not running
  FileDescriptor pidfd = {};
  FileDescriptor output = {};  // its stderr; not open: it has closed it
  std::string partial = {};    // a line that is not complete yet
  std::string preparing = {};  // the mesh it reported last; empty: none, or its loop runs

  bool is_running() const noexcept { return pid >= 0; }

  /// Starts `folder/program words…`, which inherits the descriptors `kept` and no others. Throws
  /// std::runtime_error or std::system_error.
  void launch(const std::string& folder, const char* program, std::vector<std::string> words,
              std::span<const int> kept);
  /// Wait status of a process that has ended, which is then forgotten; empty while it runs or if
  /// there is none.
  std::optional<int> ended();
  /// Waits for the end and forgets the process; false: still running at the deadline.
  bool wait_for_exit(int64_t deadline_ns);
  void send(int signal) const;
  /// Logs the lines of its stderr, and once it has ended the incomplete one as well.
  void write_output(HapticdLog& log, std::string_view name);
  /// E.g. "haptic-sim was killed: Killed while it prepared thing.obj", "haptic-servo ended with
  /// exit code 2".
  std::string how_it_ended(int status) const;
  /// Sends SIGKILL and waits for the end.
  void end();

 private:
  void write_line(HapticdLog& log, std::string_view name, std::string_view line);
};

}  // namespace haptic
