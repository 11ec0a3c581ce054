// SPDX-License-Identifier: GPL-3.0-or-later
// Peers of hapticd's two sockets that send anything: nothing leaks, and other clients are served.
#include <fcntl.h>
#include <poll.h>
#include <sys/mman.h>
#include <sys/socket.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <cmath>
#include <cstring>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "proto/ipc/control_socket.h"
#include "proto/ipc/handout_message.h"
#include "proto/ipc/handout_server.h"
#include "proto/ipc/segment.h"
#include "proto/ipc/sessions.h"
#include "servo/hapticd/command.h"
#include "tests/fuzz/fuzz_run.h"
#include "tests/fuzz/hostile_input.h"
#include "tests/support/temporary_folder.h"

namespace haptic {
namespace {

using test::FuzzRandom;

constexpr uint64_t kHonestEvery = 64;  // inputs between two well-behaved peers

/// Sends bytes with descriptors, without waiting; drops what the kernel refuses.
void send_with(int socket, const std::string& bytes, const std::vector<int>& descriptors) {
  std::string data = bytes;
  iovec part{data.data(), data.size()};
  std::vector<char> control(CMSG_SPACE(descriptors.size() * sizeof(int)), 0);
  msghdr message{};
  message.msg_iov = &part;
  message.msg_iovlen = 1;
  if (!descriptors.empty()) {
    message.msg_control = control.data();
    message.msg_controllen = control.size();
    cmsghdr* head = CMSG_FIRSTHDR(&message);
    head->cmsg_level = SOL_SOCKET;
    head->cmsg_type = SCM_RIGHTS;
    head->cmsg_len = CMSG_LEN(descriptors.size() * sizeof(int));
    std::memcpy(CMSG_DATA(head), descriptors.data(), descriptors.size() * sizeof(int));
  }
  sendmsg(socket, &message, MSG_DONTWAIT | MSG_NOSIGNAL);
}

/// The descriptors a peer may send.
struct Hands {
  SegmentWriter<SimChannels> segment{1};
  FileDescriptor null{open("/dev/null", O_RDWR | O_CLOEXEC)};
  FileDescriptor unsealed{memfd_create("unsealed", MFD_CLOEXEC)};
  FileDescriptor folder{open("/", O_RDONLY | O_CLOEXEC)};

  std::vector<int> some(FuzzRandom& random) const {
    const std::vector<int> all{segment.fd(), null.get(), unsealed.get(), folder.get()};
    std::vector<int> taken(random.below(3) == 0 ? random.below(250) : random.below(3));
    for (int& fd : taken) fd = random.pick(all);
    return taken;
  }
};

std::string announcement_of(uint64_t generation) {
  Announcement a{kHandoutProtocol, SegmentId::kSim, generation, {}};
  assign(a.name, "sim");
  return std::string(reinterpret_cast<const char*>(&a), sizeof a);
}

/// One message: a valid announcement, a damaged one, or random bytes.
std::string said(FuzzRandom& random, const test::Damage& damage) {
  const std::string good = announcement_of(1 + random.below(50));
  if (random.below(4) == 0) {
    return std::string(random.below(2000), static_cast<char>(random.bits()));
  }
  return random.below(3) == 0 ? damage.apply(good, random) : good;
}

/// hapticd's side of the watch socket, with its own segment and one offered by a child.
struct Watched {
  test::TemporaryRuntimeFolder folder;
  HandoutServer server{"fuzzed"};
  SegmentWriter<ControlChannels> control{1};
  SegmentWriter<SimChannels> sim{1};
  uint64_t offers = 0;

  Watched() {
    server.announce(SegmentId::kControl, 1, ControlChannels::kName, control.fd());
    server.announce(SegmentId::kSim, 1, SimChannels::kName, sim.fd());
  }

  void serve() {
    server.serve([this](const Announcement&, int) { ++offers; });
  }

