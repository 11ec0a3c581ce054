// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <sys/types.h>

#include <optional>
#include <string>
#include <vector>

namespace haptic {

/// hapticd, or another of our programs, as a child of this one: started, awaited, stopped with
/// SIGTERM.
class SessionProcess {
 public:
  /// Starts the program of that name that lies beside this one (or in $HAPTICD_LIBEXEC); what it
  /// says is appended to a file, and Ctrl-C does not reach it; an empty name: it says it where we
  /// do. It stops when we end, however
  /// that happens. To be called by a thread that lives as long as the process. Throws
  /// std::runtime_error.
  SessionProcess(const std::string& program, const std::vector<std::string>& arguments,
                 const std::string& output = "");

  /// The same for hapticd.
  explicit SessionProcess(const std::vector<std::string>& arguments)
      : SessionProcess("hapticd", arguments) {}

  /// Stops it where that has not been done.
  ~SessionProcess();
  SessionProcess(const SessionProcess&) = delete;
  SessionProcess& operator=(const SessionProcess&) = delete;

  /// Exit code once it has ended (128 + signal when killed), nothing while it runs.
  std::optional<int> exit_code();

  /// SIGTERM, then waits; SIGKILL after five seconds. Returns the exit code.
  int stop();

  /// A signal to it, where it has not ended.
  void send(int signal);
  /// SIGKILL, and waits for the end.
  void kill();

  pid_t pid() const { return pid_; }

 private:
  pid_t pid_ = -1;
  std::optional<int> code_;
};

}  // namespace haptic
