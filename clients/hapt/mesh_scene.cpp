// SPDX-License-Identifier: GPL-3.0-or-later
#include "clients/hapt/mesh_scene.h"

#include <filesystem>

#include "clients/hapt/mesh_strokes.h"
#include "contact/bake/bake.h"
#include "proto/config/quantity.h"
#include "proto/config/read/config_shape.h"
#include "proto/os/text.h"

namespace haptic {
namespace {

/// A string of TOML.
std::string quoted(const std::string& text) {
  std::string out = "\"";
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    if (c == '"' || c == '\\') out += '\\';
    out += byte < 0x20 || c == 0x7f ? formatted("\\u%04x", unsigned{byte}) : std::string(1, c);
  }
  return out + '"';
}

std::string millimetres(double metres) {
  return formatted("\"%g mm\"", 1e3 * metres);
}

/// As a session file wants it, where a number alone has no unit.
std::string unit_text(const OwnMesh& own) {
  if (own.size > 0) return "any";
  if (own.unit.empty()) return "m";
  const bool is_number = own.unit.find_first_not_of("0123456789.eE+- ") == std::string::npos;
  return is_number ? own.unit + " m" : own.unit;
}

}  // namespace

std::string problem_of_unit(const std::string& text) {
  try {
    parse_mesh_unit(text, "m");
    return "";
  } catch (const QuantityError& error) {
    return error.what();
  }
}

std::string name_of(const OwnMesh& own) {
  std::string name = std::filesystem::path(own.file).stem().string().substr(0, 32);
  for (char& c : name) {
    if (!session_name_problem(std::string(1, c)).empty()) c = '-';
  }
  return name.empty() ? "mesh" : name;
}

std::string object_text(const OwnMesh& own, const Vec3& middle_O) {
  const Vec3 p = -middle_O;
  std::string text = "[[object]]\nname = " + quoted(name_of(own)) +
                     "\nmesh = " + quoted(std::filesystem::absolute(own.file).string()) +
                     "\nunit = " + quoted(unit_text(own)) + "\n";
  if (own.size > 0) text += "size = " + millimetres(own.size) + "\n";
  if (own.allow_open) text += "open = true\n";
  return text + "position = [" + millimetres(p.x) + ", " + millimetres(p.y) + ", " +
         millimetres(p.z) + "]\n";
}

std::string session_text(const OwnMesh& own) {
  ShapeConfig shape{};
  assign(shape.mesh, std::filesystem::absolute(own.file).string());
  const std::string unit = unit_text(own);
  shape.unit = parse_mesh_unit(unit);
  shape.size = own.size;
  shape.allow_open = own.allow_open ? 1 : 0;
  const BakedShape baked = bake_object(shape, SessionConfig{}.mesh_memory_limit);
  const MeshStrokes strokes = choose_strokes(baked.shape);
  const Vec3& n = strokes.direction_O;
  const std::string intent =
      "hover_radius = " + millimetres(strokes.hover) +
      "\npress_radius = " + millimetres(strokes.press) +
      formatted("\nstroke_angle = \"%g rad\"\nstroke_time = \"%g s\"\n", strokes.angle,
                strokes.time()) +
      (n == Vec3{} ? "" : formatted("direction = [%f, %f, %f]\n", n.x, n.y, n.z));
  return "[session]\nname = " + quoted(name_of(own)) +
         "\n\n[device]\nkind = \"simulated-hand\"\n\n[device.hand.intent]\n" + intent + "\n" +
         object_text(own, strokes.centre_O);
}

}  // namespace haptic
