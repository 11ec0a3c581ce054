// SPDX-License-Identifier: GPL-3.0-or-later
// Tests for proto/ipc/control_socket.cpp: hapticd's end and its peers, in one or more processes.
#include "proto/ipc/control_socket.h"

#include <poll.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <sys/wait.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <filesystem>
#include <string>
#include <vector>

#include "proto/ipc/handout_server.h"
#include "tests/support/temporary_folder.h"

namespace haptic {
namespace {

/// A peer controlled by the test.
class Peer {
 public:
  explicit Peer(const std::string& path)
      : socket_(::socket(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0)) {
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    path.copy(address.sun_path, sizeof address.sun_path - 1);
    connected_ =
        connect(socket_.get(), reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0;
  }
  bool is_connected() const { return connected_; }
  void say(const std::string& line) const {
    send(socket_.get(), line.data(), line.size(), MSG_NOSIGNAL);
  }
  /// The available text; "-" if there is none, empty if the other end has hung up.
  std::string hear() const {
    pollfd waiting{socket_.get(), POLLIN, 0};
    if (poll(&waiting, 1, 0) <= 0) return "-";
    char text[256];
    const ssize_t n = recv(socket_.get(), text, sizeof text, 0);
    return n > 0 ? std::string(text, static_cast<size_t>(n)) : "";
  }

 private:
  FileDescriptor socket_;
  bool connected_ = false;
};

struct Bench {
  test::TemporaryRuntimeFolder folder;
  ControlServer server{"asked"};
  std::string path = folder.path() + "/asked.control";
  std::vector<std::pair<uint64_t, std::string>> said;

  void serve() {
    server.serve([this](uint64_t peer, std::string_view line) { said.emplace_back(peer, line); });
  }
};

}  // namespace

TEST_CASE("control socket: an answer goes to who asked, however late, and to nobody else",
          "[proto]") {
  Bench b;
  {
    const Peer leaving(b.path);
    b.serve();
    leaving.say("arm");
    b.serve();
    b.serve();
  }
  b.serve();
  REQUIRE(b.said.size() == 1);
  // the next peer may be given the descriptor of the one that left
  const Peer next(b.path);
  b.serve();
  b.server.answer(b.said[0].first, "ok");
  CHECK(next.hear() == "-");
  next.say("disarm");
  b.serve();
  b.serve();
  REQUIRE(b.said.size() == 2);
  CHECK(b.said[1].second == "disarm");
  b.server.answer(b.said[1].first, "done");
  CHECK(next.hear() == "done");
  CHECK(next.hear().empty());
}

TEST_CASE("control socket: peers that say nothing keep nobody out", "[proto]") {
  Bench b;
  std::vector<std::unique_ptr<Peer>> silent;
  for (int i = 0; i < 40; ++i) {
    silent.push_back(std::make_unique<Peer>(b.path));
    REQUIRE(silent.back()->is_connected());
    b.serve();
  }
  const Peer speaking(b.path);
  b.serve();
  speaking.say("disarm");
  b.serve();
  b.serve();
  REQUIRE(b.said.size() == 1);
  b.server.answer(b.said[0].first, "ok");
  CHECK(speaking.hear() == "ok");
}

TEST_CASE("control socket: who may not control cannot connect, and is told why", "[proto]") {
  if (geteuid() != 0) {
    WARN("SKIPPED: needs root, to become somebody else");
    return;
  }
  Bench b;
  const HandoutServer watched("asked");
  std::filesystem::permissions(b.folder.path(), std::filesystem::perms(0755));
  const pid_t other = fork();
  if (other == 0) {
    constexpr uid_t kNobody = 65534;
    if (setgid(kNobody) != 0 || setuid(kNobody) != 0) _exit(3);
    const Peer peer(b.path);
    const std::string told = say_to_session("asked", "pause");
    _exit(!peer.is_connected() && told.find("error: only user 0 and root") == 0 ? 0 : 1);
  }
  int status = 0;
  while (waitpid(other, &status, WNOHANG) == 0) {
    b.serve();
    usleep(1000);
  }
  CHECK(WIFEXITED(status));
  CHECK(WEXITSTATUS(status) == 0);
  CHECK(b.said.empty());
}

}  // namespace haptic
