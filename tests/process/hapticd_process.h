// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <csignal>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "proto/ipc/process.h"
#include "proto/os/programs.h"
#include "tests/support/torture_scale.h"

namespace haptic::test {

/// The folder of the programs under test: that of the test itself.
std::filesystem::path program_folder();

/// Whether a process with that pid exists and has not ended.
inline bool is_alive(uint64_t pid) {
  return is_running(static_cast<pid_t>(pid));
}

/// A running program with its output in a file; it is stopped with its owner.
class ProgramProcess {
 public:
  ProgramProcess(const std::string& name, std::vector<std::string> arguments,
                 const std::string& folder);
  ~ProgramProcess();
  ProgramProcess(const ProgramProcess&) = delete;

  void send(int signal) const;
  pid_t pid() const { return pid_; }

  /// Waits for the end; −signal if killed, −1000 on timeout.
  int exit_code();

  std::string log() const;
  bool said(const std::string& part) const { return log().find(part) != std::string::npos; }

 private:
  std::string log_path_;
  pid_t pid_ = -1;
};

struct HapticdProcess : ProgramProcess {
  HapticdProcess(std::vector<std::string> arguments, const std::string& folder)
      : ProgramProcess("hapticd", std::move(arguments), folder) {}
};

}  // namespace haptic::test
