// SPDX-License-Identifier: GPL-3.0-or-later
// Tests for servo/hapticd/giving/give_server: who may give, and what is taken of them.
#include "servo/hapticd/giving/give_server.h"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/socket.h>
#include <unistd.h>
#include <algorithm>
#include <catch2/catch.hpp>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "proto/ipc/handout_message.h"
#include "proto/ipc/segment.h"
#include "proto/ipc/sessions.h"
#include "proto/os/realtime.h"
#include "tests/support/temporary_folder.h"

#ifndef F_SEAL_FUTURE_WRITE
#define F_SEAL_FUTURE_WRITE 0x0010
#endif

namespace haptic {
namespace {

SessionConfig config_of_two() {
  SessionConfig config;
  config.n_objects = 2;
  assign(config.objects[0].name, "cup");
  assign(config.objects[1].name, "red lid");
  config.n_clients = 2;
  assign(config.clients[0].name, "robot");
  assign(config.clients[1].name, "lids");
  config.clients[0].n_moves = 1;
  config.clients[1].n_moves = 1;
  config.clients[1].moves[0] = 1;
  config.clients[1].may = kMayDraw;
  return config;
}

/// A server, and clients that speak to it in turns.
struct Serving : test::TemporaryRuntimeFolder {
  const SessionConfig config = config_of_two();
  GiveServer server{"test", config};
  int64_t t_ns = kNsPerSecond;
  std::vector<Announcement> offers;
  std::vector<std::string> said;

