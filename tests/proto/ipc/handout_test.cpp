// SPDX-License-Identifier: GPL-3.0-or-later
#include "proto/ipc/attachments.h"
#include "proto/ipc/handout_server.h"
#include "proto/ipc/sessions.h"

#include <fcntl.h>
#include <poll.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <csignal>
#include <fstream>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include "tests/proto/ipc/served.h"
#include "tests/support/temporary_folder.h"

namespace haptic {
namespace {

using test::contains;
using test::refusal;
using test::serve_until;
using test::TemporaryRuntimeFolder;
using SimRing = RingSource<&SimChannels::frames>;

constexpr uint64_t kSimSlots = decltype(SimChannels::frames)::kCapacity;

void publish(SegmentWriter<SimChannels>& writer, uint64_t first, uint64_t count) {
  SceneFrame frame{};
  for (uint64_t seq = first; seq < first + count; ++seq) {
    frame.seq = seq;
    writer.channels().frames.publish(frame);
  }
}

void announce(HandoutServer& server, SegmentWriter<SimChannels>& writer) {
  server.announce(SegmentId::kSim, writer.header().generation, "sim", writer.fd());
}

/// A client with its own connection that reads the scene frames.
struct Caller {
  Attachments attachments;
  SimRing frames;
  explicit Caller(const std::string& session, Start start = Start::kOldest)
      : attachments(connect_session(session)),
        frames(attachments.ring<&SimChannels::frames>(start)) {
    attachments.start();
  }
};

/// Forks a writer that publishes frames numbered from 0 without end; stop it by kill().
class ForkedWriter {
 public:
  ForkedWriter(FileDescriptor socket, uint64_t generation) {
    pid_ = fork();
    REQUIRE(pid_ >= 0);
    if (pid_ != 0) return;
    SegmentWriter<SimChannels> writer(generation);
    offer_segment(socket.get(), SegmentId::kSim, generation, "sim", writer.fd());
    for (uint64_t seq = 0;; ++seq) publish(writer, seq, 1);
  }
  ~ForkedWriter() { kill(); }
  ForkedWriter(const ForkedWriter&) = delete;
  void kill() {
    if (pid_ > 0) {
      ::kill(pid_, SIGKILL);
      waitpid(pid_, nullptr, 0);
    }
    pid_ = -1;
  }

