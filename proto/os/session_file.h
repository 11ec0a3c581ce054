// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <string>

namespace haptic {

/// A scene of `hapt demo`: a session file with a short name.
struct Scene {
  const char *name, *file, *title;
  bool has_bunny = false;        // whose mesh is fetched, not shipped
  const char* script = nullptr;  // of Python, among its examples, that gives to the session
};

inline constexpr std::array kScenes{
    Scene{"admittance", "admittance.toml", "an arm that follows the hand, on a block"},
    Scene{"ball-joint", "ball-joint.toml", "a ball in its socket"},
    Scene{"bunnies", "bunny-on-bunny.toml", "a bunny on a bunny", true},
    Scene{"bunny", "bunny.toml", "the Stanford bunny", true},
    Scene{"carry", "carry.toml", "blocks that are grasped and stacked"},
    Scene{"dimpled-ball", "dimpled-ball.toml", "a ball with dimples"},
    Scene{"door", "door.toml", "a door with a latch and a check"},
    Scene{"field", "field.toml", "a charge that pulls, computed by a Python script", false,
          "05_field.py"},
    Scene{"frame", "frame.toml", "a long part through an opening, onto its pins"},
    Scene{"gear-pair", "gear-pair.toml", "a gear that turns another"},
    Scene{"gears", "gears.toml", "two gears"},
    Scene{"gearshift", "gearshift.toml", "a gear lever in its gate"},
    Scene{"heap", "heap.toml", "boxes and tins to push over"},
    Scene{"peg", "peg-in-hole.toml", "a peg in a hole"},
    Scene{"rigid-bunnies", "rigid-bunnies.toml", "a rigid bunny on a bunny", true},
    Scene{"rigid-peg", "rigid-peg.toml", "a rigid peg in a tight hole"},
    Scene{"robot", "robot.toml", "an arm that a Python script computes", false, "04_your_robot.py"},
    Scene{"teeth", "teeth.toml", "two molars that bite"}};

/// Finds a session file by path, or by name in $HAPTICD_CONFIGS or among those that belong to this
/// checkout or installation: that of the file, with or without .toml, or of a scene. Throws
/// InputError with the places searched and a name that is like it.
std::string find_session_file(const std::string& name);

}  // namespace haptic
