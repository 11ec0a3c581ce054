// SPDX-License-Identifier: GPL-3.0-or-later
// Any bytes for what the bridge reads once a request or a message is complete: targets, hosts,
// messages of pages and of Foxglove, answers of hapticd. In this process, so that ten million
// inputs are two minutes of one processor; web_fuzz_test.cpp has the sockets.
#include <catch2/catch.hpp>
#include <cmath>
#include <nlohmann/json.hpp>

#include "clients/view/foxglove.h"
#include "clients/view/messages.h"
#include "clients/view/page_message.h"
#include "clients/view/web/http_rules.h"
#include "tests/fuzz/fuzz_run.h"
#include "tests/fuzz/hostile_input.h"

namespace haptic {
namespace {

using Json = nlohmann::json;
using test::Damage;
using test::FuzzRandom;

const std::vector<std::string> kPageTexts{
    R"({"type":"token","token":"0123456789abcdef0123456789abcdef"})",
    R"({"type":"shown","sequence":41})",
    R"({"type":"shown","sequence":9007199254740992})",
    R"({"type":"shown","sequence":9007199254740993})",
    R"({"type":"rate","hz":120})",
    R"({"type":"command","id":1,"line":"set stiffness 500"})",
    R"({"type":"command","id":"a","line":"clear-fault"})",
    R"({"type":"command","id":2,"line":"stop"})",
    R"({"type":"lead","position":[0.1,-0.2,3e-3],"orientation":[1,0,0,0]})",
    R"({"type":"lead","position":[0,0,0]})",
    R"({"type":"release"})",
    R"({"type":"seek","tick":5})"};
const std::vector<std::string> kFoxgloveTexts{
    R"({"op":"subscribe","subscriptions":[{"id":1,"channelId":1},{"id":2,"channelId":4}]})",
    R"({"op":"unsubscribe","subscriptionIds":[1,2]})",
    R"({"op":"advertise","channels":[{"id":1,"topic":"/x","encoding":"json","schemaName":""}]})",
    R"({"op":"setParameters","parameters":[{"name":"a","value":1}]})"};
const std::vector<std::string> kTargets{"/",           "/view",        "/scene.json",
                                        "/mesh/0.bin", "/metrics?a=b", "/a/../b",
                                        "/%2e%2e",     "//x",          "http://evil.example/"};
const std::vector<std::string> kHosts{"127.0.0.1:8765", "localhost:8765", "[::1]:8765",
                                      "evil.example",   "studio:8765",    "LOCALHOST:8765"};
const std::vector<std::string> kStatus{
    R"~({"clients":3,"closed_by":["a fault (clear it)","another"]})~",
    R"~({"giving":[{"name":"arm","text":"gives, pid 7","state":["late"]}]})~"};
const Damage kDamage({"\"type\"", "\"lead\"", "null", "1e999", "-0", "\\u0000", "[[[[", "}", "..",
                      "%00", "\xff\xfe", "\"", "18446744073709551616", ":8765", "\n", "arm"});

void require(bool holds, const char* what) {
  if (!holds) FAIL(what);
}

std::string any_of(const std::vector<std::string>& texts, FuzzRandom& random) {
  const std::string text = random.pick(texts);
  return random.below(16) == 0 ? text : kDamage.apply(text, random, 8192);
}

/// A message in another form of JSON, where it is one.
std::string written_otherwise(const std::string& text) {
  return " " + text + " ";
}

void check(const CommandMessage& command) {
  require(Json::accept(command.id), "the id of a command is JSON");
  require(Json::accept(answer_message(command.id, true, command.line)), "an answer is JSON");
  if (!command_problem(command.line).empty()) return;
  const std::string word = command.line.substr(0, command.line.find(' '));
  const std::vector<std::string> listed{"pause", "resume", "arm", "disarm", "clear-fault", "set"};
  require(std::count(listed.begin(), listed.end(), word) == 1, "only what is listed is passed on");
  require(command.line.find_first_of(std::string("\0\n\r\t\x1b", 5)) == std::string::npos,
          "a line is one line");
}

void check(const LeadMessage& lead) {
  require(std::isfinite(norm(lead.position_W)) && norm(lead.position_W) < 2e3, "a place is near");
  const std::string line = lead_line(lead);
  require(line.starts_with("lead ") && test::is_one_line(line), "a line leads");
  double p[3] = {};
  require(std::sscanf(line.c_str(), "lead %lf %lf %lf", p, p + 1, p + 2) == 3, "it has the place");
  require(norm(Vec3{p[0], p[1], p[2]} - lead.position_W) < 1e-5, "of the message");
  if (!lead.orientation) return;
  const Quat& q = *lead.orientation;
  require(std::fabs(dot(q, q) - 1) < 1e-9, "an orientation is a unit quaternion");
}

void hear_page(const std::string& text) {
  const PageMessage message = parse_page_message(text);
  require(message.index() == parse_page_message(written_otherwise(text)).index(),
          "spaces around a message change nothing");
  if (const auto* bad = std::get_if<BadMessage>(&message)) throw std::runtime_error(bad->problem);
  require(Json::accept(text), "a message is JSON");
  if (const auto* shown = std::get_if<ShownMessage>(&message)) {
    const PageMessage again = parse_page_message(written_otherwise(text));
    require(std::get<ShownMessage>(again).sequence == shown->sequence, "of the same frame");
  }
  if (const auto* rate = std::get_if<RateMessage>(&message)) {
    require(rate->hz >= 1 && rate->hz <= 120, "a rate is in range");
  }
  if (const auto* command = std::get_if<CommandMessage>(&message)) check(*command);
  if (const auto* lead = std::get_if<LeadMessage>(&message)) check(*lead);
}

void hear_client(FoxgloveClient& client, const View& view, const std::string& text) {
  const std::string problem = hear_foxglove(client, text);
  require(client.channels.size() <= 64, "subscriptions are bounded");
  for (const auto& [id, channel] : client.channels) {
    require(channel >= 1 && channel <= 4, "a subscription is to a channel");
  }
  for (const std::string& message : foxglove_messages(client, view)) {
    require(message.size() > 17 && message[0] == 1, "what is sent is message data");
  }
  require(Json::accept(foxglove_warning(problem)), "a warning is JSON");
  if (!problem.empty()) throw std::runtime_error(problem);
}

void ask(const std::string& text, const std::string& host) {
  WebRules rules;
  rules.port = 8765;
  rules.hosts = {"studio"};
  std::string name = host;
  for (char& c : name) c = c >= 'A' && c <= 'Z' ? static_cast<char>(c + 32) : c;
  const std::vector<std::string> own{"127.0.0.1:8765", "localhost:8765", "[::1]:8765", "studio",
                                     "studio:8765"};
  require(is_host_allowed(rules, host) == (std::count(own.begin(), own.end(), name) == 1),
          "a host is one of the list");
  require(!is_own_origin("http://evil.example", host) || name == "evil.example",
          "an origin is that of the host");
  const Target target = parse_target(text);
  if (!target.problem.empty()) throw std::runtime_error(target.problem);
  require(target.path.starts_with('/') && target.path.find("..") == std::string::npos &&
              target.path.find_first_of(std::string("%\\?\0", 4)) == std::string::npos,
          "a path leads nowhere else");
  require(!media_type(target.path).empty(), "a file has a type");
}

}  // namespace

TEST_CASE("view: any bytes as what the bridge reads in a request or a message") {
  const auto view = std::make_unique<View>();
  view->has_servo = view->has_contacts = view->has_scene = view->has_control = true;
  FoxgloveClient client;
  test::FuzzRun run("bridge, messages", 20261123, 20'000);
  run.run([&](FuzzRandom& random) {
    view->servo.tick = view->contacts.seq = view->scene.seq = random.bits();
    switch (random.below(8)) {
      case 0:
        return ask(any_of(kTargets, random), any_of(kHosts, random));
      case 1:
      case 2:
        if (random.below(64) == 0) client = {};
        return hear_client(client, *view, any_of(kFoxgloveTexts, random));
      case 3: {
        const SessionWords words = parse_status(any_of(kStatus, random));
        return require(Json::accept(status_message(*view, words, 1, 0)), "a status is JSON");
      }
      default:
        return hear_page(any_of(kPageTexts, random));
    }
  });
  CHECK(run.accepted() > run.inputs() / 50);
  CHECK(run.accepted() < run.inputs() / 2);
}

}  // namespace haptic