 private:
  pid_t pid_ = -1;
};

}  // namespace

TEST_CASE("handout: a client gets what was announced before and after it came") {
  test::Served server("early");
  SegmentWriter<SimChannels> sim(1);
  SegmentWriter<ControlChannels> control(1);
  announce(server, sim);
  Attachments attachments(connect_session("early"));
  auto frames = attachments.source<SimChannels>();
  auto controls = attachments.source<ControlChannels>();
  attachments.start();
  CHECK(serve_until(server, [&] { return frames.channels() != nullptr; }));
  CHECK(controls.channels() == nullptr);
  server.announce(SegmentId::kControl, 1, "control", control.fd());
  CHECK(serve_until(server, [&] { return controls.channels() != nullptr; }));
  CHECK(frames.generation() == 1);
  CHECK(frames.header()->pid == uint64_t(getpid()));
}

TEST_CASE("handout: a late joiner starts at the newest item, or at the oldest that is still safe") {
  test::Served server("late");
  SegmentWriter<SimChannels> writer(1);
  const uint64_t before = GENERATE(3u, kSimSlots, 5 * kSimSlots);
  publish(writer, 0, before);
  announce(server, writer);
  Caller newest("late", Start::kNewest), oldest("late", Start::kOldest);
  SceneFrame out{};
  REQUIRE(serve_until(server, [&] { return oldest.frames.next(out); }));
  const uint64_t reach = kSimSlots - kSimSlots / 8;
  CHECK(out.seq == (before > reach ? before - reach : 0));
  REQUIRE(serve_until(server,
                      [&] { return newest.frames.next(out) || newest.frames.generation() == 1; }));
  CHECK_FALSE(newest.frames.next(out));
  publish(writer, before, 1);
  REQUIRE(newest.frames.next(out));
  CHECK(out.seq == before);
  // items from before its connection do not count as lost
  CHECK(newest.frames.lost() == 0);
  CHECK(oldest.frames.lost() == 0);
}

TEST_CASE("handout: the old writer's items are read to the end before its successor's") {
  test::Served server("restart");
  SegmentWriter<SimChannels> first(1), second(2), third(3);
  announce(server, first);
  Caller client("restart");
  SceneFrame out{};
  publish(first, 100, 1);
  REQUIRE(serve_until(server, [&] { return client.frames.next(out); }));
  CHECK(out.seq == 100);

  publish(first, 101, 2);
  publish(second, 200, 1);
  publish(third, 300, 1);
  announce(server, second);
  announce(server, second);  // again: no change
  announce(server, third);
  std::vector<uint64_t> seen;
  REQUIRE(serve_until(server, [&] {
    while (client.frames.next(out)) seen.push_back(out.seq);
    return seen.size() >= 4;
  }));
  CHECK(seen == std::vector<uint64_t>{101, 102, 200, 300});
  CHECK(client.frames.lost() == 0);
  CHECK(client.frames.generation() == 3);

  // an old generation never replaces a newer one
  announce(server, first);
  Caller late("restart");
  REQUIRE(serve_until(server, [&] { return late.frames.next(out); }));
  CHECK(out.seq == 300);
}

TEST_CASE(
    "handout: an announcement that comes twice, or under a wrong generation, changes nothing") {
  int ends[2];
  REQUIRE(socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0, ends) == 0);
  const FileDescriptor sender(ends[0]);
  std::atomic<int> errors{0};
  Attachments attachments(FileDescriptor(ends[1]),
                          {.on_error = [&](const std::string&) { ++errors; }});
  SimRing frames = attachments.ring<&SimChannels::frames>(Start::kOldest);
  auto controls = attachments.source<ControlChannels>();
  attachments.start();
  SegmentWriter<SimChannels> first(1), second(2);
  SegmentWriter<ControlChannels> last(1);
  publish(first, 10, 1);
  publish(second, 20, 1);
  offer_segment(sender.get(), SegmentId::kSim, 1, "sim", first.fd());
  offer_segment(sender.get(), SegmentId::kSim, 1, "sim", first.fd());
  offer_segment(sender.get(), SegmentId::kSim, 5, "sim", first.fd());
  offer_segment(sender.get(), SegmentId::kSim, 2, "sim", second.fd());
  offer_segment(sender.get(), SegmentId::kSim, 1, "sim", first.fd());
  // announcements are processed in order: once this one is there, so are the others
  offer_segment(sender.get(), SegmentId::kControl, 1, "control", last.fd());
  CHECK(test::eventually([&] { return controls.channels() != nullptr; }));
  std::vector<uint64_t> seen;
  for (SceneFrame out; frames.next(out);) seen.push_back(out.seq);
  CHECK(seen == std::vector<uint64_t>{10, 20});
  CHECK(errors == 1);
}

TEST_CASE("handout: a client of another version is told so, and does not wait for ever") {
  test::Served server("version");
  SegmentWriter<SimChannels> other(1);
  const_cast<SegmentHeader&>(other.header()).abi_major = kAbiMajor + 1;
  announce(server, other);
  Caller client("version");
  REQUIRE(serve_until(server, [&] { return !client.attachments.is_connected(); }));
  CHECK(contains(client.attachments.refusal(), "segment 'sim': version "));
  CHECK(contains(client.attachments.refusal(), "this program speaks"));
}

TEST_CASE("handout: losses are exact across generations") {
  test::Served server("losses");
  SegmentWriter<SimChannels> first(1), second(2);
  announce(server, first);
  Caller client("losses");
  SceneFrame out{};
  publish(first, 0, 1);
  REQUIRE(serve_until(server, [&] { return client.frames.next(out); }));
  publish(first, 1, 3 * kSimSlots);
  publish(second, 0, 2 * kSimSlots);
  announce(server, second);
  uint64_t got = 1;
  REQUIRE(serve_until(server, [&] {
    while (client.frames.next(out)) ++got;
    return client.frames.generation() == 2 && out.seq == 2 * kSimSlots - 1;
  }));
  CHECK(got + client.frames.lost() == 1 + 3 * kSimSlots + 2 * kSimSlots);
}

TEST_CASE("handout: the latest item survives its writer until there is a newer one") {
  test::Served server("latest");
  SegmentWriter<SimChannels> first(1), second(2);
  publish(first, 0, 5);
  announce(server, first);
  Caller client("latest");
  SceneFrame out{};
  REQUIRE(serve_until(server, [&] { return client.frames.latest(out); }));
  CHECK(out.seq == 4);
  CHECK_FALSE(client.frames.latest(out));
  publish(first, 5, 1);
  announce(server, second);
  REQUIRE(serve_until(server, [&] {
    client.frames.latest(out);
    return client.frames.generation() == 2;
  }));
  CHECK(out.seq == 5);
  // the source has moved on, the item in hand is still the old writer's
  CHECK(client.frames.item_generation() == 1);
  publish(second, 50, 2);
  REQUIRE(client.frames.latest(out));
  CHECK(out.seq == 51);
  CHECK(client.frames.item_generation() == 2);
}

