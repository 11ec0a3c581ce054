// SPDX-License-Identifier: GPL-3.0-or-later
// A recording of what clients gave is played with the clients that it was recorded with, or not.
#include <catch2/catch.hpp>
#include <string>

#include "clients/log/given_replay.h"
#include "clients/log/trace_writer.h"
#include "tests/support/temporary_folder.h"

namespace haptic {
namespace {

std::string session_with(const std::string& clients) {
  return "[session]\nname = \"given\"\n[device]\nkind = \"simulated-hand\"\n"
         "[[object]]\nname = \"ball\"\nprimitive = \"sphere\"\nsize = \"40 mm\"\n"
         "[[object]]\nname = \"bat\"\nprimitive = \"sphere\"\nsize = \"40 mm\"\n"
         "position = [\"100 mm\", \"0 mm\", \"0 mm\"]\n" +
         clients;
}

std::string client(const std::string& name, const std::string& object) {
  return "[[client]]\nname = \"" + name + "\"\nmay = [\"move " + object + "\"]\n";
}

/// A recording in which the first client has given once, of a session with these clients.
void record_clients(const std::string& path, const std::string& clients) {
  TraceWriter trace(path, recording_metadata("given", session_with(clients)));
  ServoFrame servo{};
  servo.device.flags = kDeviceFresh;
  servo.device.t_ns = servo.t_ns = 1'000'000'000;
  trace.write(servo_topic(kFirstHand), servo, {servo.t_ns, servo.t_ns, 0});
  ControlFrame control{};
  control.giving[0] = 4;
  trace.write(kControlTopic, control, {500'000'000, 500'000'000, 0});
  trace.add_topic(info_of(given_topic(0)));
  GivenFrame given{};
  given.seq = 9;
  given.t_ns = 1'010'000'000;
  trace.write(given_topic(0), given, {given.t_ns, given.t_ns, 0});
  REQUIRE(trace.close());
}

std::string refusal(const std::string& path, const std::string& clients) {
  try {
    const SessionConfig session = parse_config(session_with(clients), "other.toml");
    const GivenReplay replay(path, session, 0);
  } catch (const McapError& error) {
    return error.what();
  }
  return "";
}

}  // namespace

TEST_CASE("given replay: other clients are refused in a line that says how to mend it") {
  const test::TemporaryFolder folder;
  const std::string path = folder.path() + "/given.mcap";
  record_clients(path, client("hitter", "ball") + client("batter", "bat"));
  const std::string remedy =
      "; play it with the session file that it was recorded with, or --without-clients";
  CHECK(refusal(path, client("hitter", "ball")) == "");
  CHECK(refusal(path, "") ==
        path + ": client 'hitter' gave, and this session has no such [[client]]" + remedy);
  CHECK(refusal(path, client("batter", "bat")) ==
        path + ": client 'hitter' gave, and this session has no such [[client]]" + remedy);
  CHECK(refusal(path, client("hitter", "bat")) ==
        path +
            ": client 'hitter' moved object 0 'ball', and in this session it may move object 1 "
            "'bat'" +
            remedy);
}

TEST_CASE("given replay: a client goes by its name, comes, gives, and comes again with the hand") {
  const test::TemporaryFolder folder;
  const std::string path = folder.path() + "/given.mcap";
  record_clients(path, client("hitter", "ball"));
  const SessionConfig session =
      parse_config(session_with(client("batter", "bat") + client("hitter", "ball")), "other.toml");
  GivenReplay replay(path, session, 0);
  GivenAgain out;
  CHECK_FALSE(replay.next(9'000'000'000, out));  // the hand is not played yet
  constexpr int64_t kBegin = 5'000'000'000;
  replay.begin(kBegin);
  REQUIRE(replay.next(kBegin, out));
  CHECK((out.client == 1 && out.generation == 4 && !out.is_frame));
  CHECK_FALSE(replay.next(kBegin + 9'999'999, out));
  REQUIRE(replay.next(kBegin + 10'000'000, out));
  CHECK((out.client == 1 && out.is_frame && out.frame.seq == 9));
  CHECK(out.frame.t_ns == kBegin + 10'000'000);
  CHECK_FALSE(replay.next(kBegin + 10'000'000'000, out));
  // another servo plays the hand from its beginning
  replay.begin(2 * kBegin);
  REQUIRE(replay.next(2 * kBegin, out));
  CHECK((out.generation == 0 && !out.is_frame));
  REQUIRE(replay.next(2 * kBegin, out));
  CHECK((out.generation == 4 && !out.is_frame));
  REQUIRE(replay.next(2 * kBegin + 10'000'000, out));
  CHECK(out.is_frame);
}

}  // namespace haptic
