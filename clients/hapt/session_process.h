// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <sys/types.h>

#include <optional>
#include <string>
#include <vector>

namespace haptic {

/// Path of hapticd or another of these programs. Throws std::runtime_error if it cannot be started.
std::string program_path(const std::string& program);

/// hapticd or another of these programs as a child process, stopped with SIGTERM.
class SessionProcess {
 public:
  /// Starts the program from the folder of this one (or $HAPTICD_LIBEXEC), or that of a full path.
  /// Its output is appended to the file `output`, and Ctrl-C does not reach it; with an empty name
  /// it shares this program's output and terminal. It is stopped when the calling thread ends, so
  /// that thread must live as long as this process. Throws std::runtime_error.
  SessionProcess(const std::string& program, const std::vector<std::string>& arguments,
                 const std::string& output = "");

  /// Starts hapticd.
  explicit SessionProcess(const std::vector<std::string>& arguments)
      : SessionProcess("hapticd", arguments) {}

  /// Stops it if it still runs.
  ~SessionProcess();
  SessionProcess(const SessionProcess&) = delete;
  SessionProcess& operator=(const SessionProcess&) = delete;

  /// Exit code once it has ended (128 + signal if killed), nothing while it runs.
  std::optional<int> exit_code();

  /// Sends SIGTERM and waits; SIGKILL after five seconds. Returns the exit code.
  int stop();

  /// Sends a signal if it still runs.
  void send(int signal);
  /// Sends SIGKILL and waits for the end.
  void kill();

  pid_t pid() const { return pid_; }

 private:
  pid_t pid_ = -1;
  std::optional<int> code_;
};

}  // namespace haptic
