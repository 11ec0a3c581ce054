// SPDX-License-Identifier: GPL-3.0-or-later
#include "servo/hapticd/child_process.h"

#include <fcntl.h>
#include <poll.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <stdexcept>
#include <system_error>
#include <utility>

#include "proto/ipc/process.h"
#include "proto/math/units.h"
#include "proto/os/programs.h"
#include "proto/os/realtime.h"

namespace haptic {
namespace {

constexpr size_t kLongestLine = 16 << 10;  // [bytes]; longer lines are passed on in pieces

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

int poll_ms(int64_t t_ns) {
  return static_cast<int>((std::max<int64_t>(t_ns - now_ns(), 0) + kMs - 1) / kMs);
}

void ChildProcess::launch(const std::string& folder, const char* new_program,
                          std::vector<std::string> words, std::span<const int> kept) {
  program = new_program;
  words.insert(words.begin(), folder + "/" + program);
  std::vector<char*> argv;
  for (std::string& word : words) argv.push_back(word.data());
  argv.push_back(nullptr);
  preparing.clear();
  partial.clear();
  std::array<int, 2> ends{};
  if (pipe2(ends.data(), O_CLOEXEC) != 0) {
    throw std::system_error(errno, std::generic_category(), "cannot make a pipe");
  }
  output = FileDescriptor(ends[0]);
  const FileDescriptor child_end(ends[1]);
  fcntl(output.get(), F_SETFL, O_NONBLOCK);
  const pid_t child = fork();
  if (child == 0) become(argv.front(), argv.data(), kept, child_end.get());
  if (child < 0) {
    output.reset();
    throw std::runtime_error(std::string("cannot fork: ") + std::strerror(errno));
  }
  pid = child;
  pidfd = FileDescriptor(static_cast<int>(syscall(SYS_pidfd_open, child, 0)));
}

std::optional<int> ChildProcess::ended() {
  int status = 0;
  if (!is_running()) return std::nullopt;
  // one that somebody else has waited for is gone too
  const pid_t waited = waitpid(pid, &status, WNOHANG);
  if (waited != pid && !(waited < 0 && errno == ECHILD)) return std::nullopt;
  pid = -1;
  pidfd = {};
  return status;
}

bool ChildProcess::wait_for_exit(int64_t deadline_ns) {
  pollfd waiting{pidfd.get(), POLLIN, 0};
  if (is_running()) poll(&waiting, 1, poll_ms(deadline_ns));
  return !is_running() || ended().has_value();
}

void ChildProcess::send(int signal) const {
  if (is_running()) kill(pid, signal);
}

void ChildProcess::end() {
  send(SIGKILL);
  while (!wait_for_exit(now_ns() + kNsPerSecond)) {
  }
}

void ChildProcess::write_output(HapticdLog& log, std::string_view name) {
  std::array<char, 4096> bytes;
  while (output.is_open()) {
    const ssize_t n = read(output.get(), bytes.data(), bytes.size());
    if (n < 0 && errno == EINTR) continue;
    if (n == 0) output.reset();
    if (n <= 0) break;
    partial.append(bytes.data(), static_cast<size_t>(n));
    for (size_t end = 0; (end = partial.find('\n')) != std::string::npos;) {
      write_line(log, name, std::string_view(partial).substr(0, end));
      partial.erase(0, end + 1);
    }
    if (partial.size() > kLongestLine) write_line(log, name, std::exchange(partial, ""));
  }
  // nothing will complete it
  if (!is_running()) write_line(log, name, std::exchange(partial, ""));
}

/// Without the child's own "program: ".
void ChildProcess::write_line(HapticdLog& log, std::string_view name, std::string_view line) {
  const std::string prefix = std::string(program) + ": ";
  if (line.starts_with(prefix)) line.remove_prefix(prefix.size());
  if (line.empty()) return;
  if (line.starts_with(kPreparing)) preparing = line.substr(kPreparing.size());
  const auto [level, text] = level_of_line(line);
  log.write(level, name, std::string(text));
}

std::string ChildProcess::how_it_ended(int status) const {
  const std::string how = WIFSIGNALED(status)
                              ? std::string(" was killed: ") + strsignal(WTERMSIG(status))
                              : " ended with exit code " + std::to_string(WEXITSTATUS(status));
  return program + how + (preparing.empty() ? "" : " while it prepared " + preparing);
}

}  // namespace haptic
