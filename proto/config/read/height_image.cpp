// SPDX-License-Identifier: Apache-2.0
#include "proto/config/read/height_image.h"

#include <sstream>
#include <stdexcept>

#include "proto/os/regular_file.h"

namespace haptic {
namespace {

constexpr uint32_t kMostGrey = 255;  // of 8 bits
// [bytes]: 64 × 64 numbers take 20 kB as text, the rest allows for comments
constexpr size_t kMostText = size_t{1} << 20;

/// The next number of the header or a text image; comments run from '#' to the end of the line.
uint32_t read_image_number(std::istream& in) {
  while (in >> std::ws && in.peek() == '#') {
    std::string comment;
    std::getline(in, comment);
  }
  uint32_t number = 0;
  in >> number;
  return number;
}

}  // namespace

HeightImage read_height_image(const std::string& path) {
  std::string text;
  const std::string problem = read_regular_file(path, kMostText, text);
  if (!problem.empty()) throw std::runtime_error(path + " " + problem + "; name a PGM image");
  std::istringstream in(text);
  const auto refuse = [&](const std::string& why) {
    throw std::runtime_error(path + " " + why + "; make it a grey PGM of at most 64 × 64 pixels");
  };
  std::string magic;
  in >> magic;
  if (magic != "P2" && magic != "P5") refuse("is no PGM");
  HeightImage image;
  image.width = read_image_number(in);
  image.height = read_image_number(in);
  const uint32_t white = read_image_number(in);
  const auto fits = [](uint32_t side) { return side > 0 && side <= HeightImage::kMaxSide; };
  if (!in || !fits(image.width) || !fits(image.height)) refuse("has the wrong size");
  if (white == 0 || white > kMostGrey) refuse("does not have 8 bits");
  in.get();  // the single space before binary pixels

  for (size_t i = 0; i < size_t{image.width} * image.height; ++i) {
    const uint32_t grey = magic == "P5" ? static_cast<uint32_t>(in.get()) : read_image_number(in);
    if (!in || grey > white) refuse("ends early, or has pixels whiter than white");
    image.grey[i] = static_cast<uint8_t>(grey * kMostGrey / white);
  }
  return image;
}

}  // namespace haptic
