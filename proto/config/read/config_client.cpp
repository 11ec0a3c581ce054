// SPDX-License-Identifier: Apache-2.0
#include "proto/config/read/config_client.h"

#include <algorithm>
#include <array>
#include <string>
#include <vector>

#include "proto/config/devices.h"

namespace haptic {

using enum Dimension;

namespace {

constexpr Range kForces{0, 50, true};        // [N]; more than any device has
constexpr Range kPowers{0, 20};              // [W]; more than any device gives
constexpr std::string_view kMove = "move ";  // begins a right, before the name of an object
constexpr const char* kRights = "may = [\"move cup\", \"push\"]";

struct RightName {
  std::string_view name;
  ClientRight right;
};
constexpr std::array<RightName, 3> kRightNames{
    {{"push", kMayPush}, {"touch", kMayTouch}, {"draw", kMayDraw}}};

/// The object that a right names.
uint32_t moved_object(Section& section, const std::string& right, const SessionConfig& config) {
  const std::string_view name = std::string_view(right).substr(kMove.size());
  std::vector<std::string_view> known;
  for (uint32_t i = 0; i < config.n_objects; ++i) {
    if (view(config.objects[i].name) == name) return i;
    known.push_back(view(config.objects[i].name));
  }
  section.fail_at(
      "may", "names '" + shown(name) + "', which is no [[object]]; " + suggestion(name, known));
}

/// Throws where something else moves the object.
void check_free(Section& section, const SessionConfig& config, uint32_t object) {
  const ObjectConfig& moved = config.objects[object];
  const std::string name = "'" + shown(view(moved.name)) + "'";
  if (has_mass(moved.body)) {
    section.fail_at("may", "lets a client move " + name +
                               ", which has a mass, so sim moves it; remove its [object.body]");
  }
  if (!row_of(moved.motion.kind).is_still) {
    section.fail_at("may", "lets a client move " + name +
                               ", which follows a script; remove its [object.motion]");
  }
  for (uint32_t c = 0; c <= config.n_clients; ++c) {
    const ClientConfig& other = config.clients[c];
    const auto end = other.moves.begin() + other.n_moves;
    if (std::find(other.moves.begin(), end, object) == end) continue;
    section.fail_at("may", "lets two clients move " + name + ", or one twice; name it once");
  }
}

/// What can be pushed has a place in the counters: bodies and the objects of clients together.
void check_number_of_pushed(Section& section, const SessionConfig& config) {
  auto n = std::ranges::count_if(std::span(config.objects).first(config.n_objects),
                                 [](const auto& object) { return has_mass(object.body); });
  for (uint32_t c = 0; c <= config.n_clients; ++c) n += config.clients[c].n_moves;
  if (n < kMaxBodies) return;
  section.fail_at("may", "moves one object too many; bodies and objects of clients are at most " +
                             std::to_string(kMaxBodies) + " together");
}

void read_right(Section& section, const std::string& right, SessionConfig& config) {
  ClientConfig& client = config.clients[config.n_clients];
  const auto named = std::ranges::find(kRightNames, right, &RightName::name);
  if (named != kRightNames.end()) {
    client.may |= named->right;
    return;
  }
  if (!right.starts_with(kMove)) {
    section.fail_at("may", "has the right '" + shown(right) +
                               "'; write \"move OBJECT\", \"push\", \"touch\" or \"draw\"");
  }
  const uint32_t object = moved_object(section, right, config);
  check_free(section, config, object);
  check_number_of_pushed(section, config);
  if (client.n_moves == kMostGivenMoves) {
    section.fail_at("may", "moves one object too many; " + std::to_string(kMostGivenMoves) +
                               " is the most of a client, make a second [[client]]");
  }
  client.moves[client.n_moves++] = object;
}

void read_client(Section& section, SessionConfig& config) {
  if (config.n_clients == kMostClients) {
    section.fail_at("name", "is one [[client]] too many; " + std::to_string(kMostClients) +
                                " is the most a session can hold, leave one out");
  }
  if (config.device.kind == DeviceKind::kSimulatedArm) {
    section.fail_at("name",
                    "gives to a hand on an admittance device, which feels all of what an "
                    "object is; use a device that is told forces");
  }
  ClientConfig& client = config.clients[config.n_clients];
  section.read_all({{"name", client.name, "name = \"robot\""}, {"user", client.user}});
  for (uint32_t i = 0; i < config.n_clients; ++i) {
    if (config.clients[i].name != client.name) continue;
    section.fail_at("name", "is used twice ('" + shown(view(client.name)) +
                                "'); give each [[client]] its own name");
  }
  std::vector<std::string> rights;
  section.require("may", kRights);
  section.read_texts("may", kMostGivenMoves + kRightNames.size(), kRights, rights);
  for (const std::string& right : rights) read_right(section, right, config);
  section.read_all({{"max_force", kForce, kForces, client.max_force},
                    {"max_power", kPower, kPowers, client.max_power}});
  section.finish();
  ++config.n_clients;
}

}  // namespace

void read_clients(Section& root, SessionConfig& config) {
  for (Section& section : root.sections("client")) read_client(section, config);
}

}  // namespace haptic
