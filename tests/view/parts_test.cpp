// SPDX-License-Identifier: GPL-3.0-or-later
// The parts of the bridge that know no socket: frames, rules, messages, metrics, Foxglove.
#include <regex.h>

#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <set>
#include <sstream>

#include "clients/view/foxglove.h"
#include "clients/view/messages.h"
#include "clients/view/metrics.h"
#include "clients/view/page_message.h"
#include "clients/view/scene.h"
#include "clients/view/viewer.h"
#include "clients/view/web/http_rules.h"
#include "proto/wire/parts.h"
#include "tests/support/frames.h"
#include "tests/view/layout_reader.h"

namespace haptic {
namespace {

using Json = nlohmann::json;
using test::LayoutReader;

/// A view in which every number that a page is shown is another.
std::unique_ptr<View> full_view() {
  auto view = std::make_unique<View>();
  view->has_servo = view->has_contacts = view->has_scene = view->has_control = true;
  ServoFrame& f = view->servo;
  f.tick = 9007199254740991;  // 2⁵³ − 1
  f.t_ns = 5'000'000'000;
  f.X_WT = {{1, 2, 3}, {0.1, 0.2, 0.3, 0.9}};
  f.F_device_B.f = {4, 5, 6};
  f.F_device_B.t = {7, 8, 9};
  f.device.buttons = 3;
  f.pushes.push_back({{{1, 2, 3}, {}}, {}});
  view->X_WB.q = {0, 0, std::sqrt(0.5), std::sqrt(0.5)};  // a quarter turn: x becomes y
  view->now_ns = 5'010'000'000;
  view->scene.objects.push_back(test::scene_object());
  view->scene.objects.push_back(test::scene_object({{0, 0, 10}, {}}));
  test::set_time(view->scene, f.t_ns);
  view->contacts.contacts.resize(3);
  view->contacts.n_active = 1;
  Contact& last = view->contacts.contacts[2];
  last.object = 1;
  last.object_point_O = {0.5, 0, 1};
  last.normal_O = {0, 0, 1};
  last.feature = uint64_t{2} << 62;
  GuideRow guide{};
  guide.object = 1;
  guide.object_point_O = {0, 2, 0};
  view->contacts.guides.push_back(guide);
  return view;
}

/// An extended regular expression of POSIX: GCC 12 warns about its own std::regex under a
/// sanitizer.
class Pattern {
 public:
  explicit Pattern(const std::string& text) {
    REQUIRE(regcomp(&compiled_, ("^(" + text + ")$").c_str(), REG_EXTENDED) == 0);
  }
  ~Pattern() { regfree(&compiled_); }
  Pattern(const Pattern&) = delete;

  /// True if the whole text matches; parts[0] is all of it, then each group.
  bool matches(const std::string& text, std::array<std::string, 5>& parts) const {
    std::array<regmatch_t, 6> found{};
    if (regexec(&compiled_, text.c_str(), found.size(), found.data(), 0) != 0) return false;
    for (size_t i = 0; i < parts.size(); ++i) {
      const regmatch_t& at = found[i + 1];
      parts[i] = at.rm_so < 0 ? ""
                              : text.substr(static_cast<size_t>(at.rm_so),
                                            static_cast<size_t>(at.rm_eo - at.rm_so));
    }
    return true;
  }

