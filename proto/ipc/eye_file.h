// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "proto/os/message.h"
#include "proto/wire/hands.h"

/// The eye file: how one object, or the tool, is drawn. Little endian, in this order:
///
///   bytes  0  magic "HAPTEYE1"
///          8  u32 number of vertices, of triangles, of points; u32 object (eye_of_tool: a tool)
///         24  f32 colour: red, green, blue, alpha
///         40  name: 40 bytes of UTF-8, padded with NUL
///         80  f32 vertices [3n], f32 normals [3n], u32 triangles [3n], f32 points [3n]
namespace haptic {

inline constexpr uint32_t kEyeOfTool = 0xffff'ffff;  // of the first hand
/// The object number of a hand's tool.
constexpr uint32_t eye_of_tool(uint32_t hand) {
  return kEyeOfTool - hand;
}
constexpr bool is_eye_of_tool(uint32_t object) {
  return object > kEyeOfTool - kMostHands;
}
inline constexpr size_t kEyeNameBytes = 40;    // as a Name of a config has
inline constexpr size_t kEyeHeaderBytes = 80;  // bytes before the arrays
// [bytes]: far above what contact makes, far below what would hurt a reader
inline constexpr size_t kMostEyeBytes = size_t{64} << 20;

/// Bytes that are no eye file, in one line.
struct EyeError : MessageError {
  using MessageError::MessageError;
};

using EyePoint = std::array<float, 3>;        // [m], in O or T
using EyeTriangle = std::array<uint32_t, 3>;  // vertices, counter-clockwise seen from outside

/// Red, green, blue and alpha, 0 to 1.
struct EyeColour {
  float r = 0, g = 0, b = 0, a = 1;
  bool operator==(const EyeColour&) const = default;
};

/// The content of an eye file. The arrays are views.
struct EyeFile {
  uint32_t object = kEyeOfTool;        // index in the session file
  std::string name;                    // printable
  EyeColour colour;                    // of the material
  std::span<const EyePoint> vertices;  // [m], in O, of the tool in T
  std::span<const EyePoint> normals;   // one for each vertex
  std::span<const EyeTriangle> triangles;
  std::span<const EyePoint> points;  // of the voxel shell; empty where there is none
};

/// The bytes of an eye file. A name of more than 40 bytes is cut between two characters. Throws
/// EyeError if the result would not be read: the preconditions are those of view_eye.
std::vector<std::byte> write_eye(const EyeFile& file);

/// Views the bytes in place. Checks that they are as many as the header says, at most
/// kMostEyeBytes, that all numbers are finite, colours between 0 and 1, and that each index names
/// a vertex. `bytes` must be 4-byte aligned. Throws EyeError.
EyeFile view_eye(std::span<const std::byte> bytes);

}  // namespace haptic
