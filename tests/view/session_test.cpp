// SPDX-License-Identifier: GPL-3.0-or-later
// `hapt view` with a running session, seen by clients that share no code with it.
#include <sys/fsuid.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <fstream>
#include <map>
#include <sstream>

#include "proto/wire/packing.h"
#include "tests/view/viewed_session.h"

namespace haptic {
namespace {

using namespace test;
using Json = nlohmann::json;

/// Sockets are made as another user, where this one is root.
struct Somebody {
  Somebody() {
    setfsuid(kNobody);
    is_other = setfsuid(-1) == kNobody;
  }
  ~Somebody() { setfsuid(geteuid()); }
  Somebody(const Somebody&) = delete;
  static constexpr int kNobody = 65534;
  bool is_other = false;
};

void check_vector(const std::vector<double>& got, const Vec3& wanted) {
  CHECK(got.at(0) == wanted.x);
  CHECK(got.at(1) == wanted.y);
  CHECK(got.at(2) == wanted.z);
}

void check_same(const LayoutReader& layout, const std::vector<double>& frame,
                const ServoFrame& ring) {
  CHECK(layout.one(frame, "time") == Approx(1e-9 * static_cast<double>(ring.t_ns)).epsilon(1e-12));
  check_vector(layout.fixed(frame, "tool"), ring.X_WT.p);
  check_vector(layout.fixed(frame, "proxy"), ring.X_WP.p);
  check_vector(layout.fixed(frame, "verified"), ring.X_WG.p);
  check_vector(layout.fixed(frame, "handle"), ring.device.X_BH.p);
  // the device of this scene is not turned
  check_vector(layout.fixed(frame, "force"), ring.F_device_B.f);
  check_vector(layout.fixed(frame, "coupling_force"), ring.F_coupling_W.f);
  CHECK(layout.fixed(frame, "tool").at(3) == ring.X_WT.q.w);
  CHECK(layout.one(frame, "depth") == ring.depth);
  CHECK(layout.one(frame, "flags") == ring.flags);
  CHECK(layout.one(frame, "skipped") == static_cast<double>(ring.skipped));
  CHECK(layout.one(frame, "n_pushing") == ring.n_contacts);
}

/// True if some set of the ring has the contacts that a frame lists; the block stands still.
bool is_listed(const LayoutReader& layout, const std::vector<double>& frame,
               const PackedRecords<ContactSet>& sets) {
  const size_t n = layout.count(frame, "n_listed");
  const auto has = [&](const ContactSet& set) {
    if (set.contacts.size() != n) return false;
    for (size_t i = 0; i < n; ++i) {
      const Contact& contact = set.contacts[i];
      const Vec3 point = set.objects[contact.object].X_WO * contact.object_point_O;
      const auto got = layout.contact(frame, i, "point");
      if (norm(Vec3{got[0], got[1], got[2]} - point) > 1e-9) return false;
      if (layout.contact(frame, i, "active")[0] != (i < set.n_active ? 1 : 0)) return false;
    }
    return true;
  };
  size_t k = 0;
  while (k < sets.size() && !has(sets[k])) ++k;
  return k < sets.size();
}

}  // namespace

TEST_CASE("hapt view: frames have the numbers of the rings at the same tick") {
  Viewed session;
  const BridgeProcess bridge(session.folder.path());
  const LayoutReader layout(get(bridge.port, "/layout.json").body);
  Page page(bridge);
  REQUIRE(page.status == 101);
  CHECK(page.handshake().find(std::string("Sec-WebSocket-Protocol: ") + kPage) !=
        std::string::npos);
  CHECK(Json::parse(page.text_of("hello"))["session"] == "viewed");
  CHECK(Json::parse(page.text_of("scene"))["objects"][0]["name"] == "block");

  std::map<uint64_t, ServoFrame> ring;
  PackedRecords<ContactSet> sets;
  Watcher& watcher = session.watcher;
  const auto drain = [&] {
    ServoFrame frame;
    while (watcher.servo.next(frame)) ring[frame.tick] = frame;
    ContactSet set;
    while (watcher.contact.next(set)) {
      if (!set.contacts.empty()) sets.push_back(set);
    }
  };
  std::vector<std::vector<double>> frames;
  size_t touching = 0;
  while (frames.size() < 30 || (touching < 5 && frames.size() < 600)) {
    frames.push_back(page.frame());
    REQUIRE(!frames.back().empty());
    touching += layout.count(frames.back(), "n_listed") > 0;
    drain();
  }
  sleep_until(now_ns() + 50'000'000);
  drain();
  size_t compared = 0, listed = 0;
  double samples = 0, passed = 0;
  for (const auto& frame : frames) {
    CHECK(frame.size() == layout.length(frame));
    samples += layout.one(frame, "n_samples");
    passed += layout.one(frame, "unseen") + 1;
    const auto there = ring.find(static_cast<uint64_t>(layout.one(frame, "tick")));
    if (there == ring.end()) continue;
    ++compared;
    check_same(layout, frame, there->second);
    if (layout.count(frame, "n_listed") == 0) continue;
    ++listed;
    CHECK(is_listed(layout, frame, sets));
  }
  CHECK(compared > frames.size() / 2);
  CHECK(listed > 0);
  CHECK(samples > 0);
  CHECK(passed >= samples - 256);
  // every sample is a tick of the ring
  const auto& last = frames.back();
  for (size_t i = 0; i < layout.count(last, "n_samples"); ++i) {
    const double time = layout.sample(last, i, "time")[0];
    const auto same = std::find_if(ring.begin(), ring.end(), [&](const auto& one) {
      return std::fabs(1e-9 * static_cast<double>(one.second.t_ns) - time) < 1e-7;
    });
    REQUIRE(same != ring.end());
    check_vector(layout.sample(last, i, "force"), same->second.F_device_B.f);
  }
}

TEST_CASE("hapt view: who may watch, who may command, what is refused") {
  Viewed session;
  const BridgeProcess bridge(session.folder.path(), {"--allow-origin", "https://studio.example"});
  const uint16_t port = bridge.port;
  const std::string own = "http://" + bridge.host;

  SocketClient half(port);  // of which no more comes
  half.say("GET / HTTP/1.1\r\nHost: ");

  // over HTTP
  CHECK(get(port, "/scene.json").status == 200);
  CHECK(get(port, "/scene.json").body.find("The smallest scene") == std::string::npos);
  CHECK(get(port, "/scene.json").head.find("X-Content-Type-Options: nosniff") != std::string::npos);
  CHECK(get(port, "/metrics").body.find("haptic_servo_ticks_total") != std::string::npos);
  CHECK(get(port, "/metrics").head.find("text/plain; version=0.0.4;") != std::string::npos);
  CHECK(get(port, "/scene.json", "evil.example").status == 403);
  CHECK(get(port, "/scene.json", "127.0.0.1:1").status == 403);
  for (const char* path : {"/../etc/passwd", "/%2e%2e/etc/passwd", "/a\\b", "/..%2f"}) {
    CHECK(get(port, path).status == 400);
  }
  CHECK(get(port, "/nothing").status == 404);
  CHECK(get(port, "/mesh/99.bin").status == 404);
  CHECK(get(port, "/pieces/0.bin").status == 404);  // the session has none
  CHECK(test::ask(port, "DELETE / HTTP/1.1\r\nHost: " + bridge.host + "\r\n\r\n").status == 405);
  CHECK(test::ask(port, "GET / HTTP/1.1\r\nHost: " + bridge.host +
                            "\r\nX: " + std::string(20'000, 'x') + "\r\n\r\n")
            .status == 431);
  CHECK(test::ask(port, "nonsense\r\n\r\n").status == 400);

  // over a WebSocket
  const auto status = [&](const std::string& path, const std::string& host,
                          const std::string& origin, const std::string& protocol) {
    return SocketClient(port).upgrade(path, host, origin, protocol);
  };
  CHECK(status("/view", bridge.host, "http://evil.example", kPage) == 403);
  CHECK(status("/view", bridge.host, "", kPage) == 403);
  CHECK(status("/view", "evil.example", "http://evil.example", kPage) == 403);
  CHECK(status("/view", bridge.host, "https://studio.example", kPage) == 403);
  CHECK(status("/view", bridge.host, own, "chat") == 400);
  CHECK(status("/", bridge.host, "https://evil.example", "foxglove.sdk.v1") == 403);
  CHECK(status("/", bridge.host, "https://studio.example", "foxglove.sdk.v1") == 101);
  CHECK(status("/", bridge.host, "", "foxglove.websocket.v1") == 101);

  // the token
  Page page(bridge);
  REQUIRE(page.status == 101);
  CHECK(page.answer_to(1, "pause")["ok"] == false);
  page.tell(R"({"type":"token","token":"00000000000000000000000000000000"})");
  CHECK(Json::parse(page.text_of("control"))["allowed"] == false);
  CHECK(page.answer_to(2, "pause")["ok"] == false);
  page.tell(Json{{"type", "token"}, {"token", bridge.token}}.dump());
  CHECK(Json::parse(page.text_of("control"))["allowed"] == true);
  const Json scene = Json::parse(page.text_of("scene"));
  CHECK(scene["config"].get<std::string>().find("the smallest scene") != std::string::npos);
  const Json paused = page.answer_to(3, "pause");
  CHECK(paused["ok"] == true);
  CHECK(paused["id"] == 3);
  ControlFrame control{};
  CHECK(eventually([&] {
    session.watcher.control.latest(control);
    return control.paused == 1;
  }));
  CHECK(page.answer_to(4, "stop")["ok"] == false);
  CHECK(page.answer_to(5, "set stiffness nonsense")["ok"] == false);
  CHECK(page.answer_to(6, "resume")["ok"] == true);

  const std::string token_file = session.folder.path() + "/view-" + std::to_string(port) + ".token";
  struct stat file {};
  REQUIRE(stat(token_file.c_str(), &file) == 0);
  CHECK((file.st_mode & 0777) == 0600);

  // another user of this machine
  if (geteuid() != 0) {
    WARN("SKIPPED: another user watches; only root can become one");
  } else {
    const pid_t child = fork();
    if (child == 0) {
      if (setgid(65534) != 0 || setuid(65534) != 0) _exit(10);
      if (access(token_file.c_str(), R_OK) == 0) _exit(11);
      Page other(bridge);
      if (other.status != 101 || other.text_of("hello").empty()) _exit(12);
      if (other.frame().empty()) _exit(13);
      if (other.answer_to(1, "pause")["ok"] != false) _exit(14);
      _exit(0);
    }
    int ended = 0;
    waitpid(child, &ended, 0);
    CHECK(WEXITSTATUS(ended) == 0);
  }

  // what is no message
  const auto close_code_of = [&](const std::string& bytes) {
    Page bad(bridge);
    bad.say(bytes);
    return bad.close_code();
  };
  CHECK(close_code_of(SocketClient::frame(kText, "nonsense")) == 1008);
  CHECK(close_code_of(SocketClient::frame(kBinary, "x")) == 1003);
  CHECK(close_code_of(SocketClient::frame(kText, std::string(9000, 'x'))) == 1009);
  CHECK(close_code_of(SocketClient::frame(kText, "{}", true, false)) == 1002);
  CHECK(close_code_of(SocketClient::frame(3, "reserved")) == 1002);
  // 2⁶³ bytes, of which none comes
  CHECK(close_code_of("\x81\xff\x7f" + std::string(7, '\xff') + "mask") == 1009);

  // who says half of a frame, or does not read what it asked for
  Page half_frame(bridge);
  half_frame.say("\x81");
  std::vector<Page> stopped;
  for (int i = 0; i < 20; ++i) stopped.emplace_back(bridge);
  SocketClient full(port);
  full.upgrade("/", bridge.host, "", "foxglove.sdk.v1");
  full.tell(
      R"({"op":"subscribe","subscriptions":[{"id":1,"channelId":1},{"id":2,"channelId":2}]})");
  for (int i = 0; i < 100; ++i) REQUIRE(!page.frame().empty());
  CHECK(half.is_hung_up(20));

  // the rings cannot be written from there
  std::ifstream maps("/proc/" + std::to_string(bridge.pid()) + "/maps");
  size_t rings = 0;
  for (std::string line; std::getline(maps, line);) {
    if (line.find("memfd:") == std::string::npos) continue;
    CAPTURE(line);
    CHECK(line.find(" r--s ") != std::string::npos);
    ++rings;
  }
  CHECK(rings >= 4);

  // the end
  bridge.send(SIGTERM);
  CHECK(const_cast<BridgeProcess&>(bridge).exit_code() == 0);
  CHECK(!std::filesystem::exists(token_file));
}

TEST_CASE("hapt view: only so many connections of one user, and others are served") {
  Viewed session;
  const BridgeProcess bridge(session.folder.path());
  std::vector<Page> pages;
  for (int i = 0; i < 96; ++i) {
    pages.emplace_back(bridge);
    REQUIRE(pages.back().status == 101);
  }
  // those that are told so are fewer than all too: these say nothing and wait for their answer
  std::vector<std::unique_ptr<SocketClient>> silent;
  for (int i = 0; i < 31; ++i) silent.push_back(std::make_unique<SocketClient>(bridge.port));
  const test::Reply refused = get(bridge.port, "/scene.json");
  CHECK(refused.status == 503);
  CHECK(refused.body.find("one user or address 96") != std::string::npos);
  if (const Somebody another; another.is_other) {
    Page page(bridge);
    CHECK(page.status == 101);
    CHECK(!page.frame().empty());
    CHECK(get(bridge.port, "/scene.json").status == 200);
  } else {
    WARN("no other user: only root can be one");
  }
  pages.pop_back();
  CHECK(eventually([&] { return get(bridge.port, "/scene.json").status == 200; }));
}

TEST_CASE("hapt view: hapticd is killed and started again, and the page goes on") {
  Viewed session;
  const BridgeProcess bridge(session.folder.path());
  Page page(bridge);
  REQUIRE(!page.frame().empty());
  session.hapticd->send(SIGKILL);
  CHECK(!page.text_of("gone").empty());
  session.hapticd.reset();
  session.hapticd = session.start();
  Watcher again("viewed");
  REQUIRE(again.wait_for_all());
  const int64_t back_ns = now_ns();
  CHECK(Json::parse(page.text_of("hello", 30))["missed"].get<double>() > 0);
  CHECK(!page.text_of("scene").empty());
  const LayoutReader layout(get(bridge.port, "/layout.json").body);
  std::vector<double> frame;
  CHECK(eventually([&] {
    frame = page.frame();
    return frame.empty() || layout.one(frame, "age_servo") < 0.5;
  }));
  REQUIRE(!frame.empty());
  std::printf("frames again %.2f s after the rings\n",
              1e-9 * static_cast<double>(now_ns() - back_ns));
  // the ring of the present hapticd, not memory of the one before
  ServoFrame present{};
  REQUIRE(eventually([&] { return again.servo.latest(present); }));
  CHECK(layout.one(frame, "tick") <= static_cast<double>(present.tick));
  CHECK(get(bridge.port, "/metrics").body.find("haptic_view_reconnects_total 1") !=
        std::string::npos);
}

TEST_CASE("hapt view: Foxglove clients of both names get records") {
  Viewed session;
  const BridgeProcess bridge(session.folder.path());
  std::map<uint64_t, ServoFrame> ring;
  for (const char* protocol : {"foxglove.websocket.v1", "foxglove.sdk.v1"}) {
    CAPTURE(protocol);
    SocketClient client(bridge.port);
    REQUIRE(client.upgrade("/", bridge.host, "", protocol) == 101);
    CHECK(client.handshake().find(std::string("Sec-WebSocket-Protocol: ") + protocol) !=
          std::string::npos);
    CHECK(Json::parse(client.message().bytes)["op"] == "serverInfo");
    const Json offer = Json::parse(client.message().bytes);
    uint64_t channel = 0;
    for (const Json& one : offer["channels"]) {
      if (one["topic"] == "/servo0/frame") channel = one["id"];
    }
    client.tell(Json{{"op", "subscribe"},
                     {"subscriptions", Json::array({{{"id", 77}, {"channelId", channel}}})}}
                    .dump());
    uint64_t last = 0;
    for (int i = 0; i < 10; ++i) {
      const Message m = client.message();
      REQUIRE(m.opcode == kBinary);
      // no object can be pushed away, and no client is felt: the two lists at the end are empty
      constexpr size_t kFields = kParts<ServoFrame>[0].offset;
      REQUIRE(m.bytes.size() == 17 + kFields + 4 + 4);
      CHECK(m.bytes[0] == 1);
      CHECK(m.bytes[1] == 77);
      ServoFrame record{};
      std::memcpy(static_cast<void*>(&record), m.bytes.data() + 17, kFields);
      CHECK(record.tick > last);
      last = record.tick;
      ServoFrame frame;
      while (session.watcher.servo.next(frame)) ring[frame.tick] = frame;
      if (ring.count(record.tick) == 1) {
        CHECK(std::memcmp(&ring.at(record.tick), &record, kFields) == 0);
      }
    }
    // told so, not closed
    client.tell("nonsense");
    Message m = client.message();
    while (m.opcode == kBinary) m = client.message();
    REQUIRE(m.opcode == kText);
    CHECK(Json::parse(m.bytes)["op"] == "status");
  }
}

}  // namespace haptic
