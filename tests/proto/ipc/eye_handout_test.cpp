// SPDX-License-Identifier: GPL-3.0-or-later
// How eye files pass from contact through hapticd to clients.
#include <fcntl.h>
#include <sys/mman.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <set>

#include "clients/library/client.h"
#include "proto/ipc/handout_message.h"
#include "proto/ipc/handout_server.h"
#include "proto/ipc/sessions.h"
#include "tests/proto/ipc/served.h"
#include "tests/support/temporary_folder.h"

namespace haptic {
namespace {

using test::serve_until;
using test::TemporaryRuntimeFolder;

FileDescriptor eye_of(uint32_t object, size_t n_vertices = 1) {
  const std::vector<EyePoint> points(n_vertices);
  EyeFile file;
  file.object = object;
  file.vertices = file.normals = points;
  return make_sealed_file("eye", write_eye(file));
}

/// Offers the eye files of the tool and of all objects, as the contact of a full scene.
void offer_all(int socket, uint64_t generation, size_t n_vertices) {
  for (uint32_t i = 0; i <= kMaxObjects; ++i) {
    const uint32_t object = i == kMaxObjects ? kEyeOfTool : i;
    const FileDescriptor file = eye_of(object, n_vertices);
    offer_segment(socket, eye_id(object), generation, "eye", file.get());
  }
}

/// A session with the control segment announced and a contact connected.
struct Session {
  TemporaryRuntimeFolder folder;
  HandoutServer server{"eyes"};
  SegmentWriter<ControlChannels> control{1};
  FileDescriptor contact = server.connect_child(contact_segment(kFirstHand), 1);