TEST_CASE("handout: kill -9 of a writer at any moment loses nothing uncounted") {
  const TemporaryRuntimeFolder folder;
  std::mt19937_64 random(5);
  for (int round = 0; round < 12; ++round) {
    HandoutServer server("killed");
    // hapticd's own view of each generation says how many items there were
    std::vector<std::unique_ptr<SegmentView<SimChannels>>> views;
    const auto take = [&](const Announcement&, int fd) {
      views.push_back(std::make_unique<SegmentView<SimChannels>>(reopen_read_only(fd)));
    };
    ForkedWriter first(server.connect_child(SegmentId::kSim, 1), 1);
    while (views.size() < 1) server.serve(take);
    while (views[0]->channels().frames.published() == 0) sleep_until(now_ns() + 1000);

    sleep_until(now_ns() + int64_t(random() % 2'000'000));
    first.kill();
    Attachments attachments(connect_session("killed"));
    SimRing frames = attachments.ring<&SimChannels::frames>(Start::kOldest);
    const uint64_t first_end = views[0]->channels().frames.published();
    const uint64_t reach = kSimSlots - kSimSlots / 8;
    const uint64_t begin = first_end > reach ? first_end - reach : 0;

    ForkedWriter second(server.connect_child(SegmentId::kSim, 2), 2);
    attachments.start();
    while (views.size() < 2) server.serve(take);
    SceneFrame out{};
    uint64_t got = 0;
    uint64_t got_of_first = 0;
    const int64_t stop = now_ns() + int64_t(random() % 2'000'000);
    const auto drain = [&] {
      while (frames.next(out)) {
        ++got;
        got_of_first += frames.generation() == 1;
      }
    };
    while (now_ns() < stop || frames.generation() != 2) {
      server.serve(take);
      drain();
    }
    second.kill();
    drain();
    CAPTURE(round, first_end, begin, got, frames.lost());
    // a killed writer may have spoilt one slot, far from begin
    CHECK((got_of_first == 0 || got_of_first == first_end - begin));
    const uint64_t from = got_of_first == 0 ? 0 : first_end - begin;
    CHECK(got + frames.lost() == from + views[1]->channels().frames.published());
  }
}

TEST_CASE("handout: a generation is unmapped once its reader has gone on, not before") {
  test::Served server("retire");
  SegmentWriter<SimChannels> first(1), second(2);
  publish(first, 1, 1);
  announce(server, first);
  Caller client("retire");
  SceneFrame out{};
  REQUIRE(serve_until(
      server, [&] { return client.frames.header() != nullptr || client.frames.next(out); }));
  const auto n_mapped = [] {
    std::ifstream maps("/proc/self/maps");
    int count = 0;
    for (std::string line; std::getline(maps, line);) {
      count += contains(line, "haptic-sim") && contains(line, "r--s");
    }
    return count;
  };
  CHECK(n_mapped() == 1);
  announce(server, second);
  REQUIRE(serve_until(server, [&] { return n_mapped() == 2; }));
  // it is mapped shortly before it is linked in: poll until the reader has moved on
  CHECK(serve_until(server, [&] {
    client.frames.next(out);
    return n_mapped() == 1;
  }));
  publish(second, 7, 1);
  REQUIRE(client.frames.next(out));
  CHECK(out.seq == 7);
}

TEST_CASE("handout: a stuck client is dropped and the others are served") {
  test::Served server("stuck");
  SegmentWriter<ContactChannels> contact(1);
  const FileDescriptor stuck = connect_session("stuck");
  Attachments attachments(connect_session("stuck"));
  auto controls = attachments.source<ControlChannels>();
  attachments.start();
  REQUIRE(serve_until(server, [&] { return server.n_clients() == 2; }));
  uint64_t generation = 0;
  const auto good_has = [&](uint64_t wanted) {
    while (controls.advance()) {
    }
    return controls.generation() == wanted;
  };
  // in batches much larger than a socket buffer: the good client keeps up, the other's fills
  for (uint64_t batch = 1; batch < 500 && server.n_clients() == 2; ++batch) {
    for (int i = 0; i < 20; ++i) {
      server.announce(contact_segment(kFirstHand), ++generation, ContactChannels::kName,
                      contact.fd());
    }
    const SegmentWriter<ControlChannels> control(batch);
    server.announce(SegmentId::kControl, batch, "control", control.fd());
    REQUIRE(serve_until(server, [&] { return good_has(batch); }));
  }
  CHECK(server.n_clients() == 1);
  CHECK(attachments.is_connected());
}