  void serve() {
    server.serve(t_ns, {[this](const Announcement& offer, int) { offers.push_back(offer); },
                        [this](const std::string& line) { said.push_back(line); }});
  }
  FileDescriptor connect() {
    FileDescriptor socket = unix_socket();
    REQUIRE(connect_to(socket, runtime_folder() + "/test.give"));
    serve();
    return socket;
  }
  static std::string heard(const FileDescriptor& socket) {
    std::string text(4096, '\0');
    const ssize_t n = recv(socket.get(), text.data(), text.size(), MSG_DONTWAIT);
    return n > 0 ? text.substr(0, static_cast<size_t>(n)) : n == 0 ? "<end>" : "<nothing>";
  }
  std::string say(const FileDescriptor& socket, const std::string& text) {
    send(socket.get(), text.data(), text.size(), MSG_NOSIGNAL);
    serve();
    return heard(socket);
  }
  std::string offer(const FileDescriptor& socket, SegmentId id, uint64_t generation, int fd) {
    send_announcement(socket.get(), make_announcement(id, generation, "x"), fd);
    serve();
    return heard(socket);
  }
};

constexpr int kAllSeals = F_SEAL_SHRINK | F_SEAL_GROW | F_SEAL_FUTURE_WRITE | F_SEAL_SEAL;

/// A segment as a client makes it, but for what `spoil` does before it is sealed.
FileDescriptor spoiled(const std::function<void(SegmentHeader&)>& spoil, int seals = kAllSeals,
                       ptrdiff_t longer = 0, unsigned flags = 0) {
  const SegmentSpec spec = segment_spec<ClientChannels>(0);
  FileDescriptor fd(memfd_create("x", MFD_CLOEXEC | MFD_ALLOW_SEALING | flags));
  const auto size = static_cast<off_t>(static_cast<ptrdiff_t>(spec.total_bytes) + longer);
  if (!fd.is_open() || posix_fallocate(fd.get(), 0, size) != 0) return {};
  const SegmentWriter<ClientChannels> right(1, 0);
  SegmentHeader* header = static_cast<SegmentHeader*>(
      mmap(nullptr, sizeof(SegmentHeader), PROT_READ | PROT_WRITE, MAP_SHARED, fd.get(), 0));
  if (header == MAP_FAILED) return {};
  std::memcpy(static_cast<void*>(header), &right.header(), sizeof *header);
  spoil(*header);
  munmap(header, sizeof *header);
  fcntl(fd.get(), F_ADD_SEALS, seals);
  return fd;
}

std::string why_refused(const FileDescriptor& fd) {
  REQUIRE(fd.is_open());
  try {
    check_given_segment(fd.get(), segment_spec<ClientChannels>(0), 1);
    return "";
  } catch (const SegmentError& error) {
    return error.what();
  }
}

}  // namespace

TEST_CASE("give: a client takes its place, offers its segment, and leaves") {
  Serving session;
  FileDescriptor robot = session.connect();
  const GivePlace place = read_place(session.say(robot, "robot"));
  CHECK(place.client == 0);
  CHECK(place.generation == 1);
  CHECK(place.may == 0);
  REQUIRE(place.moves.size() == 1);
  CHECK(place.moves[0].index == 0);
  CHECK(place.moves[0].name == "cup");
  CHECK(session.server.seat(0).is_taken);
  CHECK(session.server.seat(0).pid == getpid());
  SegmentWriter<ClientChannels> segment(1, 0);
  CHECK(session.offer(robot, ClientChannels::id(0), 1, segment.fd()) == "ok");
  REQUIRE(session.offers.size() == 1);
  CHECK(session.offers[0].id == ClientChannels::id(0));
  CHECK(session.said.back().starts_with("client 'robot' gives"));
  robot.reset();
  session.serve();
  CHECK_FALSE(session.server.seat(0).is_taken);
  CHECK(session.said.back() == "client 'robot' has left");
  // a name with a blank, of the second client
  const GivePlace lids = read_place(session.say(session.connect(), "lids"));
  CHECK(lids.client == 1);
  CHECK(lids.moves.at(0).name == "red lid");
  CHECK(lids.may == kMayDraw);
}

TEST_CASE("give: who may draw offers a second segment, once, and others are told why not") {
  Serving session;
  const FileDescriptor lids = session.connect();
  const uint64_t generation = read_place(session.say(lids, "lids")).generation;
  SegmentWriter<ClientChannels> segment(generation, 1);
  const auto drawings = std::make_unique<SegmentWriter<DrawChannels>>(generation, 1);
  // not before the first
  CHECK(session.offer(lids, DrawChannels::id(1), generation, drawings->fd()) ==
        "this is not the segment that was asked for");
  session.t_ns += kNsPerSecond;
  const FileDescriptor again = session.connect();
  const uint64_t next = read_place(session.say(again, "lids")).generation;
  SegmentWriter<ClientChannels> second(next, 1);
  const auto drawn = std::make_unique<SegmentWriter<DrawChannels>>(next, 1);
  CHECK(session.offer(again, ClientChannels::id(1), next, second.fd()) == "ok");
  CHECK(session.offer(again, DrawChannels::id(1), next, drawn->fd()) == "ok");
  REQUIRE(session.offers.size() == 2);
  CHECK(session.offers[1].id == DrawChannels::id(1));
  CHECK(session.said.back().starts_with("client 'lids' draws"));
  // far longer than the steps of coming may last
  session.t_ns += 10 * kNsPerSecond;
  session.serve();
  CHECK(session.server.giving(1) == next);
  session.offer(again, DrawChannels::id(1), next, drawn->fd());
  CHECK(session.server.giving(1) == 0);
  const FileDescriptor robot = session.connect();
  const uint64_t of_robot = read_place(session.say(robot, "robot")).generation;
  SegmentWriter<ClientChannels> third(of_robot, 0);
  CHECK(session.offer(robot, ClientChannels::id(0), of_robot, third.fd()) == "ok");
  CHECK(session.offer(robot, DrawChannels::id(0), of_robot, drawn->fd()) ==
        "'robot' may not draw; add \"draw\" to may of its [[client]]");
  CHECK(session.offers.size() == 3);
}

TEST_CASE("give: what is drawn is checked as what is given") {
  Serving session;
  const FileDescriptor lids = session.connect();
  const uint64_t generation = read_place(session.say(lids, "lids")).generation;
  SegmentWriter<ClientChannels> segment(generation, 1);
  REQUIRE(session.offer(lids, ClientChannels::id(1), generation, segment.fd()) == "ok");
  // a segment of another kind under the right number
  CHECK(session.offer(lids, DrawChannels::id(1), generation, segment.fd()).find("has not the") !=
        std::string::npos);
  CHECK(session.said[1].starts_with("client 'lids' is refused: "));
  CHECK(session.offers.size() == 1);
}

TEST_CASE("give: a name that is unknown, taken or comes again too soon has no place") {
  Serving session;
  CHECK(session.say(session.connect(), "robto") ==
        "no [[client]] of this session is called 'robto'; did you mean 'robot'?");
  CHECK(session.say(session.connect(), std::string(64, 'x')) == "<end>");
  FileDescriptor robot = session.connect();
  read_place(session.say(robot, "robot"));
  CHECK(session.say(session.connect(), "robot").starts_with("'robot' gives already, process "));
  robot.reset();
  session.serve();
  CHECK(session.say(session.connect(), "robot") ==
        "too soon: 'robot' has just given; wait a second");
  session.t_ns += kNsPerSecond;
  CHECK(read_place(session.say(session.connect(), "robot")).generation == 2);
}

TEST_CASE("give: who says nothing, or the wrong thing, is dropped and keeps no place") {
  Serving session;
  const FileDescriptor silent = session.connect();
  const FileDescriptor robot = session.connect();
  read_place(session.say(robot, "robot"));
  session.t_ns += 2 * kNsPerSecond;
  session.serve();
  CHECK(Serving::heard(silent) == "<end>");
  CHECK(Serving::heard(robot) == "<end>");
  CHECK_FALSE(session.server.seat(0).is_taken);
  for (const auto& [id, generation] : {std::pair{ClientChannels::id(1), uint64_t{2}},
                                       {ClientChannels::id(0), uint64_t{1}},
                                       {SimChannels::kId, uint64_t{2}}}) {
    session.t_ns += kNsPerSecond;
    const FileDescriptor peer = session.connect();
    const GivePlace place = read_place(session.say(peer, "robot"));
    SegmentWriter<ClientChannels> segment(place.generation, 0);
    const uint64_t told = id == ClientChannels::id(0) ? generation : place.generation;
    CHECK(session.offer(peer, id, told, segment.fd()) ==
          "this is not the segment that was asked for");
  }
  CHECK(session.offers.empty());
  // more connections than there is room for wait, and nobody who gives is thrown out
  std::vector<FileDescriptor> flood;
  for (int i = 0; i < 40; ++i) flood.push_back(session.connect());
  CHECK(Serving::heard(flood.back()).starts_with("too many clients"));
  session.t_ns += 2 * kNsPerSecond;
  session.serve();
  CHECK(read_place(session.say(session.connect(), "robot")).client == 0);
}

TEST_CASE("give: a segment that could harm its readers is refused") {
  CHECK(why_refused(spoiled([](SegmentHeader&) {})).empty());
  for (const int seal : {F_SEAL_SHRINK, F_SEAL_GROW, F_SEAL_FUTURE_WRITE, F_SEAL_SEAL}) {
    CHECK(why_refused(spoiled([](SegmentHeader&) {}, kAllSeals & ~seal)) ==
          "the segment of a client is not sealed against shrinking, growing, other writers and "
          "unsealing");
  }
  for (const ptrdiff_t longer : {ptrdiff_t{-4096}, ptrdiff_t{4096}, ptrdiff_t{64} << 20}) {
    CHECK(why_refused(spoiled([](SegmentHeader&) {}, kAllSeals, longer)).find("has not the") !=
          std::string::npos);
  }
  const auto refused = [](const std::function<void(SegmentHeader&)>& spoil) {
    return !why_refused(spoiled(spoil)).empty();
  };
  CHECK(refused([](SegmentHeader& h) { h.magic = 0; }));
  CHECK(refused([](SegmentHeader& h) { h.abi_major = 1; }));
  CHECK(refused([](SegmentHeader& h) { h.layout_hash = 1; }));
  CHECK(refused([](SegmentHeader& h) { h.segment_id = 4; }));
  CHECK(refused([](SegmentHeader& h) { h.generation = 2; }));
  CHECK(refused([](SegmentHeader& h) { h.total_bytes = 7; }));
  CHECK(refused([](SegmentHeader& h) { h.clock_id = 0; }));
  // a file that is none, one that anybody may write, and huge pages where the kernel has some
  int ends[2];
  REQUIRE(pipe(ends) == 0);
  const FileDescriptor reading(ends[0]), writing(ends[1]);
  CHECK_FALSE(why_refused(FileDescriptor(dup(ends[0]))).empty());
  const test::TemporaryFolder folder;
  const FileDescriptor file(
      open((folder.path() + "/x").c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0600));
  CHECK_FALSE(why_refused(FileDescriptor(dup(file.get()))).empty());
}

TEST_CASE("give: pages that were never written are there once the segment is taken, and stay") {
  constexpr off_t kPage = 4096, kHole = 1 << 19;
  constexpr int kPunch = FALLOC_FL_PUNCH_HOLE | FALLOC_FL_KEEP_SIZE;
  const FileDescriptor holed = spoiled([](SegmentHeader&) {}, 0);
  const auto size = static_cast<off_t>(segment_spec<ClientChannels>(0).total_bytes);
  REQUIRE(fallocate(holed.get(), kPunch, kHole, kPage) == 0);
  // blocks beyond the end hide the hole from who counts them
  REQUIRE(fallocate(holed.get(), FALLOC_FL_KEEP_SIZE, size, 2 * kPage) == 0);
  REQUIRE(fcntl(holed.get(), F_ADD_SEALS, kAllSeals) == 0);
  void* const view = mmap(nullptr, size_t(size), PROT_READ, MAP_SHARED, holed.get(), 0);
  REQUIRE(view != MAP_FAILED);
  const auto lacking = [&] {
    std::vector<unsigned char> there(size_t(size / kPage));
    REQUIRE(mincore(view, there.size() * kPage, there.data()) == 0);
    return std::count(there.begin(), there.end(), 0);
  };
  CHECK(lacking() > 0);
  CHECK(why_refused(holed).empty());
  CHECK(lacking() == 0);
  CHECK(fallocate(holed.get(), kPunch, kHole, kPage) != 0);
  munmap(view, size_t(size));
}

TEST_CASE("give: texts of a place that are none") {
  for (const char* text : {"", "place", "place 9 1 0\n", "place 0 1\n", "place 0 1 0\n256 x\n",
                           "place 0 1 0\n1\n", "place 0 1 0\nx y\n", "no place"}) {
    CHECK_THROWS_AS(read_place(text), HandoutError);
  }
  const GivePlace place{3, 17, kMayPush | kMayDraw, {{5, "a b"}, {200, "ü"}}};
  const GivePlace read = read_place(text_of(place));
  CHECK(read.client == 3);
  CHECK(read.generation == 17);
  CHECK(read.may == (kMayPush | kMayDraw));
  REQUIRE(read.moves.size() == 2);
  CHECK(read.moves[0].name == "a b");
  CHECK(read.moves[1].index == 200);
}

}  // namespace haptic
