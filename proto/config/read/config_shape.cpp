// SPDX-License-Identifier: Apache-2.0
#include "proto/config/read/config_shape.h"

#include <algorithm>
#include <charconv>
#include <string>
#include <vector>

#include "proto/os/environment.h"
#include "proto/os/source_tree.h"

namespace haptic {

namespace fs = std::filesystem;

#define PRIMITIVE(Kind, name, make) void read_keys(Section& section, primitive::Kind& kind);
#include "proto/config/primitives.def"

namespace {

constexpr Words<double, 5> kMeshUnits{
    {{"m", 1}, {"mm", 1e-3}, {"cm", 1e-2}, {"in", 0.0254}, {"any", 0}}};

/// Absolute path of a mesh; "package:" skips the folder of the config file.
std::string find_mesh(const Section& section, std::string name, const fs::path& config_folder) {
  constexpr std::string_view kPackage = "package:";
  std::vector<fs::path> folders = mesh_folders();
  if (name.starts_with(kPackage)) {
    name.erase(0, kPackage.size());
  } else {
    folders.insert(folders.begin(), config_folder);
  }
  std::string places;
  for (const fs::path& folder : folders) {
    const fs::path candidate = folder / name;
    std::error_code error;
    if (fs::is_regular_file(candidate, error)) return fs::absolute(candidate).lexically_normal();
    places += (places.empty() ? "" : ", ") + candidate.lexically_normal().string();
  }
  const std::string fetch = source_tree().empty() ? "hapt demo bunny" : "./run meshes";
  section.fail_at("mesh", "was not found; looked for " + places +
                              "; fetch the example meshes with `" + fetch +
                              "`, or set HAPTICD_MESHES to the folder of yours");
}

void read_mesh(Section& section, const fs::path& config_folder, ShapeConfig& shape) {
  std::string mesh;
  section.read_text("mesh", mesh);
  const std::string path = find_mesh(section, mesh, config_folder);
  if (path.size() >= shape.mesh.size()) section.fail_at("mesh", "has too long a path: " + path);
  assign(shape.mesh, path);
  section.require("unit", "unit = \"mm\", or \"any\" to scale the mesh to 'size'");
  std::string unit;
  section.read_text("unit", unit);
  try {
    shape.unit = parse_mesh_unit(unit);
  } catch (const QuantityError& error) {
    section.fail_at("unit", error.what());
  }
  if (shape.unit == 0) {
    section.require("size", "size = \"100 mm\", the longest side, to which unit = \"any\" scales");
  }
  section.read_quantity("size", Dimension::kLength, kMeshSizes, shape.size);
  section.read_flag("open", shape.allow_open);
}

void read_primitive(Section& section, ShapeConfig& shape) {
  section.read_choice("primitive", kPrimitives, shape.primitive);
  shape.unit = 1;
  std::visit(
      [&](auto& kind) {
        if constexpr (!std::is_same_v<decltype(kind), std::monostate&>) read_keys(section, kind);
      },
      shape.primitive);
}

}  // namespace

uint32_t default_colour(uint32_t index) {
  // eight hues of similar lightness, so that none hides the arrows and points drawn upon it
  constexpr std::array<uint32_t, 8> kColours{0x7fa8d1, 0xd9a066, 0x8fbf8f, 0xc98fb5,
                                             0xc9c27a, 0x86c5c5, 0xd98f86, 0xa79bd1};
  return kColours[index % kColours.size()];
}

void read_colour(Section& section, ShapeConfig& shape) {
  std::string text;
  if (!section.read_text("colour", text)) return;
  const bool has_form = text.size() == 7 && text.front() == '#';
  const std::string_view digits = std::string_view(text).substr(has_form ? 1 : 0);
  uint32_t colour = 0;
  const char* end = std::from_chars(digits.begin(), digits.end(), colour, 16).ptr;
  if (!has_form || end != digits.end()) {
    section.fail_at("colour", "is '" + shown(text) +
                                  "'; write six hexadecimal digits, red, green and blue: "
                                  "\"#7fa8d1\"");
  }
  shape.colour = colour;
}

double parse_mesh_unit(std::string_view text, std::string_view bare_unit) {
  std::string known;
  for (const auto& [word, metres] : kMeshUnits) {
    if (text == word) return metres;
    known += std::string(word) + ", ";
  }
  constexpr Range kMetresPerUnit{1e-12, kMostLength};
  const std::string_view number = text.substr(std::min(text.find_first_not_of(" +"), text.size()));
  double ignored = 0;
  const bool begins_with_number =
      std::from_chars(number.data(), number.data() + number.size(), ignored).ec !=
      std::errc::invalid_argument;
  if (begins_with_number) {
    return parse_quantity(text, Dimension::kLength, kMetresPerUnit, bare_unit);
  }
  throw QuantityError("is '" + shown(text) + "'; known here: " + known +
                      "or a length as \"25.4 mm\"");
}

std::vector<fs::path> mesh_folders() {
  std::vector<fs::path> folders{environment("HAPTICD_MESHES"), shared_folder("meshes")};
  if (source_tree().empty()) folders.push_back(fetched_meshes());
  std::erase(folders, fs::path());
  return folders;
}

void read_shape(Section& section, const fs::path& config_folder, ShapeConfig& shape) {
  if (section.has("mesh") == section.has("primitive")) {
    section.fail_missing("mesh", "mesh = \"bunny00.off\", or primitive = \"box\" (one of the two)");
  }
  if (section.has("mesh")) {
    read_mesh(section, config_folder, shape);
  } else {
    read_primitive(section, shape);
  }
}

}  // namespace haptic