TEST_CASE("handout: what clients draw goes to clients alone, until it is withdrawn") {
  test::Served server("drawn");
  SegmentWriter<SimChannels> sim(1);
  const auto drawn = std::make_unique<SegmentWriter<DrawChannels>>(1, 2);
  const auto attach = [](Attachments& one) {
    auto rings = std::pair(one.source<DrawChannels>(2), one.source<SimChannels>());
    one.start();
    return rings;
  };
  Attachments child(server.connect_child(SegmentId::kControl, 1));
  Attachments early(connect_session("drawn"));
  auto [child_drawn, child_sim] = attach(child);
  auto [early_drawn, early_sim] = attach(early);
  REQUIRE(serve_until(server, [&] { return server.n_clients() == 1; }));
  server.announce(DrawChannels::id(2), 1, "draw2", drawn->fd());
  server.announce(SegmentId::kSim, 1, "sim", sim.fd());
  CHECK(serve_until(server, [&] { return early_drawn.channels() != nullptr; }));
  // a child that comes later, and a client
  Attachments second(server.connect_child(SegmentId::kControl, 1));
  Attachments late(connect_session("drawn"));
  auto [second_drawn, second_sim] = attach(second);
  auto [late_drawn, late_sim] = attach(late);
  CHECK(serve_until(server, [&] { return late_drawn.channels() != nullptr; }));
  // sim was announced after it
  CHECK(serve_until(server, [&] { return child_sim.channels() && second_sim.channels(); }));
  CHECK(child_drawn.channels() == nullptr);
  CHECK(second_drawn.channels() == nullptr);
  server.withdraw(DrawChannels::id(2));
  Attachments after(connect_session("drawn"));
  auto [after_drawn, after_sim] = attach(after);
  CHECK(serve_until(server, [&] { return after_sim.channels() != nullptr; }));
  CHECK(after_drawn.channels() == nullptr);
}

TEST_CASE("handout: only a child may offer a segment, and only its own") {
  test::Served server("offers");
  SegmentWriter<SimChannels> writer(4);
  int offers = 0;
  const auto count = [&](const Announcement&, int) { ++offers; };

  const FileDescriptor client = connect_session("offers");
  REQUIRE(serve_until(server, [&] { return server.n_clients() == 1; }));
  offer_segment(client.get(), SegmentId::kSim, 4, "sim", writer.fd());
  server.serve(count);
  CHECK(offers == 0);
  CHECK(server.n_clients() == 0);

  const FileDescriptor other = server.connect_child(contact_segment(kFirstHand), 4);
  offer_segment(other.get(), SegmentId::kSim, 4, "sim", writer.fd());
  const FileDescriptor stale = server.connect_child(servo_segment(kFirstHand), 5);
  offer_segment(stale.get(), servo_segment(kFirstHand), 4, ServoChannels::kName, writer.fd());
  server.serve(count);
  CHECK(offers == 0);

  const FileDescriptor child = server.connect_child(SegmentId::kSim, 4);
  offer_segment(child.get(), SegmentId::kSim, 4, "sim", writer.fd());
  server.serve(count);
  CHECK(offers == 1);
}

TEST_CASE(
    "handout: a second writer of a segment is connected beside the first until that is dead") {
  test::Served server("spare");
  SegmentWriter<SimChannels> first(1), second(2);
  uint64_t newest = 0;
  const auto note = [&](const Announcement& offer, int) { newest = offer.generation; };
  const FileDescriptor one = server.connect_child(SegmentId::kSim, 1);
  offer_segment(one.get(), SegmentId::kSim, 1, "sim", first.fd());
  server.serve(note);
  CHECK(newest == 1);
  const FileDescriptor two = server.connect_child(SegmentId::kSim, 2);
  server.forget_children(SegmentId::kSim, 1);
  const auto is_connected = [](const FileDescriptor& end) {
    pollfd peer{end.get(), 0, 0};
    return poll(&peer, 1, 0) == 0;
  };
  CHECK(is_connected(one));
  server.forget_children(SegmentId::kSim, 2);
  CHECK_FALSE(is_connected(one));
  CHECK(is_connected(two));
  offer_segment(two.get(), SegmentId::kSim, 2, "sim", second.fd());
  server.serve(note);
  CHECK(newest == 2);
}

