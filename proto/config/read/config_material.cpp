// SPDX-License-Identifier: Apache-2.0
#include "proto/config/read/config_material.h"

#include "proto/config/read/height_image.h"

namespace haptic {

using enum Dimension;

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
  section.read_all({{"kind", kTextures, texture.kind, "kind = \"grating\""}});
  if (texture.kind == TextureKind::kNone) return;
  if (texture.kind == TextureKind::kGrating) {
    section.read_all({{"wavelength", kLength, kPositive, texture.period, "wavelength = \"2 mm\""}});
    section.read_direction("direction", texture.direction_O);
  } else {
    section.require("path", "path = \"grain.pgm\"");
    section.read_all({{"tile", kLength, kPositive, texture.period,
                       "tile = \"10 mm\", the width of the image on the object"}});
    std::string path;
    section.read_text("path", path);
    texture.image = add_image(section, config, config_folder / path);
  }
  section.read_all(
      {{"amplitude", kLength, kNotNegative, texture.amplitude, "amplitude = \"0.1 mm\""}});
}

}  // namespace

void read_material(Section& object, SessionConfig& config,
                   const std::filesystem::path& config_folder, MaterialConfig& material) {
  object.within("material", [&](Section& section) {
    section.read_all({{"friction_static", kNotNegative, material.friction_static},
                      {"friction_dynamic", kNotNegative, material.friction_dynamic}});
    if (material.friction_dynamic > material.friction_static) {
      section.fail_at("friction_dynamic",
                      "is larger than friction_static; what slides cannot hold better than what "
                      "sticks");
    }
    section.read_all({{"friction_viscous", kDamping, kNotNegative, material.friction_viscous},
                      {"stiffness_share", kShares, material.stiffness_share},
                      {"crease_angle", kAngle, kCreases, material.crease_angle}});
    section.within("texture", [&](Section& texture) {
      read_texture(texture, config, config_folder, material.texture);
    });
  });
}

}  // namespace haptic