 private:
  regex_t compiled_{};
};

}  // namespace

TEST_CASE("view: a frame is read by layout.json alone") {
  const auto view = full_view();
  for (uint64_t i = 0; i < 300; ++i) {
    Sample sample;
    sample.time = static_cast<double>(i);
    sample.flags = static_cast<uint32_t>(i);
    view->samples.add(sample);
  }
  const LayoutReader layout(layout_json());
  FrameOf of = samples_since(view->samples, 100);
  CHECK(of.end_sample - of.first_sample == 200);
  CHECK(samples_since(view->samples, 0).first_sample == 300 - 256);
  CHECK(samples_since(view->samples, 300).first_sample == 300);
  of.sequence = 17;
  of.unseen = 4;
  const auto frame = LayoutReader::numbers(frame_bytes(common_frame(*view), *view, of));
  CHECK(frame.size() == layout.length(frame));
  CHECK(layout.one(frame, "sequence") == 17);
  CHECK(layout.one(frame, "unseen") == 4);
  CHECK(layout.one(frame, "tick") == 9007199254740991.0);
  CHECK(layout.fixed(frame, "tool") == std::vector<double>{1, 2, 3, 0.9, 0.1, 0.2, 0.3});
  CHECK(layout.fixed(frame, "force")[0] == Approx(-5));
  CHECK(layout.fixed(frame, "force")[1] == Approx(4));
  CHECK(layout.fixed(frame, "torque")[2] == Approx(9));
  CHECK(layout.one(frame, "age_servo") == Approx(0.01));
  CHECK(layout.one(frame, "buttons") == 3);
  CHECK(layout.object(frame, 1, "pose") == std::vector<double>{0, 0, 10, 1, 0, 0, 0});
  CHECK(layout.contact(frame, 2, "point") == std::vector<double>{0.5, 0, 11});
  CHECK(layout.contact(frame, 2, "kind")[0] == 2);
  CHECK(layout.contact(frame, 3, "point") == std::vector<double>{0, 2, 10});
  CHECK(layout.contact(frame, 3, "kind")[0] == 3);
  CHECK(layout.contact(frame, 0, "active")[0] == 1);
  CHECK(layout.contact(frame, 2, "active")[0] == 0);
  CHECK(layout.sample(frame, 0, "time")[0] == 100);
  CHECK(layout.sample(frame, 199, "flags")[0] == 299);
}

TEST_CASE("view: nothing that a ring could hold leads out of a frame") {
  const auto view = full_view();
  view->scene.objects.resize(kMaxObjects);
  view->scene.objects[5].response = 4'000'000'000;
  view->scene.joints.resize(kMaxJoints);
  view->contacts.contacts.resize(kMaxContacts);
  view->contacts.contacts[5].object = 4'000'000'000;
  view->contacts.guides.resize(kMaxGuideRows);
  view->contacts.guides[5].object = 4'000'000'000;
  const auto frame = LayoutReader::numbers(frame_bytes(common_frame(*view), *view, {}));
  const LayoutReader layout(layout_json());
  CHECK(layout.count(frame, "n_objects") == kMaxObjects);
  CHECK(layout.count(frame, "n_joints") == kMaxJoints);
  CHECK(layout.count(frame, "n_listed") == kMaxContacts + kMaxGuideRows);
  CHECK(frame.size() == layout.length(frame));
}

TEST_CASE("view: a viewer gets the newest frame, and is told what it has not seen") {
  const auto view = full_view();
  Viewer viewer;
  view->now_ns = 1'000'000'000;
  const LayoutReader layout(layout_json());
  const auto next = [&] {
    const WebMessage message = InstantFrames(*view).next(viewer);
    return LayoutReader::numbers(message.own + message.bytes->substr(message.own.size()));
  };
  view->ticks = 50;
  CHECK(layout.one(next(), "unseen") == 0);
  CHECK(!is_ready(viewer));  // until it has shown that
  viewer.has_shown = true;
  CHECK(is_ready(viewer));
  CHECK(!is_due(viewer, view->now_ns + kTickPeriod));  // 60 Hz
  CHECK(is_due(viewer, view->now_ns + 2 * kTickPeriod));
  viewer.hz = 120;
  CHECK(is_due(viewer, view->now_ns + kTickPeriod));
  view->ticks = 150;
  const auto frame = next();
  CHECK(layout.one(frame, "unseen") == 99);
  CHECK(layout.one(frame, "sequence") == 1);
}

TEST_CASE("view: the rate of contact in a sample is that of the last tenth of a second") {
  Samples samples;
  for (int i = 0; i < 1000; ++i) {
    Sample sample;
    sample.time = 0.001 * i;
    sample.contact_seq = static_cast<uint64_t>(i < 500 ? i : 500 + (i - 500) / 2);
    samples.add(sample);
  }
  CHECK(samples.at(520).contact_rate == Approx(900).margin(11));
  CHECK(samples.at(999).contact_rate == Approx(500).margin(11));
  Sample restarted;
  restarted.time = 1;
  samples.add(restarted);
  CHECK(samples.at(1000).contact_rate == 0);
}

TEST_CASE("view: a rate is counts over the last second") {
  RateMeter meter;
  CHECK(meter.rate() == 0);
  for (int i = 0; i <= 240; ++i) meter.add(i * int64_t{8'333'333}, static_cast<uint64_t>(8 * i));
  CHECK(meter.rate() == Approx(960).epsilon(0.02));
  meter.add(int64_t{2'100'000'000}, 3);  // its writer was replaced
  CHECK(meter.rate() == 0);
}

TEST_CASE("view: hosts, origins and paths") {
  const WebRules rules{8765, {"desk.example", "tunnel:9000"}, {"https://app.foxglove.dev"}};
  for (const char* host : {"127.0.0.1:8765", "localhost:8765", "LOCALHOST:8765", "[::1]:8765",
                           "desk.example", "desk.example:8765", "tunnel:9000"}) {
    CAPTURE(host);
    CHECK(is_host_allowed(rules, host));
  }
  for (const char* host : {"", "evil.example", "evil.example:8765", "127.0.0.1", "127.0.0.1:80",
                           "localhost.evil.example:8765", "127.0.0.1:8765.evil.example", "tunnel",
                           "tunnel:8765x", ":8765"}) {
    CAPTURE(host);
    CHECK(!is_host_allowed(rules, host));
  }
  CHECK(is_own_origin("http://127.0.0.1:8765", "127.0.0.1:8765"));
  CHECK(!is_own_origin("http://evil.example", "127.0.0.1:8765"));
  CHECK(!is_own_origin("", "127.0.0.1:8765"));
  CHECK(!is_own_origin("null", "127.0.0.1:8765"));
  CHECK(is_origin_allowed(rules, "https://app.foxglove.dev"));
  CHECK(!is_origin_allowed(rules, "https://app.foxglove.dev.evil.example"));
  CHECK(parse_target("/scene.json?x=1").path == "/scene.json");
  CHECK(parse_target("/scene.json?x=1").query == "x=1");
  for (const std::string target :
       {"", "x", "/../etc/passwd", "/a/..", "/%2e%2e/x", "/a\\b", "http://evil.example/"}) {
    CAPTURE(target);
    CHECK(!parse_target(target).problem.empty());
  }
  CHECK(!parse_target(std::string("/a\0b", 4)).problem.empty());
  CHECK(is_same_secret("abc", "abc"));
  CHECK(!is_same_secret("abc", "abd"));
  CHECK(!is_same_secret("abc", "ab"));
  CHECK(!is_same_secret("abc", ""));
}

TEST_CASE("view: a page can say what steers the hand, and nothing else") {
  for (const char* line :
       {"pause", "resume", "arm", "disarm", "clear-fault", "set stiffness 500 N/m"}) {
    CAPTURE(line);
    CHECK(command_problem(line).empty());
  }
  for (const std::string line :
       {"stop", "config", "status", "", " pause", "pause\nstop", "setx", "lead 0 0 0"}) {
    CAPTURE(line);
    CHECK(!command_problem(line).empty());
  }
  CHECK(!command_problem("set " + std::string(10000, 'x')).empty());
}

TEST_CASE("view: messages of a page") {
  const auto bad = [](const std::string& text) {
    return std::holds_alternative<BadMessage>(parse_page_message(text));
  };
  CHECK(std::get<TokenMessage>(parse_page_message(R"({"type":"token","token":"x"})")).token == "x");
  CHECK(std::get<ShownMessage>(parse_page_message(R"({"type":"shown","sequence":7})")).sequence ==
        7);
  CHECK(std::get<RateMessage>(parse_page_message(R"({"type":"rate","hz":120})")).hz == 120);
  const auto command =
      std::get<CommandMessage>(parse_page_message(R"({"type":"command","id":3,"line":"pause"})"));
  CHECK(command.id == "3");
  CHECK(command.line == "pause");
  const auto lead = std::get<LeadMessage>(
      parse_page_message(R"({"type":"lead","position":[0.1,0,-0.2],"orientation":[1,0,0,0]})"));
  CHECK(lead_line(lead) == "lead 0.1 0 -0.2 1 0 0 0");
  CHECK(lead_line(std::get<LeadMessage>(
            parse_page_message(R"({"type":"lead","position":[1,2,3]})"))) == "lead 1 2 3");
  CHECK(std::holds_alternative<ReleaseMessage>(parse_page_message(R"({"type":"release"})")));
  CHECK(std::holds_alternative<LogMessage>(parse_page_message(R"({"type":"seek","tick":1})")));
  for (const char* text :
       {"", "x", "[]", "{}", R"({"type":1})", R"({"type":"shown"})",
        R"({"type":"shown","sequence":-1})", R"({"type":"shown","sequence":1e300})",
        R"({"type":"rate","hz":0})", R"({"type":"rate","hz":121})",
        R"({"type":"lead","position":[1,2]})", R"({"type":"lead","position":[1,2,1e9]})",
        R"({"type":"lead","position":[1,2,3],"orientation":[0,0,0,0]})",
        R"({"type":"command","id":{},"line":"x"})", R"({"type":"token","token":7})"}) {
    CAPTURE(text);
    CHECK(bad(text));
  }
  CHECK(bad(std::string(100'000, '[')));
}

TEST_CASE("view: messages to a page are JSON whatever they hold") {
  const std::string foreign = "a\"b\n\x1b[2J\xff</script>";
  for (const std::string& text :
       {hello_message("session", foreign, 1.5), gone_message(foreign),
        control_message(false, foreign), answer_message("7", true, foreign)}) {
    CAPTURE(text);
    CHECK(Json::parse(text).is_object());
    CHECK(text.find('\n') == text.npos);
    CHECK(text.find('\x1b') == text.npos);
  }
  const SessionWords words = parse_status(
      R"json({"clients": 3, "closed_by": ["paused ('hapt resume')", "waiting for contacts"]})json");
  const auto owner = full_view();
  View& view = *owner;
  view.processes[0] = {"servo0", 123, 2, true, 0.001, 1000};
  const Json status = Json::parse(status_message(view, words, 2, 5));
  CHECK(status["clients"] == 3);
  CHECK(status["processes"].size() == 1);
  CHECK(status["processes"][0]["generation"] == 2);
  CHECK(status["faults"][0]["text"] == "paused");
  CHECK(status["faults"][0]["remedy"] == "'hapt resume'");
  CHECK(status["faults"][1]["remedy"] == "");
  CHECK(status["warnings"].empty());
  CHECK(parse_status("nonsense").closed_by.empty());
  const SessionWords fallen = parse_status(R"json({"out_of_reach": 2, "reach": 1.5})json");
  const Json gone = Json::parse(status_message(view, fallen, 2, 5))["warnings"];
  CHECK(gone.size() == 1);
  CHECK(gone[0]["text"] == "2 bodies out of reach (1.5 m)");
  CHECK(gone[0]["remedy"] == kMendOutOfReach);
}

TEST_CASE(
    "view: the scene says what the session file says, and keeps its text for who may control") {
  SceneInfo info;
  info.session = "here";
  const std::string text =
      "# a secret\n[session]\nname = \"here\"\n[coupling]\nstiffness = \"800 N/m\"\n"
      "[device]\nkind = \"simulated-hand\"\n"
      "[[object]]\nname = \"block\"\nprimitive = \"box\"\nextent = [\"80 mm\", \"80 mm\", \"80 "
      "mm\"]\n";
  CHECK(use_config(info, text) == "");
  const auto view = full_view();
  view->scene.objects.resize(1);
  const std::string watching = scene_json(info, *view, false);
  const Json scene = Json::parse(watching);
  CHECK(scene["objects"].size() == 1);
  CHECK(scene["objects"][0]["name"] == "block");
  CHECK(scene["limits"]["stiffness"] == 800);
  CHECK(scene["device"]["simulated"] == true);
  CHECK(scene["solvers"].size() == 3);
  CHECK(scene["renderers"].size() == 9);
  CHECK(scene["renderers"][0]["available"] == true);
  CHECK(scene["renderers"][0]["has_solver"] == false);
  CHECK(scene["renderers"][3]["name"] == "direct6");
  CHECK(scene["renderers"][3]["has_solver"] == true);
  CHECK(scene["objects"][0]["mesh"].is_null());
  CHECK(scene["objects"][0]["pieces"].is_null());
  info.eyes.objects = info.eyes.object_pieces = {shared_text("eye")};
  const Json with_eyes = Json::parse(scene_json(info, *view, false));
  CHECK(with_eyes["objects"][0]["mesh"] == "/mesh/0.bin");
  CHECK(with_eyes["objects"][0]["pieces"] == "/pieces/0.bin");
  CHECK(with_eyes["tool"]["pieces"].is_null());
  CHECK(!scene.contains("started"));
  info.started = 12.5;
  CHECK(Json::parse(scene_json(info, *view, false))["started"] == 12.5);
  CHECK(watching.find("secret") == watching.npos);
  CHECK(Json::parse(scene_json(info, *view, true))["config"] == text);
  CHECK(use_config(info, "nonsense = [") != "");
  CHECK(Json::parse(scene_json(info, *view, false))["objects"].size() == 1);
}

TEST_CASE("view: metrics follow the exposition format") {
  const auto view = full_view();
  view->processes[1] = {"contact0", 12, 3, true, 0, 0};
  view->busy = {0.5, 1000};
  std::istringstream lines(metrics_text(*view, {2, 3, 100, 4, 1}, true));
  std::map<std::string, std::string> type, value;
  for (std::string line; std::getline(lines, line);) {
    CAPTURE(line);
    std::istringstream words(line);
    std::string first, second, third;
    words >> first >> second >> third;
    if (first == "#") {
      CHECK((second == "HELP" || second == "TYPE"));
      if (second == "TYPE") words >> type[third];
      continue;
    }
    std::string family = first.substr(0, first.find('{'));
    for (const std::string end : {"_sum", "_count"}) {
      if (family.ends_with(end)) family.erase(family.size() - end.size());
    }
    CHECK(type.count(family) == 1);
    if (type[family] == "counter") CHECK(family.ends_with("_total"));
    char* end = nullptr;
    std::strtod(second.c_str(), &end);
    CHECK(*end == '\0');
    value[first] = second;
  }
  CHECK(value.at("haptic_servo_busy_seconds_count") == "1000");
  CHECK(value.at("haptic_process_restarts_total{process=\"contact0\"}") == "2");
  CHECK(value.at("haptic_view_frames_sent_total") == "100");
  CHECK(value.at("haptic_session_up") == "1");
}

TEST_CASE("view: Foxglove clients get the newest record of what they subscribe to") {
  const Json offer = Json::parse(foxglove_advertise());
  CHECK(offer["op"] == "advertise");
  CHECK(offer["channels"].size() == 4);
  CHECK(offer["channels"][0]["encoding"] == "cdr");
  CHECK(Json::parse(foxglove_server_info("s"))["op"] == "serverInfo");
  const auto view = full_view();
  FoxgloveClient client;
  CHECK(foxglove_messages(client, *view).empty());
  CHECK(hear_foxglove(client, R"({"op":"subscribe","subscriptions":[{"id":9,"channelId":1}]})") ==
        "");
  const auto messages = foxglove_messages(client, *view);
  REQUIRE(messages.size() == 1);
  // opcode, subscription, time, CDR header; then the record: its fields, and behind their number,
  // aligned to eight bytes, the pushes; then the number of clients that are felt, none
  constexpr size_t kFields = kParts<ServoFrame>[0].offset;
  REQUIRE(messages[0].size() == 1 + 4 + 8 + 4 + kFields + 8 + sizeof(ObjectPush) + 4);
  CHECK(messages[0][0] == 1);
  CHECK(messages[0][1] == 9);
  CHECK(messages[0].substr(13, 4) == std::string("\0\1\0\0", 4));  // CDR, little endian
  CHECK(std::memcmp(messages[0].data() + 17, &view->servo, kFields) == 0);
  CHECK(messages[0].substr(17 + kFields, 4) == std::string("\1\0\0\0", 4));
  CHECK(std::memcmp(messages[0].data() + 17 + kFields + 8, view->servo.pushes.data(),
                    sizeof(ObjectPush)) == 0);
  CHECK(foxglove_messages(client, *view).empty());  // nothing newer
  --view->servo.tick;
  CHECK(foxglove_messages(client, *view).size() == 1);
  CHECK(hear_foxglove(client, R"({"op":"unsubscribe","subscriptionIds":[9]})") == "");
  --view->servo.tick;
  CHECK(foxglove_messages(client, *view).empty());
  for (const char* text : {"", "[]", R"({"op":"subscribe"})",
                           R"({"op":"subscribe","subscriptions":[{"id":1,"channelId":99}]})",
                           R"({"op":"subscribe","subscriptions":[{"id":-1,"channelId":1}]})",
                           R"({"op":"subscribe","subscriptions":7})"}) {
    CAPTURE(text);
    CHECK(hear_foxglove(client, text) != "");
  }
  CHECK(hear_foxglove(client, R"({"op":"fetchAsset"})") == "");
}

TEST_CASE("view: the metrics are Prometheus text, version 0.0.4") {
  auto view = full_view();
  view->processes[0] = {"servo0", 7, 3, true, 0, 0};
  view->processes[1] = {"contact0", 8, 1, true, 0, 0};
  // what has no number yet, and what a ring could hold
  for (const double odd : {0.0, std::nan(""), HUGE_VAL, -HUGE_VAL, 1e-310}) {
    view->rate_servo = view->servo.depth = odd;
    view->has_contacts = odd == 0;
    const std::string text = metrics_text(*view, {}, true);
    REQUIRE(text.ends_with('\n'));
    // as the format's description has it: exposition_formats.md of Prometheus
    const std::string name = "[a-zA-Z_:][a-zA-Z0-9_:]*";
    const Pattern help("# HELP (" + name + R"re() ([^\]|\\\\|\\n)*)re");
    const Pattern type("# TYPE (" + name + ") (counter|gauge|summary)");
    const Pattern sample("(" + name +
                         R"re()(\{[a-zA-Z_][a-zA-Z0-9_]*="([^"\]|\\["\n])*"\})? ([^ ]+))re");
    const Pattern number(R"([+-]?([0-9]+(\.[0-9]*)?|\.[0-9]+)([eE][+-]?[0-9]+)?|NaN|[+-]Inf)");
    std::set<std::string> helped, typed, said;
    std::string family, kind;
    std::istringstream lines(text);
    for (std::string line; std::getline(lines, line);) {
      CAPTURE(line);
      std::array<std::string, 5> parts;
      if (help.matches(line, parts)) {
        CHECK(helped.insert(parts[1]).second);
        continue;
      }
      if (type.matches(line, parts)) {
        family = parts[1];
        kind = parts[2];
        CHECK(typed.insert(family).second);
        CHECK((kind == "counter") == family.ends_with("_total"));
        continue;
      }
      REQUIRE(sample.matches(line, parts));
      const std::string of = parts[1];
      if (kind == "summary") {
        CHECK((of == family + "_sum" || of == family + "_count"));
      } else {
        CHECK(of == family);
      }
      CHECK(said.insert(of + parts[2]).second);
      const std::string value = parts[4];
      CHECK(number.matches(value, parts));
    }
    CHECK(helped == typed);
    CHECK(said.count("haptic_process_restarts_total{process=\"servo0\"}") == 1);
  }
}

TEST_CASE("view: a line of each client that may give, and whether all is well with it") {
  const SessionWords words = parse_status(
      R"json({"giving": [{"name": "arm", "text": "gives, pid 7, 100 Hz", "state": []}, 5, {"name": 1},
                         {"name": "a\nb", "text": "gives; late", "state": ["late"]}, null]})json");
  const auto view = full_view();
  const Json giving = Json::parse(status_message(*view, words, 2, 5))["giving"];
  REQUIRE(giving.size() == 2);
  CHECK(giving[0] == Json{{"name", "arm"}, {"text", "gives, pid 7, 100 Hz"}, {"well", true}});
  CHECK(giving[1]["name"] == "a\\nb");
  CHECK(giving[1]["well"] == false);
  for (const char* text : {R"({"giving": 5})", R"({"giving": {"name": "x"}})", "{}"}) {
    CHECK(parse_status(text).giving.empty());
  }
}

}  // namespace haptic
