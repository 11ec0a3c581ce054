// SPDX-License-Identifier: GPL-3.0-or-later
// Any bytes for the bridge's socket, as a request and as frames of a WebSocket: nothing leaks, and
// an honest page is served all the while.
#include <catch2/catch.hpp>
#include <ctime>
#include <thread>

#include "clients/view/bridge.h"
#include "proto/os/realtime.h"
#include "tests/fuzz/fuzz_run.h"
#include "tests/fuzz/hostile_input.h"
#include "tests/process/hapticd_process.h"
#include "tests/support/torture_scale.h"
#include "tests/view/socket_client.h"

namespace haptic {
namespace {

using test::FuzzRandom;
using test::SocketClient;

/// A bridge to a source that has one frame, and a session that answers anything.
class FuzzedBridge {
 public:
  FuzzedBridge() {
    view_.has_servo = true;
    info_.session = "fuzzed";
    FrameSource source{"session",
                       [this](int64_t now) {
                         view_.now_ns = now;
                         return first_ ? (first_ = false, SourceNews::kArrived)
                                       : SourceNews::kNothing;
                       },
                       [this]() -> const View& { return view_; },
                       [this]() -> const SceneInfo& { return info_; }, [] { return -1.0; }};
    BridgeOptions options;
    options.token = "secret";
    options.web.request_patience = 1;
    options.say = [](const std::string& line) { return "said " + line; };
    bridge_ = std::make_unique<Bridge>(std::move(source), options);
    thread_ = std::thread([this] { bridge_->run([this] { return stop_.load(); }); });
  }
  ~FuzzedBridge() {
    stop_ = true;
    thread_.join();
  }
  uint16_t port() const { return bridge_->port(); }

 private:
  View view_;
  SceneInfo info_;
  bool first_ = true;
  std::atomic<bool> stop_{false};
  std::unique_ptr<Bridge> bridge_;
  std::thread thread_;
};

std::vector<std::string> requests(uint16_t port) {
  const std::string host = "Host: 127.0.0.1:" + std::to_string(port) + "\r\n";
  return {
      "GET / HTTP/1.1\r\n" + host + "\r\n",
      "HEAD /scene.json HTTP/1.1\r\n" + host + "Connection: close\r\n\r\n",
      "GET /metrics HTTP/1.0\r\n" + host + "\r\n",
      "POST / HTTP/1.1\r\n" + host + "Content-Length: 5\r\n\r\nhello",
      "POST / HTTP/1.1\r\n" + host + "Transfer-Encoding: chunked\r\n\r\n5\r\nhello\r\n0\r\n\r\n",
      "GET /view HTTP/1.1\r\n" + host +
          "Upgrade: websocket\r\nConnection: Upgrade\r\nSec-WebSocket-Version: 13\r\n"
          "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\nSec-WebSocket-Protocol: "
          "hapticd.view.v1\r\nOrigin: http://127.0.0.1:" +
          std::to_string(port) + "\r\n\r\n"};
}

const std::vector<std::string> kMessages{
    R"({"type":"token","token":"secret"})", R"({"type":"shown","sequence":0})",
    R"({"type":"rate","hz":120})", R"({"type":"command","id":1,"line":"pause"})",
    R"({"type":"lead","position":[0,0,0],"orientation":[1,0,0,0]})", R"({"type":"release"})",
    R"({"op":"subscribe","subscriptions":[{"id":1,"channelId":1}]})",
    R"({"op":"unsubscribe","subscriptionIds":[1]})",
    // as a client of Foxglove publishes: opcode, channel, data
    std::string("\x01\x01\0\0\0data", 9), "", std::string(9000, 'x')};

/// Frames of a WebSocket: good ones, ones of any kind, and damaged ones.
std::string frames(FuzzRandom& random, const test::Damage& damage) {
  std::string bytes;
  for (size_t n = random.below(6) + 1; n > 0; --n) {
    const int opcode = random.below(2) == 0 ? test::kText : static_cast<int>(random.below(16));
    // damaged before the mask, so that the parser of JSON sees it
    const std::string& good = random.pick(kMessages);
    const std::string payload = random.below(2) == 0 ? good : damage.apply(good, random, 9000);
    std::string frame =
        SocketClient::frame(opcode, payload, random.below(4) > 0, random.below(8) > 0);
    // reserved bits, as of a compressed frame; another opcode; another length than there is
    if (random.below(8) == 0) frame[0] = static_cast<char>(frame[0] | (1 << (4 + random.below(3))));
    if (random.below(8) == 0) frame[0] = static_cast<char>(random.below(256));
    if (random.below(8) == 0) frame[1] = static_cast<char>(random.below(256));
    bytes += frame;
  }
  return random.below(2) == 0 ? damage.apply(bytes, random) : bytes;
}

void say_anything(uint16_t port, FuzzRandom& random, const test::Damage& damage) {
  SocketClient client(port);
  const std::string host = "127.0.0.1:" + std::to_string(port);
  if (random.below(2) == 0) {
    const std::string good = random.pick(requests(port));
    client.say(random.below(4) == 0 ? good : damage.apply(good, random));
  } else {
    const bool is_page = random.below(2) == 0;
    const int status = client.upgrade(is_page ? "/view" : "/", host, "http://" + host,
                                      is_page ? "hapticd.view.v1" : "foxglove.sdk.v1");
    CHECK(status == 101);
    client.say(frames(random, damage));
  }
  // some hang up at once, some after the other side has
  if (random.below(2) == 0) return;
  shutdown(client.fd(), SHUT_WR);
  client.is_hung_up(0.05);
}

bool serves_honest_page(uint16_t port) {
  SocketClient page(port);
  const std::string host = "127.0.0.1:" + std::to_string(port);
  if (page.upgrade("/view", host, "http://" + host, "hapticd.view.v1") != 101) return false;
  if (page.text_of("scene").empty()) return false;
  for (int i = 0; i < 2; ++i) {
    test::Message m = page.message();
    while (m.opcode == test::kText) m = page.message();
    if (m.opcode != test::kBinary) return false;
    page.tell("{\"type\":\"shown\",\"sequence\":" + std::to_string(i) + "}");
  }
  return test::get(port, "/layout.json").status == 200;
}

}  // namespace

TEST_CASE("view: any bytes on the bridge's socket") {
  const FuzzedBridge bridge;
  REQUIRE(serves_honest_page(bridge.port()));
  const size_t descriptors = test::entries_of("/proc/self/fd");
  const test::Damage damage({"\r\n", "Content-Length: ", "Transfer-Encoding: chunked",
                             "Upgrade: websocket", "\"type\"", "..", "%00", "[[[["});
  const test::FuzzInputs inputs(20261123, test::sweep(400));
  for (uint64_t input = inputs.first; input < inputs.end; ++input) {
    FuzzRandom random(inputs.seed, input);
    say_anything(bridge.port(), random, damage);
    if (input % 100 == 99) {
      CAPTURE(input);
      REQUIRE(serves_honest_page(bridge.port()));
    }
  }
  CHECK(test::eventually([&] { return test::entries_of("/proc/self/fd") <= descriptors; }));
  std::printf("bridge, sockets: inputs %llu to %llu, seed %llu, %.0f s of the processor\n",
              static_cast<unsigned long long>(inputs.first),
              static_cast<unsigned long long>(inputs.end),
              static_cast<unsigned long long>(inputs.seed),
              static_cast<double>(std::clock()) / CLOCKS_PER_SEC);
}

}  // namespace haptic
