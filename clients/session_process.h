// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <sys/types.h>

#include <optional>
#include <string>
#include <vector>

namespace haptic {

/// hapticd as a child of this program: started, awaited, stopped with SIGTERM.
class SessionProcess {
 public:
  /// Starts the hapticd that lies beside this program (or in $HAPTICD_LIBEXEC) with these
  /// arguments; its messages go to our stderr. It stops when we end, however that happens. To be
  /// called by a thread that lives as long as the process. Throws std::runtime_error.
  explicit SessionProcess(const std::vector<std::string>& arguments);

  /// Stops it where that has not been done.
  ~SessionProcess();
  SessionProcess(const SessionProcess&) = delete;
  SessionProcess& operator=(const SessionProcess&) = delete;

  /// Exit code once it has ended (128 + signal when killed), nothing while it runs.
  std::optional<int> exit_code();

  /// SIGTERM, then waits; SIGKILL after five seconds. Returns the exit code.
  int stop();

  pid_t pid() const { return pid_; }

 private:
  pid_t pid_ = -1;
  std::optional<int> code_;
};

}  // namespace haptic
