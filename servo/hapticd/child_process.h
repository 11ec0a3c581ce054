// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <sys/types.h>

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "proto/os/file_descriptor.h"
#include "proto/os/programs.h"
#include "servo/hapticd/child_output.h"

namespace haptic {

/// The exit code of a child whose program could not be executed.
inline constexpr int kExitNoProgram = 127;

/// The signals that end hapticd: blocked in it and read from a descriptor, not in its children.
sigset_t stop_signals();

/// A program that hapticd has started. It must end (wait_for_exit, ended) before this does.
struct ChildProcess {
  pid_t pid = -1;  // −1: not running
  FileDescriptor pidfd = {};
  std::optional<ChildOutput> output = {};
  std::string preparing = {};  // what it said last that it prepares; empty: nothing, or it runs

  bool is_running() const noexcept { return pid >= 0; }
  /// Where what it says is to be polled; −1: it says nothing any more.
  int output_fd() const noexcept { return output ? output->poll_fd() : -1; }

  /// Starts `folder/program words…`, which inherits `kept` and no other descriptor. Throws
  /// std::runtime_error or std::system_error: no process, no descriptor.
  void launch(const std::string& folder, const char* program, std::vector<std::string> words,
              std::span<const int> kept);
  /// Its wait status once it has ended, and forgets it; nothing while it runs, or where none does.
  std::optional<int> ended();
  /// Waits until it has ended and forgets it; false: it has not in time.
  bool wait_for_exit(int64_t deadline_ns);
  void send(int signal) const;
  /// SIGKILL, and waits for its end.
  void end();

 private:
  void forget();
};

/// In words: "was killed: Killed while it prepared thing.obj", "ended with exit code 2".
std::string how_it_ended(int status, const std::string& preparing);

}  // namespace haptic