TEST_CASE("handout: junk from a client costs that client its connection") {
  test::Served server("junk");
  const FileDescriptor client = connect_session("junk");
  REQUIRE(serve_until(server, [&] { return server.n_clients() == 1; }));
  REQUIRE(send(client.get(), "hello", 5, MSG_NOSIGNAL) == 5);
  CHECK(serve_until(server, [&] { return server.n_clients() == 0; }));
}

TEST_CASE("handout: a client that leaves is forgotten, one that is told so knows it") {
  const TemporaryRuntimeFolder folder;
  auto server = std::make_unique<HandoutServer>("leave");
  {
    const FileDescriptor client = connect_session("leave");
    REQUIRE(serve_until(*server, [&] { return server->n_clients() == 1; }));
  }
  CHECK(serve_until(*server, [&] { return server->n_clients() == 0; }));
  std::atomic<bool> closed{false};
  Attachments attachments(connect_session("leave"), {.on_closed = [&] { closed = true; }});
  attachments.start();
  REQUIRE(serve_until(*server, [&] { return server->n_clients() == 1; }));
  server.reset();
  CHECK(test::eventually([&] { return closed.load(); }));
  CHECK_FALSE(attachments.is_connected());
}

TEST_CASE("handout: a second server of the same name is told which process is in the way") {
  const TemporaryRuntimeFolder folder;
  auto first = std::make_unique<HandoutServer>("twin");
  const std::string what = refusal<HandoutError>([] { const HandoutServer second("twin"); });
  CHECK(contains(what, "'twin' runs already"));
  CHECK(contains(what, "pid " + std::to_string(getpid())));
  CHECK(contains(what, "--session"));
  const HandoutServer other("other");
  first.reset();
  CHECK_NOTHROW(HandoutServer("twin"));
}

TEST_CASE("handout: the socket a killed server left behind is replaced") {
  const TemporaryRuntimeFolder folder;
  const pid_t pid = fork();
  if (pid == 0) {
    const HandoutServer server("phoenix");
    for (;;) pause();
  }
  const std::string socket = folder.path() + "/phoenix.sock";
  CHECK(test::eventually(
      [&] { return access(socket.c_str(), F_OK) == 0 && !running_sessions().empty(); }));
  kill(pid, SIGKILL);
  waitpid(pid, nullptr, 0);
  CHECK(access(socket.c_str(), F_OK) == 0);
  CHECK(running_sessions().empty());
  HandoutServer server("phoenix");
  CHECK(running_sessions() == std::vector<std::string>{"phoenix"});
}

TEST_CASE("handout: a client that finds no session is told what runs and how to start one") {
  const TemporaryRuntimeFolder folder;
  CHECK(contains(refusal<HandoutError>([] { connect_session("absent"); }),
                 "no session 'absent' is running (looked in "));
  CHECK(contains(refusal<HandoutError>([] { connect_session(""); }), "hapticd CONFIG.toml"));
  const HandoutServer one("one");
  CHECK_NOTHROW(connect_session(""));
  const HandoutServer two("two");
  const std::string what = refusal<HandoutError>([] { connect_session("absent"); });
  CHECK(contains(what, "no session 'absent'"));
  CHECK(contains(what, "running: one, two"));
  CHECK(contains(what, "hapticd CONFIG.toml --session absent"));
  CHECK(contains(refusal<HandoutError>([] { connect_session(""); }),
                 "several sessions are running (one, two); choose one, as --session one"));
}

TEST_CASE("handout: names that are no file names are refused") {
  const TemporaryRuntimeFolder folder;
  const std::string name =
      GENERATE("", "../up", "a b", "a/b", "0123456789012345678901234567890123");
  CHECK(contains(refusal<HandoutError>([&] { const HandoutServer server(name); }),
                 "cannot be the name"));
}

TEST_CASE("handout: a runtime folder of somebody else is refused") {
  const TemporaryRuntimeFolder folder;
  chmod(folder.path().c_str(), 0777);
  CHECK(contains(refusal<HandoutError>([] { const HandoutServer server("x"); }),
                 "written by others"));
  chmod(folder.path().c_str(), 0700);
  if (geteuid() != 0) {
    WARN("SKIPPED: only root can give a folder away");
    return;
  }
  REQUIRE(chown(folder.path().c_str(), 65534, 65534) == 0);
  CHECK(contains(refusal<HandoutError>([] { const HandoutServer server("x"); }),
                 "belongs to user 65534"));
  REQUIRE(chown(folder.path().c_str(), 0, 0) == 0);
}

}  // namespace haptic