  /// Whether a silent client still receives hapticd's segment and can read it.
  bool serves_honest_client() {
    const FileDescriptor client = connect_session("fuzzed");
    serve();
    for (;;) {
      ReceivedMessage message = receive_message(client.get());
      if (message.kind != Received::kMessage) return false;
      if (message.announcement.id != SegmentId::kControl) continue;
      return SegmentView<ControlChannels>(std::move(message.fd)).header().generation == 1;
    }
  }
};

}  // namespace

TEST_CASE("fuzz: whatever clients and children send, the next client is handed its segments") {
  std::optional<Watched> watched(std::in_place);
  const Hands hands;
  const test::Damage damage({std::string(4, '\0'), "sim", std::string(64, 'x')});
  REQUIRE(watched->serves_honest_client());
  watched->serve();
  uint64_t offers = 0, count = 0;
  test::FuzzRun fuzz("handout socket", 4, 4000);
  fuzz.run([&](FuzzRandom& random) {
    // a child may offer one segment, from a given generation on; other peers none
    FileDescriptor peer = random.below(2) == 0 ? watched->server.connect_child(SegmentId::kSim, 1)
                                               : connect_session("fuzzed");
    watched->serve();
    for (size_t left = random.below(4); left > 0; --left) {
      send_with(peer.get(), said(random, damage), hands.some(random));
      if (random.below(2) == 0) watched->serve();
    }
    // a peer may close its end with messages unread
    if (random.below(2) == 0) watched->serve();
    peer.reset();
    // one turn for each remaining message, and one for the end
    for (int turn = 0; turn < 5; ++turn) watched->serve();
    if (++count % kHonestEvery != 0) return;
    if (!watched->serves_honest_client()) throw std::runtime_error("nobody is served:\n");
    offers += watched->offers;
    watched.emplace();
  });
  CHECK(offers > 0);
  CHECK(watched->serves_honest_client());
}

namespace {

SessionConfig session_with_everything() {
  return parse_config(
      "[session]\nname = \"fuzz\"\n[device]\nkind = \"simulated-hand\"\n[coupling]\n"
      "stiffness = \"800 N/m\"\n[[object]]\nname = \"b\"\nprimitive = \"box\"\n"
      "extent = [\"1 cm\", \"1 cm\", \"1 cm\"]\n",
      "fuzz.toml");
}

bool is_sound(const ControlFrame& frame) {
  return std::isfinite(frame.translational_stiffness) &&
         std::isfinite(frame.translational_damping) && std::isfinite(frame.rotational_stiffness) &&
         std::isfinite(frame.rotational_damping) && std::isfinite(frame.scene_time_scale);
}

/// hapticd's side of the control socket, answering like the supervisor.
struct Controlled {
  test::TemporaryRuntimeFolder folder;
  HandoutServer watching{"fuzzed"};
  ControlServer server{"fuzzed"};
  SessionConfig config = session_with_everything();
  ControlFrame wanted{};
  uint64_t changes = 0;

  void serve() {
    server.serve([this](uint64_t peer, std::string_view line) {
      const ControlCommand command = apply_command(line, config, wanted);
      changes += command.kind == CommandKind::kChange;
      server.answer(peer, command.kind == CommandKind::kRefused
                              ? std::string(kMistakeAnswer) + command.problem
                              : "ok");
    });
  }
  FileDescriptor connect() const {
    FileDescriptor socket = unix_socket();
    if (!connect_to(socket, folder.path() + "/fuzzed.control")) {
      throw std::runtime_error("the control socket takes nobody:\n");
    }
    return socket;
  }
  /// The pending answer; nothing if there is none.
  static std::optional<std::string> hear(const FileDescriptor& socket) {
    std::string text(kLongestAnswer, '\0');
    const ssize_t n = recv(socket.get(), text.data(), text.size(), MSG_DONTWAIT);
    if (n <= 0) return std::nullopt;
    text.resize(static_cast<size_t>(n));
    return text;
  }
  bool serves_honest_peer() {
    const FileDescriptor socket = connect();
    serve();
    send(socket.get(), "status", 6, MSG_NOSIGNAL);
    serve();
    return hear(socket) == "ok";
  }
};

const std::vector<std::string> kCommands{"status",
                                         "config",
                                         "stop",
                                         "clear-fault",
                                         "arm",
                                         "disarm",
                                         "pause",
                                         "resume",
                                         "set stiffness 500 N/m",
                                         "set damping 2 N·s/m",
                                         "set rotational-stiffness 2 N·m/rad",
                                         "set rotational-damping 1e-3 N·m·s/rad",
                                         "set time-scale 0.5",
                                         "set renderer virtual-proxy3"};
const std::vector<std::string> kCommandWords{"set",
                                             " ",
                                             "renderer",
                                             "voxel",
                                             "nan",
                                             "inf",
                                             "-inf",
                                             "1e400",
                                             "-0",
                                             "1e-320",
                                             "N/m",
                                             "\n",
                                             "\x1b[2J",
                                             std::string(1, '\0'),
                                             "9999999999999999999999",
                                             "kN/mm",
                                             "%s%n",
                                             "\xff"};

}  // namespace

TEST_CASE("fuzz: whatever is said to the control socket is answered in one line") {
  Controlled controlled;
  const test::Damage damage(kCommandWords);
  REQUIRE(controlled.serves_honest_peer());
  uint64_t count = 0;
  test::FuzzRun fuzz("control socket", 5, 8000);
  fuzz.run([&](FuzzRandom& random) {
    const FileDescriptor peer = controlled.connect();
    controlled.serve();
    std::string line = random.pick(kCommands);
    if (random.below(4) != 0) line = damage.apply(line, random);
    if (random.below(16) == 0) line += std::string(random.below(20'000), ' ');
    const int null = STDIN_FILENO;
    if (random.below(8) == 0) {
      send_with(peer.get(), line, {null, null, null});
    } else {
      send(peer.get(), line.data(), line.size(), MSG_NOSIGNAL);
    }
    if (random.below(8) != 0) controlled.serve();
    const auto answer = Controlled::hear(peer);
    if (answer && !test::is_one_line(*answer)) throw std::runtime_error("answer:\n" + *answer);
    if (!is_sound(controlled.wanted)) throw std::runtime_error("a number is not finite:\n");
    if (++count % kHonestEvery == 0 && !controlled.serves_honest_peer()) {
      throw std::runtime_error("the honest peer was not answered:\n");
    }
    if (answer && *answer != "ok") throw std::runtime_error(*answer);
  });
  CHECK(controlled.changes > 0);
  CHECK(controlled.serves_honest_peer());
}

}  // namespace haptic
