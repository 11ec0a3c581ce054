// SPDX-License-Identifier: GPL-3.0-or-later
// Waits of processes: one that sleeps, one that is stopped, one that does not exist.
#include "clients/lab/torture/process_waits.h"

#include <pthread.h>
#include <sched.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <fstream>
#include <string>
#include <thread>

#include "clients/lab/support/forked_process.h"
#include "proto/math/units.h"
#include "proto/os/realtime.h"

namespace haptic {
namespace {

/// Repeats an action until it is killed.
class Child {
 public:
  template <typename Do>
  explicit Child(Do do_it) : pid_(fork()) {
    while (pid_ == 0) do_it();
  }
  ~Child() {
    kill(pid_, SIGKILL);
    waitpid(pid_, nullptr, 0);
  }
  pid_t pid() const { return pid_; }
  /// Until its first thread is in that state, with the name of its program in front: "(sleep) S".
  void await(const std::string& state) const {
    std::string line;
    while (line.find(state) == std::string::npos) {
      std::getline(std::ifstream("/proc/" + std::to_string(pid_) + "/stat"), line);
    }
  }

 private:
  pid_t pid_;
};

cpu_set_t this_threads_processors() {
  cpu_set_t set;
  pthread_getaffinity_np(pthread_self(), sizeof set, &set);
  return set;
}

}  // namespace

TEST_CASE("process waits: one that is stopped has no time, one that sleeps waits for nothing") {
  // a program without sanitizer, which would have a thread of its own that wakes
  const Child sleeper([] { execlp("sleep", "sleep", "1000", nullptr); });
  sleeper.await("(sleep) S");
  ProcessWaits waits(sleeper.pid());
  const auto look_for = [&](int n) {
    const int64_t from_ns = now_ns();
    waits.look(from_ns);
    for (int i = 0; i < n; ++i) {
      sleep_until(now_ns() + kMs);
      waits.look(now_ns());
    }
    return held_up(waits.stalls(from_ns), from_ns, now_ns());
  };
  look_for(1);
  CHECK(look_for(20) == 0);
  kill(sleeper.pid(), SIGSTOP);
  sleeper.await("(sleep) T");
  CHECK(look_for(20) >= 20 * kMs);
  kill(sleeper.pid(), SIGCONT);
  sleeper.await("(sleep) S");
  look_for(1);
  CHECK(look_for(20) == 0);
  CHECK(waits.stalls(now_ns()).empty());
}

TEST_CASE("process waits: it waits for a processor on which others run") {
  const cpu_set_t before = this_threads_processors();
  pin_to_processor(0);
  // both always want the same processor
  const Child busy([] {});
  ProcessWaits waits(busy.pid());
  const auto counted = [&] {
    int64_t ran_ns = 0, waited_ns = 0;
    std::ifstream("/proc/" + std::to_string(busy.pid()) + "/schedstat") >> ran_ns >> waited_ns;
    return waited_ns;
  };
  const int64_t from_ns = now_ns();
  waits.look(from_ns);
  const int64_t counted_ns = counted();
  while (counted() < counted_ns + kMs) continue;
  const int64_t waited_ns = counted() - counted_ns;
  const int64_t to_ns = now_ns();
  waits.look(to_ns);
  CHECK(held_up(waits.stalls(from_ns), from_ns, to_ns) >= std::min(waited_ns, to_ns - from_ns));
  pthread_setaffinity_np(pthread_self(), sizeof before, &before);
}

TEST_CASE("process waits: a thread beside the first one counts") {
  const cpu_set_t before = this_threads_processors();
  pin_to_processor(0);
  const Child busy([] {
    std::thread([] {
      for (volatile bool on = true; on;) continue;
    }).join();
  });
  ProcessWaits waits(busy.pid());
  const int64_t from_ns = now_ns();
  while (waits.stalls(from_ns).empty() && now_ns() < from_ns + 20'000 * kMs) waits.look(now_ns());
  CHECK_FALSE(waits.stalls(from_ns).empty());
  pthread_setaffinity_np(pthread_self(), sizeof before, &before);
}

TEST_CASE("process waits: of a process that is not there nothing is known") {
  ProcessWaits waits(-1);
  waits.look(now_ns());
  waits.look(now_ns());
  CHECK(waits.stalls(0).empty());
}

}  // namespace haptic
