// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <sched.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <exception>
#include <memory>
#include <new>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace haptic {

/// A value in memory shared with forked processes. Construct it before the fork.
template <typename T>
class Shared {
 public:
  Shared() {
    void* memory =
        mmap(nullptr, sizeof(T), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
    if (memory == MAP_FAILED) throw std::bad_alloc();
    value_ = new (memory) T{};
  }
  ~Shared() { munmap(value_, sizeof(T)); }
  Shared(const Shared&) = delete;
  T& operator*() const { return *value_; }
  T* operator->() const { return value_; }

 private:
  T* value_;
};

/// A fork of this process that runs one function and exits without running destructors; it dies
/// with its owner. An exception ends it with exit code 1 and its text is kept.
class ForkedProcess {
 public:
  ForkedProcess() = default;
  template <typename Body>
  explicit ForkedProcess(Body body) : said_(std::make_unique<Shared<Text>>()) {
    const pid_t owner = getpid();
    pid_ = fork();
    if (pid_ < 0) throw std::runtime_error("cannot fork");
    if (pid_ > 0) return;
    prctl(PR_SET_PDEATHSIG, SIGKILL);
    // the owner may have died before prctl
    if (getppid() != owner) _exit(1);
    _exit(run(body));
  }
  ForkedProcess(ForkedProcess&& other) noexcept
      : pid_(std::exchange(other.pid_, -1)), said_(std::move(other.said_)) {}
  ForkedProcess& operator=(ForkedProcess&& other) noexcept {
    kill();
    pid_ = std::exchange(other.pid_, -1);
    said_ = std::move(other.said_);
    return *this;
  }
  ~ForkedProcess() { kill(); }

  pid_t pid() const { return pid_; }
  void signal(int number) const {
    if (pid_ > 0) ::kill(pid_, number);
  }
  void kill() {
    signal(SIGKILL);
    wait();
  }
  /// Waits for its end. Returns the status of waitpid, or 0 if it has already been waited for.
  int wait() {
    int status = 0;
    if (pid_ > 0) waitpid(pid_, &status, 0);
    pid_ = -1;
    return status;
  }
  /// Text of the exception that ended it; empty if there was none.
  std::string said() const { return said_ ? std::string((*said_)->data()) : ""; }

 private:
  using Text = std::array<char, 256>;

  template <typename Body>
  int run(Body& body) noexcept {
    try {
      body();
    } catch (const std::exception& e) {
      std::strncpy((*said_)->data(), e.what(), sizeof(Text) - 1);
      return 1;
    } catch (...) {
      // no exception may leave a forked child; its exit code reports it
      return 1;
    }
    return 0;
  }

  pid_t pid_ = -1;
  std::unique_ptr<Shared<Text>> said_;
};

/// The processors this process may use, in order.
inline std::vector<size_t> allowed_processors() {
  cpu_set_t allowed;
  std::vector<size_t> processors;
  if (sched_getaffinity(0, sizeof allowed, &allowed) != 0) return processors;
  for (size_t cpu = 0; cpu < CPU_SETSIZE; ++cpu) {
    if (CPU_ISSET(cpu, &allowed)) processors.push_back(cpu);
  }
  return processors;
}

/// Pins this thread, and what it starts, to a processor; returns an errno, 0 if that is done.
inline int pin_to(size_t processor) {
  cpu_set_t one;
  CPU_ZERO(&one);
  CPU_SET(processor, &one);
  return sched_setaffinity(0, sizeof one, &one) == 0 ? 0 : errno;
}

/// Pins this process to the i-th of its allowed processors, or to the last if there are fewer.
/// False if there is only one or pinning is refused.
inline bool pin_to_processor(size_t i) {
  const std::vector<size_t> allowed = allowed_processors();
  return allowed.size() >= 2 && pin_to(allowed[std::min(i, allowed.size() - 1)]) == 0;
}

}  // namespace haptic
