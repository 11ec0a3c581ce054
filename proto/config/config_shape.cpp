// SPDX-License-Identifier: Apache-2.0
#include "proto/config/config_shape.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <string>
#include <vector>

#include "proto/math/units.h"
#include "proto/os/environment.h"
#include "proto/os/source_tree.h"

namespace haptic {

namespace fs = std::filesystem;

#define PRIMITIVE(name, read, generate) ReadPrimitive read;
#include "proto/config/primitives.def"

namespace {

constexpr Words<double, 5> kMeshUnits{
    {{"m", 1}, {"mm", 1e-3}, {"cm", 1e-2}, {"in", 0.0254}, {"any", 0}}};

using PrimitiveWord = std::pair<std::string_view, ReadPrimitive*>;
constexpr std::array kPrimitives{
#define PRIMITIVE(name, read, generate) PrimitiveWord{name, &read},
#include "proto/config/primitives.def"
};

constexpr int64_t kMaxSubdivisions = 8;            // 1.3 million triangles
constexpr int64_t kMaxSteps = 1000;                // two million triangles
constexpr int64_t kMinTeeth = 6, kMaxTeeth = 200;  // of a gear
constexpr int64_t kMaxSideSteps = 250;             // 1.25 million triangles
// a socket's cavity: from a dish to one that holds the ball
constexpr Range kCovers{10 * kDegree, 150 * kDegree};

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

/// A required dimension of a part.
double read_dimension(Section& section, std::string_view key, const char* example) {
  double length = 0;
  section.require(key, std::string(key) + " = \"" + example + "\"");
  section.read_quantity(key, Dimension::kLength, kPositive, length);
  return length;
}

void read_steps(Section& section, int64_t around, int64_t along, PartConfig& part) {
  section.read_integer("around", 3, kMaxSteps, around);
  section.read_integer("along", 1, kMaxSteps, along);
  part.around = static_cast<uint32_t>(around);
  part.along = static_cast<uint32_t>(along);
}

/// Steps around a part whose end is a disc of six sectors.
void read_sixfold(Section& section, int64_t around, PartConfig& part) {
  section.read_integer("around", 6, kMaxSteps, around);
  if (around % 6 != 0) section.fail_at("around", "is no multiple of 6, as this part needs it");
  part.around = static_cast<uint32_t>(around);
}

/// What a long part and the rest for it have in common.
void read_frame(Section& section, PartConfig& part) {
  part.length = read_dimension(section, "length", "180 mm");
  part.width = read_dimension(section, "width", "24 mm");
  part.diameter = read_dimension(section, "diameter", "8 mm");
  int64_t around = 48;
  section.read_integer("around", 8, kMaxSteps, around);
  if (around % 4 != 0) section.fail_at("around", "is no multiple of 4, as a hole needs it");
  part.around = static_cast<uint32_t>(around);
  if (part.length < 4 * part.width) {
    section.fail_at("length", "is too short for its lugs; four widths are the least");
  }
}

void read_thread(Section& section, PartConfig& part) {
  part.diameter = read_dimension(section, "diameter", "20 mm");
  part.pitch = read_dimension(section, "pitch", "2.5 mm");
  part.depth = read_dimension(section, "depth", "1.4 mm");
  if (part.depth >= 0.5 * part.diameter) {
    section.fail_at("depth", "reaches the axis; half the diameter is too much");
  }
}

void read_primitive(Section& section, ShapeConfig& shape) {
  ReadPrimitive* read = nullptr;
  std::string name;
  section.read_choice("primitive", words(kPrimitives), read);
  section.read_text("primitive", name);
  assign(shape.mesh, "primitive:" + name);
  shape.unit = 1;
  read(section, shape);
  if (!is_finite(shape.extent)) {
    section.fail_at("primitive", "has dimensions too large to add up; make them smaller");
  }
  shape.size = std::max({shape.extent.x, shape.extent.y, shape.extent.z});
}

}  // namespace

void read_box(Section& section, ShapeConfig& shape) {
  section.require("extent", "extent = [\"100 mm\", \"100 mm\", \"20 mm\"]");
  section.read_lengths("extent", kPositive, shape.extent);
}

void read_sphere(Section& section, ShapeConfig& shape) {
  section.require("size", "size = \"100 mm\", the diameter");
  section.read_quantity("size", Dimension::kLength, kMeshSizes, shape.size);
  int64_t subdivisions = 4;
  section.read_integer("subdivisions", 0, kMaxSubdivisions, subdivisions);
  shape.subdivisions = static_cast<uint32_t>(subdivisions);
  shape.extent = {shape.size, shape.size, shape.size};
}

void read_peg(Section& section, ShapeConfig& shape) {
  PartConfig& part = shape.part;
  part.diameter = read_dimension(section, "diameter", "20 mm");
  part.length = read_dimension(section, "length", "40 mm");
  read_steps(section, 96, 16, part);
  shape.extent = {part.diameter, part.diameter, part.length};
}

void read_hole(Section& section, ShapeConfig& shape) {
  PartConfig& part = shape.part;
  part.diameter = read_dimension(section, "diameter", "20 mm");
  part.length = read_dimension(section, "length", "40 mm");
  part.clearance = read_dimension(section, "clearance", "0.2 mm");
  part.block = read_dimension(section, "block", "60 mm");
  read_steps(section, 96, 16, part);
  if (part.diameter + 2 * part.clearance >= part.block) {
    section.fail_at("block", "is no wider than the hole; diameter + 2 clearance must fit into it");
  }
  shape.extent = {part.block, part.block, part.length};
}

void read_gear(Section& section, ShapeConfig& shape) {
  PartConfig& part = shape.part;
  int64_t teeth = 0;
  section.require("teeth", "teeth = 20");
  section.read_integer("teeth", kMinTeeth, kMaxTeeth, teeth);
  part.teeth = static_cast<uint32_t>(teeth);
  part.module = read_dimension(section, "module", "3 mm");
  part.width = read_dimension(section, "width", "10 mm");
  part.bore = read_dimension(section, "bore", "10 mm");
  part.backlash = 0.1e-3;
  section.read_quantity("backlash", Dimension::kLength, kNotNegative, part.backlash);
  read_steps(section, 24 * teeth > kMaxSteps ? kMaxSteps : 24 * teeth, 8, part);
  const double foot = part.module * (part.teeth - 2.5), tip = part.module * (part.teeth + 2.0);
  if (part.bore >= foot) {
    section.fail_at("bore",
                    "reaches the foot of the teeth, at module · (teeth - 2.5); make it "
                    "smaller");
  }
  if (part.backlash >= part.module) {
    section.fail_at("backlash",
                    "is as large as the module and leaves no teeth; write a part of a "
                    "millimetre");
  }
  shape.extent = {tip, tip, part.width};
}

void read_bolt(Section& section, ShapeConfig& shape) {
  PartConfig& part = shape.part;
  read_thread(section, part);
  part.length = read_dimension(section, "length", "40 mm");
  read_steps(section, 96, 256, part);
  shape.extent = {part.diameter, part.diameter, part.length};
}

void read_nut(Section& section, ShapeConfig& shape) {
  PartConfig& part = shape.part;
  read_thread(section, part);
  part.clearance = read_dimension(section, "clearance", "0.05 mm");
  part.height = read_dimension(section, "height", "16 mm");
  part.width = read_dimension(section, "width", "32 mm");
  read_steps(section, 96, 128, part);
  if (part.diameter + 2 * part.clearance >= part.width) {
    section.fail_at("width",
                    "is no wider than the thread; diameter + 2 clearance must fit into "
                    "it");
  }
  const double across_corners = part.width * 2 / std::sqrt(3.0);
  shape.extent = {across_corners, across_corners, part.height};
}

void read_lower_molar(Section& section, ShapeConfig& shape) {
  PartConfig& part = shape.part;
  part.width = read_dimension(section, "width", "11 mm");
  read_sixfold(section, 264, part);
  shape.extent = part.width / 11 * Vec3{10.2, 11, 8.3};
}

void read_upper_molar(Section& section, ShapeConfig& shape) {
  PartConfig& part = shape.part;
  part.width = read_dimension(section, "width", "11 mm");
  part.clearance = read_dimension(section, "clearance", "0.05 mm");
  read_sixfold(section, 264, part);
  shape.extent = part.width / 11 * Vec3{11.4, 10.4, 8.3};
}

void read_joint_ball(Section& section, ShapeConfig& shape) {
  PartConfig& part = shape.part;
  part.diameter = read_dimension(section, "diameter", "40 mm");
  part.stem = read_dimension(section, "stem", "16 mm");
  part.length = read_dimension(section, "length", "50 mm");
  read_sixfold(section, 240, part);
  if (part.stem >= part.diameter) {
    section.fail_at("stem", "is no thinner than the ball; write less than its diameter");
  }
  if (2 * part.length <= part.diameter) {
    section.fail_at("length", "ends within the ball; write more than half its diameter");
  }
  shape.extent = {part.diameter, part.diameter, 0.5 * part.diameter + part.length};
}

void read_joint_socket(Section& section, ShapeConfig& shape) {
  PartConfig& part = shape.part;
  part.diameter = read_dimension(section, "diameter", "40 mm");
  part.clearance = read_dimension(section, "clearance", "0.1 mm");
  part.width = read_dimension(section, "width", "60 mm");
  part.height = read_dimension(section, "height", "30 mm");
  part.cover = 80 * kDegree;
  section.read_quantity("cover", Dimension::kAngle, kCovers, part.cover);
  read_sixfold(section, 240, part);
  const double cavity = 0.5 * part.diameter + part.clearance;
  if (2 * cavity >= part.width) {
    section.fail_at("width",
                    "is no wider than the cavity; diameter + 2 clearance must fit into it");
  }
  if (cavity >= part.height) {
    section.fail_at("height",
                    "ends above the cavity; half the diameter and the clearance must fit into it");
  }
  shape.extent = {part.width, part.width, part.height - cavity * std::cos(part.cover)};
}

void read_dimpled_ball(Section& section, ShapeConfig& shape) {
  PartConfig& part = shape.part;
  part.diameter = read_dimension(section, "diameter", "42.7 mm");
  part.depth = read_dimension(section, "depth", "0.25 mm");
  int64_t along = 82;
  section.read_integer("along", 1, kMaxSideSteps, along);
  part.along = static_cast<uint32_t>(along);
  if (10 * part.depth > part.diameter) {
    section.fail_at("depth", "is more than a tenth of the diameter; write less");
  }
  shape.extent = {part.diameter, part.diameter, part.diameter};
}

void read_frame_rail(Section& section, ShapeConfig& shape) {
  PartConfig& part = shape.part;
  read_frame(section, part);
  part.height = read_dimension(section, "height", "16 mm");
  part.clearance = read_dimension(section, "clearance", "0.1 mm");
  if (part.diameter + 2 * part.clearance > 0.5 * part.width) {
    section.fail_at("diameter",
                    "leaves too little of the lugs; diameter + 2 clearance may be half "
                    "the width");
  }
  if (part.height < 0.5 * part.width) {
    section.fail_at("height", "is lower than half the width, and the channel has no room below");
  }
  const double tab = 2 * part.width / 3;
  shape.extent = {part.length, part.width + tab, part.height + tab};
}

void read_pin_rest(Section& section, ShapeConfig& shape) {
  PartConfig& part = shape.part;
  read_frame(section, part);
  part.height = read_dimension(section, "height", "20 mm");
  if (part.diameter > 0.5 * part.width) {
    section.fail_at("diameter", "is too thick for its post; half the width is the most");
  }
  // the base is a quarter of the width thick, the pins stand 3/16 of it and half a diameter high
  shape.extent = {part.length + part.width, 0.75 * 2 * part.width,
                  part.height + 0.25 * part.width + 0.1875 * part.width + 0.5 * part.diameter};
}

void read_window(Section& section, ShapeConfig& shape) {
  PartConfig& part = shape.part;
  read_box(section, shape);
  part.width = read_dimension(section, "width", "60 mm");
  part.height = read_dimension(section, "height", "40 mm");
  if (part.width >= shape.extent.x)
    section.fail_at("width", "is no less than that of the plate; make the extent larger");
  if (part.height >= shape.extent.y) {
    section.fail_at("height", "is no less than that of the plate; make the extent larger");
  }
}

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
