// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <iosfwd>
#include <string>
#include <vector>

/// The scenes of `hapt demo`.
namespace haptic {

std::vector<std::string> scene_names();

/// Title of a scene for people, as "the Stanford bunny".
std::string scene_title(const std::string& name);

/// A line for each scene, and one for a mesh of one's own.
void list_scenes(std::ostream& out);

/// The scene that is played when none is named: the bunny; an installed program that has not
/// fetched its mesh plays one that needs none, and says so.
std::string default_scene();

/// The session file of a scene. Fetches the meshes first that an installed program lacks; throws
/// std::runtime_error if it cannot.
std::string prepare_scene(const std::string& name);

inline constexpr const char* kPython = "/usr/bin/python3";  // that Debian's modules are for

/// The Python script that gives to a scene; empty: none does. Throws std::runtime_error with a
/// remedy where its Python package is not there.
std::string scene_script(const std::string& name);

}  // namespace haptic
