// SPDX-License-Identifier: GPL-3.0-or-later
#include "servo/hapticd/child_process.h"

#include <fcntl.h>
#include <poll.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <stdexcept>

#include "proto/math/units.h"
#include "proto/os/programs.h"
#include "proto/os/realtime.h"

namespace haptic {
namespace {

/// Runs after fork: only async-signal-safe calls, since the parent has threads.
[[noreturn]] void become(const char* path, char* const* argv, std::span<const int> kept, int said) {
  const sigset_t set = stop_signals();
  sigprocmask(SIG_UNBLOCK, &set, nullptr);
  signal(SIGPIPE, SIG_DFL);
  // own process group: Ctrl-C reaches hapticd alone, which stops the servo first
  setpgid(0, 0);
  dup2(said, STDERR_FILENO);
  for (const int fd : kept) fcntl(fd, F_SETFD, 0);
  execv(path, argv);
  _exit(kExitNoProgram);
}

}  // namespace

sigset_t stop_signals() {
  sigset_t set;
  sigemptyset(&set);
  for (const int signal : {SIGTERM, SIGINT, SIGHUP}) sigaddset(&set, signal);
  return set;
}

void ChildProcess::launch(const std::string& folder, const char* program,
                          std::vector<std::string> words, std::span<const int> kept) {
  words.insert(words.begin(), folder + "/" + program);
  std::vector<char*> argv;
  argv.reserve(words.size() + 1);
  for (std::string& word : words) argv.push_back(word.data());
  argv.push_back(nullptr);
  preparing.clear();
  output.emplace(program);
  const pid_t child = fork();
  if (child == 0) become(argv.front(), argv.data(), kept, output->child_end().get());
  if (child < 0) {
    output.reset();
    throw std::runtime_error(std::string("cannot fork: ") + std::strerror(errno));
  }
  output->child_end().reset();
  pid = child;
  pidfd = FileDescriptor(static_cast<int>(syscall(SYS_pidfd_open, child, 0)));
}

std::optional<int> ChildProcess::ended() {
  int status = 0;
  if (!is_running() || waitpid(pid, &status, WNOHANG) != pid) return std::nullopt;
  forget();
  return status;
}

bool ChildProcess::wait_for_exit(int64_t deadline_ns) {
  if (!is_running()) return true;
  pollfd waiting{pidfd.get(), POLLIN, 0};
  const int64_t left_ns = std::max<int64_t>(deadline_ns - now_ns(), 0);
  if (poll(&waiting, 1, static_cast<int>((left_ns + kMs - 1) / kMs)) <= 0) return false;
  waitpid(pid, nullptr, 0);
  forget();
  return true;
}

void ChildProcess::send(int signal) const {
  if (is_running()) kill(pid, signal);
}

void ChildProcess::end() {
  send(SIGKILL);
  if (is_running()) waitpid(pid, nullptr, 0);
  forget();
}

void ChildProcess::forget() {
  pid = -1;
  pidfd = {};
}

std::string how_it_ended(int status, const std::string& preparing) {
  const std::string what = preparing.empty() ? "" : " while it prepared " + preparing;
  if (WIFSIGNALED(status)) return std::string("was killed: ") + strsignal(WTERMSIG(status)) + what;
  return "ended with exit code " + std::to_string(WEXITSTATUS(status)) + what;
}

}  // namespace haptic
