// SPDX-License-Identifier: Apache-2.0
#include "proto/config/config.h"

#include <algorithm>
#include <array>
#include <filesystem>
#include <span>
#include <string>

#include "proto/config/devices.h"
#include "proto/config/hand_config.h"
#include "proto/config/read/config_body.h"
#include "proto/config/read/config_client.h"
#include "proto/config/read/config_device.h"
#include "proto/config/read/config_joint.h"
#include "proto/config/read/config_material.h"
#include "proto/config/read/config_section.h"
#include "proto/config/read/config_shape.h"
#include "proto/config/read/config_tool.h"
#include "proto/config/renderer_needs.h"
#include "proto/os/message.h"
#include "proto/os/regular_file.h"
#include "proto/os/source_tree.h"
#include "proto/wire/renderer.h"

namespace haptic {

using enum Dimension;

namespace {

constexpr auto kRendererWords = words_of(kRenderers);

namespace fs = std::filesystem;

constexpr Words<Wake, 2> kWakes{{{"sleep", Wake::kSleep}, {"hybrid", Wake::kHybrid}}};
constexpr auto kMotionWords = words_of(kMotions);
// [Hz], the servo's grid: slower is no haptics, faster than any device
constexpr Range kServoRates{100, 10e3};
constexpr Range kPollRates{10, 100e3};       // [Hz]
constexpr Range kMeshMemory{1 << 20, 1e15};  // [bytes]
constexpr Range kProxyRadii{0, 0.1};         // [m]; a larger one exceeds any scene
constexpr int64_t kButtons = 32;             // bits of DeviceState::buttons
// tables that a [[hand]] may have for itself
constexpr std::array<std::string_view, 8> kTablesOfHand{"device", "map",   "tool",  "coupling",
                                                        "safety", "proxy", "servo", "contact"};

void read_session(Section& root, SessionConfig& config) {
  root.within(
      "session",
      [&](Section& session) {
        session.read_all({{"name", config.name, "name = \"bunny\""}});
        const std::string problem = session_name_problem(view(config.name));
        if (!problem.empty()) session.fail_at("name", problem);
        session.read_all({{"renderer", kRendererWords, config.renderer},
                          {"realtime", config.realtime},
                          {"hands_touch", config.hands_touch}});
      },
      "[session] with name = \"bunny\"");
}

/// The hands' names, and what the hand with this number has beside tables of its own.
void read_hand(Section& root, uint32_t hand, SessionConfig& config) {
  std::vector<Section> hands = root.sections("hand");
  if (hands.empty()) return;
  if (hands.size() > kMostHands) {
    hands.back().fail_at("name", "is one [[hand]] too many; " + std::to_string(kMostHands) +
                                     " is the most a session can have");
  }
  config.hand = hand;
  config.n_hands = static_cast<uint32_t>(hands.size());
  for (uint32_t k = 0; k < config.n_hands; ++k) {
    Name& name = config.hand_names[k];
    hands[k].read_all({{"name", name, "name = \"left\""}});
    std::string problem = hand_name_problem(view(name));
    if (std::find(config.hand_names.begin(), &name, name) != &name) {
      problem = "is used twice ('" + shown(view(name)) + "'); give each [[hand]] its own name";
    }
    if (!problem.empty()) hands[k].fail_at("name", problem);
  }
  hands[hand].read_all({{"renderer", kRendererWords, config.renderer}});
  hands[hand].finish();
}

void read_rates(Section& root, SessionConfig& config) {
  root.within("servo", [&](Section& servo) {
    servo.read_all({{"rate", kFrequency, kServoRates, config.servo_rate},
                    {"wake", kWakes, config.servo_wake}});
  });
  root.within("contact", [&](Section& contact) {
    double bytes = static_cast<double>(config.mesh_memory_limit);
    contact.read_all({{"poll_rate", kFrequency, kPollRates, config.contact_poll_rate},
                      {"proxy_radius", kLength, kProxyRadii, config.proxy_radius},
                      {"mesh_memory_limit", kMemory, kMeshMemory, bytes},
                      {"spare", config.contact_spare}});
    config.mesh_memory_limit = static_cast<uint64_t>(bytes);
    read_voxel(contact, config.voxel);
    read_pieces(contact, config.pieces);
    read_rigid(contact, config.rigid);
  });
}

void read_map(Section& root, DeviceMap& map) {
  root.within("map", [&](Section& section) {
    section.read_pose(map.X_WB);
    section.read_all({{"motion_scale", kPositive, map.motion_scale},
                      {"force_scale", kPositive, map.force_scale}});
    section.within("tool_on_grip", [&](Section& tool) { tool.read_pose(map.X_HT); });
    section.read_all({{"clutch_button", 0, kButtons - 1, map.clutch_button},
                      {"grasp_button", 0, kButtons - 1, map.grasp_button}});
  });
}

void read_coupling(Section& root, Coupling& coupling) {
  root.within("coupling", [&](Section& section) {
    section.read_all(
        {{"stiffness", kStiffness, kNotNegative, coupling.translational_stiffness},
         {"damping", kDamping, kNotNegative, coupling.translational_damping},
         {"rotational_stiffness", kRotationalStiffness, kNotNegative,
          coupling.rotational_stiffness},
         {"rotational_damping", kRotationalDamping, kNotNegative, coupling.rotational_damping},
         {"max_force", kForce, kPositive, coupling.max_force},
         {"max_torque", kTorque, kPositive, coupling.max_torque}});
  });
}

void read_safety(Section& root, DeviceKind device, SafetyConfig& safety) {
  // real motors need an explicit `hapt arm`
  safety.armed_at_start = row_of(device).has_node() ? 0 : 1;
  root.within("safety", [&](Section& section) {
    section.read_all(
        {{"max_force", kForce, kPositive, safety.max_force},
         {"max_torque", kTorque, kNotNegative, safety.max_torque},
         {"soft_start", kTime, kNotNegative, safety.soft_start},
         {"slew", kForceRate, kPositive, safety.slew},
         {"torque_slew", kTorqueRate, kPositive, safety.torque_slew},
         {"velocity_limit", kSpeed, kPositive, safety.velocity_limit},
         {"angular_velocity_limit", kAngularSpeed, kPositive, safety.angular_velocity_limit},
         {"dead_man_button", 0, kButtons - 1, safety.dead_man_button},
         {"armed_at_start", safety.armed_at_start}});
  });
}

void read_motion(Section& object, MotionConfig& motion) {
  object.within("motion", [&](Section& section) {
    section.read_all({{"kind", kMotionWords, motion.kind, "kind = \"oscillate\""}});
    const MotionKindRow& row = row_of(motion.kind);
    if (row.is_still) return;
    section.read_direction("axis", motion.axis_O);
    section.read_all({{"amplitude", kLength, kNotNegative, motion.amplitude},
                      {"frequency", kFrequency, kNotNegative, motion.frequency}});
    section.require("frequency", "frequency = \"0.5 Hz\"");
    if (row.has_amplitude) section.require("amplitude", "amplitude = \"5 mm\"");
  });
}

void check_number_of_bodies(Section& section, const SessionConfig& config) {
  const auto n = std::ranges::count_if(std::span(config.objects).first(config.n_objects),
                                       [](const auto& object) { return has_mass(object.body); });
  if (n <= kMaxBodies) return;
  section.fail_at("body", "is one [object.body] too many; " + std::to_string(kMaxBodies) +
                              " is the most a session can hold, leave it out of what may stand");
}

void read_object(Section& section, SessionConfig& config, const fs::path& config_folder) {
  if (config.n_objects == kMaxObjects) {
    section.fail_at("name", "is one [[object]] too many; " + std::to_string(kMaxObjects) +
                                " is the most a session can hold, join some meshes");
  }
  ObjectConfig& object = config.objects[config.n_objects];
  section.read_all({{"name", object.name, "name = \"bunny\""}});
  for (uint32_t i = 0; i < config.n_objects; ++i) {
    if (config.objects[i].name == object.name) {
      section.fail_at("name", "is used twice ('" + shown(view(object.name)) +
                                  "'); give each [[object]] its own name");
    }
  }
  read_shape(section, config_folder, object);
  object.colour = default_colour(config.n_objects);
  read_colour(section, object);
  section.read_pose(object.X_WO);
  read_motion(section, object.motion);
  read_material(section, config, config_folder, object.material);
  read_body(section, object, object.body);
  section.finish();
  ++config.n_objects;
  check_number_of_bodies(section, config);
}

/// A 6-DoF renderer needs a mesh and, if it has a proxy, springs.
void check_body(Section& root, const SessionConfig& config) {
  if (!is_of_body(config.renderer)) return;
  if (!has_mesh(config.tool)) {
    root.section("session")->fail_at(
        "renderer",
        "moves a tool with six degrees of freedom, and there is none; add [tool] with "
        "mesh = \"bunny00.off\" or primitive = \"sphere\"");
  }
  const Coupling& coupling = config.coupling;
  if (!has_springs(config.proxy, config.renderer)) return;
  if (coupling.translational_stiffness > 0 && coupling.rotational_stiffness > 0) return;
  root.section("session")->fail_at(
      "renderer",
      "has a proxy that moves and turns, and no spring for it; set stiffness = \"800 N/m\" and "
      "rotational_stiffness = \"2 N·m/rad\" in [coupling]");
}

/// The session as one hand has it, by number.
SessionConfig read_config(std::string_view toml_text, const std::string& origin, uint32_t hand) {
  TomlDocument document(toml_text, origin);
  document.prefer("hand", hand, kTablesOfHand);
  const fs::path file = fs::absolute(origin).lexically_normal();
  const fs::path folder = file.parent_path();
  SessionConfig config;
  assign(config.file, file.string());

  Section root = document.root();
  read_session(root, config);
  read_hand(root, hand, config);
  read_rates(root, config);
  read_map(root, config.map);
  read_device(root, folder, config.device);
  read_coupling(root, config.coupling);
  read_safety(root, config.device.kind, config.safety);
  read_tool(root, folder, config.tool);
  read_proxy(root, config.proxy);
  for (Section& object : root.sections("object")) read_object(object, config, folder);
  read_joints(root, config);
  read_clients(root, config);
  read_sim(root, config);
  root.finish();
  check_body(root, config);
  check_rigid(root, config);
  return config;
}

std::vector<SessionConfig> read_hands(std::string_view toml_text, const std::string& origin) {
  if (toml_text.size() > kMostConfigText) {
    throw ConfigError(origin + ": has more than " + std::to_string(kMostConfigText >> 10) +
                      " KiB; make it shorter");
  }
  std::vector<SessionConfig> hands{read_config(toml_text, origin, kFirstHand)};
  for (uint32_t hand = 1; hand < hands[0].n_hands; ++hand) {
    hands.push_back(read_config(toml_text, origin, hand));
  }
  std::string problem = shared_device(hands);
  if (problem.empty()) problem = too_many_tools(hands[0]);
  if (!problem.empty()) throw ConfigError(origin + ": " + problem);
  return hands;
}

}  // namespace

std::vector<SessionConfig> parse_hands(std::string_view toml_text, const std::string& origin) {
  try {
    return read_hands(toml_text, origin);
  } catch (const ConfigError& error) {
    // the message may quote the file
    throw ConfigError(one_line(error.what()));
  }
}

SessionConfig parse_config(std::string_view toml_text, const std::string& origin) {
  return parse_hands(toml_text, origin).front();
}

std::string read_config_text(const std::string& path) {
  std::string text;
  const std::string problem = read_regular_file(path, kMostConfigText, text);
  if (!problem.empty()) {
    const std::filesystem::path ours = shared_folder("configs");
    throw ConfigError(path + ": " + problem + "; name a session file (.toml), examples are in " +
                      (ours.empty() ? "configs/" : ours.string() + "/"));
  }
  return text;
}

std::vector<SessionConfig> load_hands(const std::string& path) {
  return parse_hands(read_config_text(path), path);
}

SessionConfig load_config(const std::string& path) {
  return load_hands(path).front();
}

}  // namespace haptic
