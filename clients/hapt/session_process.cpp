// SPDX-License-Identifier: GPL-3.0-or-later
#include "clients/hapt/session_process.h"

#include <fcntl.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <stdexcept>

#include "proto/ipc/process.h"
#include "proto/os/programs.h"
#include "proto/os/realtime.h"
#include "proto/os/source_tree.h"

namespace haptic {
namespace {

constexpr int64_t kStopPatience = 5 * kNsPerSecond;  // [ns]; then SIGKILL
constexpr int64_t kPollPeriod = 5'000'000;           // [ns]

}  // namespace

std::string program_path(const std::string& program) {
  const std::string path = program.starts_with('/') ? program : program_folder() + "/" + program;
  if (access(path.c_str(), X_OK) != 0) throw std::runtime_error(cannot_start(path, errno));
  return path;
}

SessionProcess::SessionProcess(const std::string& program,
                               const std::vector<std::string>& arguments,
                               const std::string& output) {
  const std::string path = program_path(program);
  std::vector<std::string> words{path};
  words.insert(words.end(), arguments.begin(), arguments.end());
  std::vector<char*> argv;
  argv.reserve(words.size() + 1);
  for (std::string& word : words) argv.push_back(word.data());
  argv.push_back(nullptr);
  const pid_t parent = getpid();
  pid_ = fork();
  if (pid_ < 0)
    throw std::runtime_error(path + ": cannot be started (" + std::strerror(errno) + ")");
  if (pid_ > 0) return;
  // a session started here must not outlive this program, however it ends
  prctl(PR_SET_PDEATHSIG, SIGTERM);
  if (getppid() != parent) _exit(1);
  if (!output.empty()) {
    // own process group: Ctrl-C reaches only this program, which stops the child in its own order
    setpgid(0, 0);
    const int said = open(output.c_str(), O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0600);
    dup2(said, STDOUT_FILENO);
    dup2(said, STDERR_FILENO);
  }
  execv(path.c_str(), argv.data());
  _exit(127);
}

SessionProcess::~SessionProcess() {
  stop();
}

std::optional<int> SessionProcess::exit_code() {
  int status = 0;
  if (!code_ && waitpid(pid_, &status, WNOHANG) == pid_) {
    code_ = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  }
  return code_;
}

int SessionProcess::stop() {
  send(SIGTERM);
  for (const int64_t start = now_ns(); !exit_code();) {
    if (now_ns() - start > kStopPatience) ::kill(pid_, SIGKILL);
    sleep_until(now_ns() + kPollPeriod);
  }
  return *code_;
}

void SessionProcess::send(int signal) {
  if (!exit_code()) ::kill(pid_, signal);
}

void SessionProcess::kill() {
  send(SIGKILL);
  while (!exit_code()) sleep_until(now_ns() + kPollPeriod / 5);
}

}  // namespace haptic
