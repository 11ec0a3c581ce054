// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <fcntl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "proto/process.h"
#include "proto/realtime.h"

namespace haptic::test {

inline constexpr int64_t kPatienceNs = 60 * kNsPerSecond;  // only a hang takes this long

/// Looks every millisecond until the condition holds; false after a minute.
template <typename Condition>
bool eventually(Condition holds) {
  const int64_t give_up = now_ns() + kPatienceNs;
  while (!holds()) {
    if (now_ns() > give_up) return false;
    sleep_until(now_ns() + 1'000'000);
  }
  return true;
}

/// Where the programs under test lie: beside the test itself.
inline std::filesystem::path program_folder() {
  return std::filesystem::read_symlink("/proc/self/exe").parent_path();
}

/// Whether a process of that number exists and has not ended.
inline bool is_alive(uint64_t pid) {
  return is_running(static_cast<pid_t>(pid));
}

/// A running program with what it says in a file. Told to stop with its owner.
class ProgramProcess {
 public:
  ProgramProcess(const std::string& name, std::vector<std::string> arguments,
                 const std::string& folder)
      : log_path_(folder + "/log." + std::to_string(now_ns())) {
    const std::string program = program_folder() / name;
    std::vector<char*> argv{const_cast<char*>(program.c_str())};
    for (std::string& word : arguments) argv.push_back(word.data());
    argv.push_back(nullptr);
    pid_ = fork();
    if (pid_ < 0) throw std::runtime_error("cannot fork");
    if (pid_ != 0) return;
    const int log = open(log_path_.c_str(), O_WRONLY | O_CREAT | O_APPEND, 0600);
    dup2(log, STDOUT_FILENO);
    dup2(log, STDERR_FILENO);
    execv(program.c_str(), argv.data());
    _exit(127);
  }
  ~ProgramProcess() {
    if (pid_ > 0) {
      send(SIGTERM);
      exit_code();
    }
  }
  ProgramProcess(const ProgramProcess&) = delete;

  void send(int signal) const { kill(pid_, signal); }
  pid_t pid() const { return pid_; }

  /// Waits for the end; −signal when it was killed, −1000 when it does not come.
  int exit_code() {
    int status = 0;
    const bool ended = eventually([&] { return waitpid(pid_, &status, WNOHANG) == pid_; });
    if (!ended) {
      kill(pid_, SIGKILL);
      waitpid(pid_, nullptr, 0);
    }
    pid_ = -1;
    if (!ended) return -1000;
    return WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status);
  }

  std::string log() const {
    std::ostringstream text;
    text << std::ifstream(log_path_).rdbuf();
    return text.str();
  }
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
