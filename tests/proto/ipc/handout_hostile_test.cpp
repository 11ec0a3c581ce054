// SPDX-License-Identifier: GPL-3.0-or-later
// Malicious or too many peers at hapticd's sockets.
#include <fcntl.h>
#include <poll.h>
#include <sys/file.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <catch2/catch.hpp>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <string>
#include <thread>
#include <vector>

#include "proto/ipc/attachments.h"
#include "proto/ipc/control_socket.h"
#include "proto/ipc/handout_server.h"
#include "proto/ipc/sessions.h"
#include "proto/ipc/unix_socket.h"
#include "tests/proto/ipc/served.h"
#include "tests/support/temporary_folder.h"

namespace haptic {
namespace {

using test::contains;
using test::serve_until;
using test::TemporaryRuntimeFolder;

constexpr uid_t kStranger = 65534;

size_t open_descriptors() {
  size_t n = 0;
  for ([[maybe_unused]] const auto& entry : std::filesystem::directory_iterator("/proc/self/fd"))
    ++n;
  return n;
}

/// Sends `size` bytes with that many descriptors.
void send_descriptors(int socket, size_t size, size_t count) {
  std::vector<char> bytes(size, 1), control(CMSG_SPACE(count * sizeof(int)), 0);
  iovec data{bytes.data(), bytes.size()};
  msghdr message{};
  message.msg_iov = &data;
  message.msg_iovlen = 1;
  message.msg_control = control.data();
  message.msg_controllen = control.size();
  cmsghdr* part = CMSG_FIRSTHDR(&message);
  part->cmsg_level = SOL_SOCKET;
  part->cmsg_type = SCM_RIGHTS;
  part->cmsg_len = CMSG_LEN(count * sizeof(int));
  const std::vector<int> zeros(count, STDIN_FILENO);
  std::memcpy(CMSG_DATA(part), zeros.data(), count * sizeof(int));
  REQUIRE(sendmsg(socket, &message, MSG_NOSIGNAL) == static_cast<ssize_t>(size));
}

/// Runs the body as another user in a separate process while `meanwhile` is called; returns its
/// exit code.
int as_stranger(const std::function<int()>& body, const std::function<void()>& meanwhile) {
  const pid_t pid = fork();
  if (pid == 0) {
    if (setgid(kStranger) != 0 || setuid(kStranger) != 0) _exit(99);
    try {
      _exit(body());
    } catch (...) {
      _exit(98);
    }
  }
  int status = 0;
  while (waitpid(pid, &status, WNOHANG) == 0) meanwhile();
  return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

bool may_become_stranger() {
  if (geteuid() == 0) return true;
  WARN("SKIPPED: needs root, to become somebody else");
  return false;
}

/// The server's message to a connection before it hangs up; empty if it is served.
std::string refusal_of(const FileDescriptor& socket) {
  Attachments attachments{FileDescriptor(dup(socket.get()))};
  attachments.start();
  const int64_t give_up = now_ns() + kNsPerSecond / 2;
  while (attachments.is_connected() && now_ns() < give_up) sleep_until(now_ns() + 1'000'000);
  return attachments.is_connected() ? "" : attachments.refusal();
}

}  // namespace

TEST_CASE("handout: descriptors that a peer sends are closed, however many come") {
  test::Served server("leak");
  const size_t size = GENERATE(sizeof(Announcement), size_t{5}, size_t{1000});
  const size_t count = GENERATE(size_t{1}, size_t{2}, size_t{3}, size_t{200});
  const size_t before = open_descriptors();
  for (int i = 0; i < 20; ++i) {
    const FileDescriptor client = connect_session("leak");
    REQUIRE(serve_until(server, [&] { return server.n_clients() == 1; }));
    send_descriptors(client.get(), size, count);
    REQUIRE(serve_until(server, [&] { return server.n_clients() == 0; }));
  }
  CAPTURE(size, count);
  CHECK(open_descriptors() == before);
}

TEST_CASE("handout: a child that sends two descriptors at once leaks none and offers nothing") {
  test::Served server("child");
  const FileDescriptor child = server.connect_child(SegmentId::kSim, 1);
  const size_t before = open_descriptors();
  int offers = 0;
  send_descriptors(child.get(), sizeof(Announcement), 2);
  server.serve([&](const Announcement&, int) { ++offers; });
  CHECK(offers == 0);
  // the server's end of the pair is closed with the peer
  CHECK(open_descriptors() == before - 1);
}

TEST_CASE("handout: one user cannot keep others out, and is told that he is one too many") {
  if (!may_become_stranger()) return;
  const TemporaryRuntimeFolder folder;
  std::filesystem::permissions(folder.path(), std::filesystem::perms(0755));
  setenv("HAPTICD_RUNTIME_DIR", folder.path().c_str(), 1);
  HandoutServer server("crowd");
  bool owner_served = false;
  const int refused = as_stranger(
      [] {
        std::vector<FileDescriptor> sockets;
        for (int i = 0; i < 70; ++i) sockets.push_back(connect_session("crowd"));
        // the first to come are served, and hear nothing
        int told = 0;
        for (auto socket = sockets.rbegin(); told < 10 && socket != sockets.rend(); ++socket) {
          pollfd waiting{socket->get(), POLLIN, 0};
          poll(&waiting, 1, 200);
          told += refusal_of(*socket).find("user 65534 already watches this session 16 times") == 0;
        }
        // still connected: now the owner connects
        sleep_until(now_ns() + kNsPerSecond / 2);
        return told;
      },
      [&] {
        server.serve({});
        if (!owner_served && server.n_clients() == 16) {
          std::vector<FileDescriptor> own;
          for (int i = 0; i < 80; ++i) own.push_back(connect_session("crowd"));
          owner_served = serve_until(server, [&] { return server.n_clients() == 96; });
        }
        sleep_until(now_ns() + 100'000);
      });
  CHECK(refused == 10);
  CHECK(owner_served);
}

TEST_CASE("handout: where no descriptor is left nobody is served, and children still are") {
  const TemporaryRuntimeFolder folder;
  const pid_t pid = fork();
  if (pid == 0) {
    // 56 beyond those that are kept for children
    const rlimit few{104 + 2 * kMostEyes, 104 + 2 * kMostEyes};
    if (setrlimit(RLIMIT_NOFILE, &few) != 0) _exit(10);
    HandoutServer server("few");
    // the clients' ends are in a separate process
    const pid_t crowd = fork();
    if (crowd == 0) {
      std::vector<FileDescriptor> sockets;
      for (int i = 0; i < 100; ++i) sockets.push_back(connect_session("few"));
      pause();
    }
    const int64_t until_ns = now_ns() + kNsPerSecond;
    while (now_ns() < until_ns) {
      server.serve({});
      sleep_until(now_ns() + 1'000'000);
    }
    int code = server.n_clients() > 20 && server.n_clients() < 100 ? 0 : 1;
    // no connection stays pending for ever: that would keep the loop busy
    pollfd waiting{server.poll_fd(), POLLIN, 0};
    if (poll(&waiting, 1, 0) != 0) code = 2;
    try {
      const FileDescriptor one = server.connect_child(SegmentId::kSim, 1);
      const FileDescriptor two = server.connect_child(contact_segment(kFirstHand), 1);
      const FileDescriptor three = server.connect_child(servo_segment(kFirstHand), 1);
    } catch (const std::exception&) {
      code = 3;
    }
    kill(crowd, SIGKILL);
    waitpid(crowd, nullptr, 0);
    _exit(code);
  }
  int status = 0;
  waitpid(pid, &status, 0);
  CHECK(WIFEXITED(status));
  CHECK(WEXITSTATUS(status) == 0);
}

TEST_CASE("control socket: a flood by another user delays no command of the owner") {
  if (!may_become_stranger()) return;
  const TemporaryRuntimeFolder folder;
  std::filesystem::permissions(folder.path(), std::filesystem::perms(0755));
  const pid_t flood = fork();
  if (flood == 0) {
    if (setgid(kStranger) != 0 || setuid(kStranger) != 0) _exit(99);
    std::vector<FileDescriptor> kept;
    for (;;) {
      for (const char* end : {".sock", ".control"}) {
        FileDescriptor socket = unix_socket();
        connect_to(socket, folder.path() + "/flooded" + end);
        if (kept.size() < 200) kept.push_back(std::move(socket));
      }
    }
  }
  {
    HandoutServer server("flooded");
    ControlServer commands("flooded");
    std::atomic<bool> ending{false};
    std::thread daemon([&] {
      while (!ending) {
        pollfd waiting[] = {{server.poll_fd(), POLLIN, 0}, {commands.poll_fd(), POLLIN, 0}};
        poll(waiting, 2, 10);
        server.serve({});
        commands.serve([&](uint64_t peer, std::string_view) { commands.answer(peer, "ok"); });
      }
    });
    for (int i = 0; i < 25; ++i) {
      const int64_t asked_ns = now_ns();
      std::string answer;
      try {
        answer = say_to_session("flooded", "pause");
      } catch (const HandoutError& error) {
        answer = error.what();
      }
      CHECK(answer == "ok");
      CHECK(now_ns() - asked_ns < kNsPerSecond);
    }
    ending = true;
    daemon.join();
  }
  kill(flood, SIGKILL);
  waitpid(flood, nullptr, 0);
}

TEST_CASE(
    "handout: nobody but the owner can hold the lock, and who holds it is named for certain") {
  const TemporaryRuntimeFolder folder;
  const std::string path = folder.path() + "/locked.lock";
  const auto message = [] {
    return test::refusal<HandoutError>([] { const HandoutServer second("locked"); });
  };
  {
    const HandoutServer server("locked");
    struct stat status {};
    REQUIRE(stat(path.c_str(), &status) == 0);
    CHECK((status.st_mode & 0777) == 0600);
    CHECK(contains(message(), "hapt stop --session locked"));
  }
  // the lock of a server that is gone, held by another process: no pid is suggested to kill. That
  // pid exists, but its process started later
  std::ofstream(path) << getppid() << " 1";
  const pid_t holder = fork();
  if (holder == 0) {
    const FileDescriptor lock(open(path.c_str(), O_RDONLY));
    flock(lock.get(), LOCK_EX);
    for (;;) pause();
  }
  const auto is_held = [&] {
    const FileDescriptor probe(open(path.c_str(), O_RDONLY | O_CLOEXEC));
    return flock(probe.get(), LOCK_EX | LOCK_NB) != 0;
  };
  CHECK(test::eventually(is_held));
  const std::string what = message();
  CHECK(contains(what, "no running hapticd"));
  CHECK(contains(what, "fuser " + path));
  CHECK_FALSE(contains(what, "kill"));
  kill(holder, SIGKILL);
  waitpid(holder, nullptr, 0);
}

}  // namespace haptic