  Session() { server.announce(SegmentId::kControl, 1, ControlChannels::kName, control.fd()); }
};

size_t count(const Eyes& eyes) {
  size_t n = eyes.tools[kFirstHand] != nullptr;
  for (const auto& object : eyes.objects) n += object != nullptr;
  return n;
}

}  // namespace

TEST_CASE("eyes: their numbers are apart from the segments and name their object") {
  CHECK(eye_id(kEyeOfTool) == SegmentId{0x100});
  CHECK(eye_id(eye_of_tool(kMostHands - 1)) == SegmentId{0x103});
  CHECK(eye_id(0) == SegmentId{0x104});
  CHECK(eye_object(eye_id(15)) == 15);
  for (uint32_t hand = 0; hand < kMostHands; ++hand) {
    CHECK(eye_object(eye_id(eye_of_tool(hand))) == eye_of_tool(hand));
    CHECK(eye_object(pieces_id(eye_of_tool(hand))) == eye_of_tool(hand));
  }
  CHECK(is_eye(eye_id(kMaxObjects - 1)));
  CHECK_FALSE(is_eye(eye_id(kMaxObjects)));
  CHECK_FALSE(is_eye(SegmentId{0xff}));
  CHECK_FALSE(is_eye(SegmentId{0x2ff}));
  CHECK_FALSE(is_eye(SegmentId::kClient0));
  CHECK_FALSE(is_eye(contact_segment(kFirstHand)));
  CHECK(pieces_id(kEyeOfTool) == SegmentId{0x300});
  CHECK(pieces_id(3) == SegmentId{0x307});
  for (const uint32_t object : {0u, uint32_t{kMaxObjects} - 1, kEyeOfTool}) {
    CHECK(is_eye(pieces_id(object)));
    CHECK(is_pieces(pieces_id(object)));
    CHECK_FALSE(is_pieces(eye_id(object)));
    CHECK(eye_object(pieces_id(object)) == object);
  }
  CHECK_FALSE(is_eye(pieces_id(kMaxObjects)));
}

TEST_CASE("eyes: convex pieces come beside the meshes, of the object that they name") {
  Session session;
  Client client("eyes");
  client.start();
  const auto offer = [&](SegmentId id, const FileDescriptor& file) {
    offer_segment(session.contact.get(), id, 1, "eye", file.get());
  };
  offer(eye_id(2), eye_of(2, 5));
  offer(pieces_id(2), eye_of(2, 9));
  offer(pieces_id(kEyeOfTool), eye_of(kEyeOfTool, 7));
  REQUIRE(serve_until(session.server, [&] { return client.eyes().changes == 3; }));
  const Eyes eyes = client.eyes();
  CHECK(eyes.objects[2]->vertices.size() == 5);
  CHECK(eyes.object_pieces[2]->vertices.size() == 9);
  CHECK(eyes.tool_pieces[kFirstHand]->vertices.size() == 7);
  CHECK(eyes.tools[kFirstHand] == nullptr);
  CHECK(eyes.problem.empty());
  // one that says of another object than it was announced for
  offer(pieces_id(4), eye_of(5));
  REQUIRE(serve_until(session.server, [&] { return !client.eyes().problem.empty(); }));
  CHECK(client.eyes().object_pieces[4] == nullptr);
  CHECK(client.eyes().object_pieces[5] == nullptr);
}

TEST_CASE("eyes: clients of before and after get them all, and those of a later contact") {
  Session session;
  Client early("eyes");
  early.start();
  REQUIRE(serve_until(session.server, [&] { return session.server.n_clients() == 1; }));
  CHECK(early.eyes().changes == 0);
  offer_all(session.contact.get(), 1, 1);
  REQUIRE(serve_until(session.server, [&] { return count(early.eyes()) == kMaxObjects + 1; }));
  Client late("eyes");
  late.start();
  REQUIRE(serve_until(session.server, [&] { return count(late.eyes()) == kMaxObjects + 1; }));
  CHECK(late.eyes().changes == kMaxObjects + 1);

  // who holds a mesh keeps it; a new question gives the new one
  const Eyes before = late.eyes();
  const FileDescriptor next = session.server.connect_child(contact_segment(kFirstHand), 2);
  session.server.forget_children(contact_segment(kFirstHand), 2);
  offer_all(next.get(), 2, 7);
  for (const Client* client : {&early, &late}) {
    REQUIRE(serve_until(session.server,
                        [&] { return client->eyes().changes == 2 * (kMaxObjects + 1); }));
    for (const auto& object : client->eyes().objects) {
      CHECK(object->generation == 2);
      CHECK(object->vertices.size() == 7);
    }
  }
  CHECK(before.objects[3]->generation == 1);
  CHECK(before.objects[3]->vertices[0] == EyePoint{});
  CHECK(early.eyes().problem.empty());
}

TEST_CASE("eyes: only contact may offer them, to clients alone, and no client may") {
  Session session;
  int offers = 0;
  const auto count_offer = [&](const Announcement&, int) { ++offers; };
  const FileDescriptor file = eye_of(0);
  const FileDescriptor client = connect_session("eyes");
  REQUIRE(serve_until(session.server, [&] { return session.server.n_clients() == 1; }));
  offer_segment(client.get(), eye_id(0), 1, "eye", file.get());
  session.server.serve(count_offer);
  for (const SegmentId child : {SegmentId::kSim, servo_segment(kFirstHand), SegmentId::kControl}) {
    const FileDescriptor end = session.server.connect_child(child, 1);
    offer_segment(end.get(), eye_id(0), 1, "eye", file.get());
    session.server.serve(count_offer);
    CHECK(offers == 0);
  }
  CHECK(session.server.n_clients() == 0);
  // an older generation than the child's own, and numbers beside those of eye files
  const FileDescriptor late = session.server.connect_child(contact_segment(kFirstHand), 3);
  offer_segment(late.get(), eye_id(0), 2, "eye", file.get());
  for (const SegmentId id : {SegmentId::kSim, SegmentId{0xff}, eye_id(kMaxObjects)}) {
    const FileDescriptor end = session.server.connect_child(contact_segment(kFirstHand), 1);
    offer_segment(end.get(), id, 1, "eye", file.get());
    session.server.serve(count_offer);
  }
  CHECK(offers == 0);

  const FileDescriptor servo = session.server.connect_child(servo_segment(kFirstHand), 1);
  offer_segment(session.contact.get(), eye_id(0), 1, "eye", file.get());
  session.server.serve(count_offer);
  CHECK(offers == 1);
  // a child that has read all is sent nothing more
  std::set<SegmentId> told;
  for (int turn = 0; turn < 3; ++turn) {
    for (ReceivedMessage m; (m = receive_message(servo.get())).kind == Received::kMessage;) {
      told.insert(m.announcement.id);
    }
    session.server.serve({});
  }
  CHECK(told == std::set{SegmentId::kControl});
}

TEST_CASE("eyes: a client that does not read has few of them in its queue, and loses none") {
  Session session;
  offer_all(session.contact.get(), 1, 1);
  session.server.serve({});
  const FileDescriptor stopped = connect_session("eyes");
  REQUIRE(serve_until(session.server, [&] { return session.server.n_clients() == 1; }));
  std::set<SegmentId> told;
  size_t longest = 0;
  while (told.size() < kMaxObjects + 2) {
    for (int turn = 0; turn < 50; ++turn) session.server.serve({});
    size_t queue = 0;
    for (ReceivedMessage m; (m = receive_message(stopped.get())).kind == Received::kMessage;) {
      told.insert(m.announcement.id);
      ++queue;
    }
    REQUIRE(queue > 0);
    longest = std::max(longest, queue);
  }
  CHECK(longest <= 5);
  CHECK(session.server.n_clients() == 1);
}

TEST_CASE("eyes: a client refuses what is no eye file, says why, and keeps what it has") {
  Session session;
  Client client("eyes");
  client.start();
  offer_segment(session.contact.get(), eye_id(0), 1, "eye", eye_of(0).get());
  REQUIRE(serve_until(session.server, [&] { return count(client.eyes()) == 1; }));
  FileDescriptor unsealed(memfd_create("eye", MFD_CLOEXEC | MFD_ALLOW_SEALING));
  const std::vector<std::byte> junk(500, std::byte{1});
  const auto refuses = [&](uint32_t object, const FileDescriptor& file, const std::string& part) {
    offer_segment(session.contact.get(), eye_id(object), 2, "eye", file.get());
    CHECK(serve_until(session.server,
                      [&] { return client.eyes().problem.find(part) != std::string::npos; }));
  };
  refuses(1, unsealed, "not sealed against every change");
  refuses(2, make_sealed_file("eye", junk), "HAPTEYE1");
  refuses(3, eye_of(4), "announced for another object");
  refuses(0, make_sealed_file("eye", junk), "HAPTEYE1");
  CHECK(count(client.eyes()) == 1);
  CHECK(client.eyes().objects[0]->generation == 1);
  CHECK(client.is_connected());
}

TEST_CASE("eyes: nobody who was given one can write into it") {
  Session session;
  const FileDescriptor client = connect_session("eyes");
  offer_segment(session.contact.get(), eye_id(0), 1, "eye", eye_of(0).get());
  ReceivedMessage message;
  REQUIRE(serve_until(session.server, [&] {
    message = receive_message(client.get());
    return message.kind == Received::kMessage && message.announcement.id == eye_id(0);
  }));
  const int fd = message.fd.get();
  CHECK(pwrite(fd, "x", 1, 0) == -1);
  CHECK(mmap(nullptr, 4096, PROT_READ | PROT_WRITE, MAP_SHARED, fd, 0) == MAP_FAILED);
  CHECK(ftruncate(fd, 0) == -1);
  const std::string path = "/proc/self/fd/" + std::to_string(fd);
  const FileDescriptor again(open(path.c_str(), O_RDWR | O_CLOEXEC));
  CHECK(pwrite(again.get(), "x", 1, 0) == -1);
  CHECK(mmap(nullptr, 4096, PROT_READ | PROT_WRITE, MAP_SHARED, again.get(), 0) == MAP_FAILED);
  CHECK(fcntl(again.get(), F_ADD_SEALS, F_SEAL_WRITE) == -1);
  void* mapped = mmap(nullptr, 4096, PROT_READ, MAP_SHARED, fd, 0);
  REQUIRE(mapped != MAP_FAILED);
  CHECK(mprotect(mapped, 4096, PROT_READ | PROT_WRITE) == -1);
  munmap(mapped, 4096);
}

}  // namespace haptic
