// SPDX-License-Identifier: GPL-3.0-or-later
#include "clients/view/page_message.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <stdexcept>

#include "proto/os/json.h"
#include "proto/os/text.h"

namespace haptic {
namespace {

constexpr double kSlowest = 1, kFastest = 120;          // frames a second that can be asked for
constexpr double kMostSequence = 9007199254740992;      // 2⁵³
constexpr double kFarthest = 1e3;                       // [m]; of a place to lead to
constexpr double kSlowestPlay = 0.1, kFastestPlay = 4;  // times real time
constexpr size_t kLongestId = 64;                       // of a command, as JSON [bytes]

/// The member of that name; throws where it is missing.
const Json& member(const Json& object, const char* name) {
  const auto found = object.find(name);
  if (found == object.end()) throw std::runtime_error(std::string("lacks ") + name);
  return *found;
}

std::string text_in(const Json& object, const char* name) {
  const Json& value = member(object, name);
  if (!value.is_string()) throw std::runtime_error(std::string(name) + " is no text");
  return value.get<std::string>();
}

double number_of(const Json& value, const char* name, double low, double high) {
  if (!value.is_number()) throw std::runtime_error(std::string(name) + " is no number");
  const double number = value.get<double>();
  // also false for NaN
  if (!(number >= low && number <= high)) {
    throw std::runtime_error(std::string(name) + " is out of range");
  }
  return number;
}

template <size_t N>
std::array<double, N> numbers_of(const Json& value, const char* name, double most) {
  if (!value.is_array() || value.size() != N) {
    throw std::runtime_error(std::string(name) + " has not " + std::to_string(N) + " numbers");
  }
  std::array<double, N> numbers{};
  for (size_t i = 0; i < N; ++i) numbers[i] = number_of(value[i], name, -most, most);
  return numbers;
}

LeadMessage lead_of(const Json& message) {
  LeadMessage lead;
  const auto p = numbers_of<3>(member(message, "position"), "position", kFarthest);
  lead.position_W = {p[0], p[1], p[2]};
  const auto turned = message.find("orientation");
  if (turned == message.end() || turned->is_null()) return lead;
  const auto q = numbers_of<4>(*turned, "orientation", 1.01);
  const Quat orientation{q[1], q[2], q[3], q[0]};
  if (std::fabs(std::sqrt(dot(orientation, orientation)) - 1) > 1e-3) {
    throw std::runtime_error("orientation is no unit quaternion");
  }
  lead.orientation = normalized(orientation);
  return lead;
}

CommandMessage command_of(const Json& message) {
  const Json& id = member(message, "id");
  if (!id.is_string() && !id.is_number()) throw std::runtime_error("id is no number or text");
  CommandMessage command{id.dump(), text_in(message, "line")};
  if (command.id.size() > kLongestId) throw std::runtime_error("id is too long");
  return command;
}

uint64_t tick_in(const Json& message, const char* name) {
  return static_cast<uint64_t>(number_of(member(message, name), name, 0, kMostSequence));
}

NextMessage next_of(const Json& message) {
  const std::string kind = text_in(message, "kind");
  const auto known = std::ranges::find(kMarkKinds, kind);
  if (known == kMarkKinds.end()) throw std::runtime_error("has an unknown kind");
  return {static_cast<MarkKind>(known - kMarkKinds.begin()),
          number_of(member(message, "direction"), "direction", -1, 1) > 0};
}

LoopMessage loop_of(const Json& message) {
  const Json& from = member(message, "from");
  if (from.is_null()) return {};
  const uint64_t begin = tick_in(message, "from");
  return {{{begin, std::max(begin, tick_in(message, "to"))}}};
}

/// The number of a member, as a T.
template <typename T = double>
T member_number(const Json& message, const char* name, double low, double high) {
  return static_cast<T>(number_of(member(message, name), name, low, high));
}

struct MessageRow {
  std::string_view type;
  PageMessage (*read)(const Json& message);
};
constexpr std::array<MessageRow, 12> kMessages{{
    {"token", [](const Json& m) -> PageMessage { return TokenMessage{text_in(m, "token")}; }},
    {"shown",
     [](const Json& m) -> PageMessage {
       return ShownMessage{member_number<uint64_t>(m, "sequence", 0, kMostSequence)};
     }},
    {"rate",
     [](const Json& m) -> PageMessage {
       return RateMessage{member_number(m, "hz", kSlowest, kFastest)};
     }},
    {"command", [](const Json& m) -> PageMessage { return command_of(m); }},
    {"lead", [](const Json& m) -> PageMessage { return lead_of(m); }},
    {"release", [](const Json&) -> PageMessage { return ReleaseMessage{}; }},
    {"seek", [](const Json& m) -> PageMessage { return SeekMessage{tick_in(m, "tick")}; }},
    {"play",
     [](const Json& m) -> PageMessage {
       return PlayMessage{member_number(m, "speed", kSlowestPlay, kFastestPlay)};
     }},
    {"stop", [](const Json&) -> PageMessage { return StopMessage{}; }},
    {"step",
     [](const Json& m) -> PageMessage {
       return StepMessage{member_number<int64_t>(m, "ticks", -kMostSequence, kMostSequence)};
     }},
    {"next", [](const Json& m) -> PageMessage { return next_of(m); }},
    {"loop", [](const Json& m) -> PageMessage { return loop_of(m); }},
}};

PageMessage message_of(const Json& message) {
  if (!message.is_object()) throw std::runtime_error("is no object");
  const auto row = std::ranges::find(kMessages, text_in(message, "type"), &MessageRow::type);
  if (row == kMessages.end()) throw std::runtime_error("has an unknown type");
  return row->read(message);
}

/// The message that comes after each frame, as the page writes it, without the cost of a parser of
/// JSON. Nothing where it is written in another way.
std::optional<ShownMessage> plain_shown(std::string_view text) {
  constexpr std::string_view kHead = R"({"type":"shown","sequence":)";
  if (!text.starts_with(kHead)) return std::nullopt;
  const char *begin = text.data() + kHead.size(), *end = text.data() + text.size();
  ShownMessage shown;
  const auto [at, error] = std::from_chars(begin, end, shown.sequence);
  if (error != std::errc() || end - at != 1 || *at != '}') return std::nullopt;
  const bool is_json = *begin != '0' || at - begin == 1;  // which has no leading zeros
  // compared as integers: 2⁵³ + 1 is no double
  const bool is_known = shown.sequence <= static_cast<uint64_t>(kMostSequence);
  return is_json && is_known ? std::optional(shown) : std::nullopt;
}

}  // namespace

PageMessage parse_page_message(std::string_view text) {
  if (const auto shown = plain_shown(text)) return *shown;
  const Json message = Json::parse(text, nullptr, false);
  if (message.is_discarded()) return BadMessage{"the message is no JSON"};
  try {
    return message_of(message);
  } catch (const std::exception& error) {
    return BadMessage{"the message " + std::string(error.what())};
  }
}

std::string lead_line(const LeadMessage& lead) {
  const Vec3& p = lead.position_W;
  const std::string line = formatted("lead %.9g %.9g %.9g", p.x, p.y, p.z);
  if (!lead.orientation) return line;
  const Quat& q = *lead.orientation;
  return line + formatted(" %.9g %.9g %.9g %.9g", q.w, q.x, q.y, q.z);
}

std::string release_line() {
  return "release";
}

}  // namespace haptic
