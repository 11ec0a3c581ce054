// SPDX-License-Identifier: Apache-2.0
#include "proto/config/read/config_material.h"

#include "proto/config/read/height_image.h"

namespace haptic {
namespace {

constexpr double kRightAngle = 1.5707963267948966;  // [rad]
constexpr Range kShares{0, 1};
constexpr Range kCreases{0, kRightAngle};
constexpr Words<TextureKind, 3> kTextures{{{"none", TextureKind::kNone},
                                           {"grating", TextureKind::kGrating},
                                           {"image", TextureKind::kImage}}};

uint32_t add_image(const Section& texture, SessionConfig& config,
                   const std::filesystem::path& file) {
  if (config.n_images == kMaxImages) {
    texture.fail_at("path", "is one image too many; a session holds " + std::to_string(kMaxImages));
  }
  try {
    config.images[config.n_images] = read_height_image(file.string());
  } catch (const std::runtime_error& error) {
    texture.fail_at("path", error.what());
  }
  return config.n_images++;
}

void read_texture(Section& section, SessionConfig& config,
                  const std::filesystem::path& config_folder, TextureConfig& texture) {
  section.require("kind", "kind = \"grating\"");
  section.read_choice("kind", words(kTextures), texture.kind);
  if (texture.kind == TextureKind::kGrating) {
    section.require("wavelength", "wavelength = \"2 mm\"");
    section.read_quantity("wavelength", Dimension::kLength, kPositive, texture.period);
    section.read_direction("direction", texture.direction_O);
  }
  if (texture.kind == TextureKind::kImage) {
    section.require("path", "path = \"grain.pgm\"");
    section.require("tile", "tile = \"10 mm\", the width of the image on the object");
    section.read_quantity("tile", Dimension::kLength, kPositive, texture.period);
    std::string path;
    section.read_text("path", path);
    texture.image = add_image(section, config, config_folder / path);
  }
  if (texture.kind != TextureKind::kNone) {
    section.require("amplitude", "amplitude = \"0.1 mm\"");
    section.read_quantity("amplitude", Dimension::kLength, kNotNegative, texture.amplitude);
  }
  section.finish();
}

}  // namespace

void read_material(Section& object, SessionConfig& config,
                   const std::filesystem::path& config_folder, MaterialConfig& material) {
  auto section = object.section("material");
  if (!section) return;
  section->read_number("friction_static", kNotNegative, material.friction_static);
  section->read_number("friction_dynamic", kNotNegative, material.friction_dynamic);
  if (material.friction_dynamic > material.friction_static) {
    section->fail_at("friction_dynamic",
                     "is larger than friction_static; what slides cannot hold better than what "
                     "sticks");
  }
  section->read_quantity("friction_viscous", Dimension::kDamping, kNotNegative,
                         material.friction_viscous);
  section->read_number("stiffness_share", kShares, material.stiffness_share);
  section->read_quantity("crease_angle", Dimension::kAngle, kCreases, material.crease_angle);
  if (auto texture = section->section("texture")) {
    read_texture(*texture, config, config_folder, material.texture);
  }
  section->finish();
}

}  // namespace haptic
