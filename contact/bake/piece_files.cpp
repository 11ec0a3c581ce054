// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/bake/piece_files.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>

#include "proto/math/assert.h"

namespace haptic {
namespace {

static_assert(std::endian::native == std::endian::little);

using Colour = std::array<uint8_t, 3>;

/// Colours that follow one another differ much: their hues go round by the golden section.
Colour piece_colour(size_t index) {
  constexpr double kGolden = 0.6180339887498949, kLeast = 90, kSpread = 150;  // of 255
  const double hue = 6 * std::fmod(kGolden * static_cast<double>(index), 1.0);
  const auto share = [hue](double middle) {
    const double off = std::fabs(std::fmod(hue - middle + 9, 6.0) - 3);
    return static_cast<uint8_t>(kLeast + kSpread * std::clamp(2 - off, 0.0, 1.0));
  };
  return {share(0), share(2), share(4)};
}

template <class T>
void append(std::string& out, T value) {
  std::array<char, sizeof value> bytes;
  std::memcpy(bytes.data(), &value, sizeof value);
  out.append(bytes.data(), bytes.size());
}

void append(std::string& out, const Colour& colour) {
  for (const uint8_t share : colour) append(out, share);
}

std::string header_of(size_t n_vertices, size_t n_faces) {
  const std::string colours = "property uchar red\nproperty uchar green\nproperty uchar blue\n";
  return "ply\nformat binary_little_endian 1.0\n"
         "comment convex pieces of a surface, one colour each; in metres\nelement vertex " +
         std::to_string(n_vertices) + "\nproperty float x\nproperty float y\nproperty float z\n" +
         colours + "element face " + std::to_string(n_faces) +
         "\nproperty list int int vertex_indices\n" + colours +
         "property int piece\nproperty uchar virtual\nend_header\n";
}

void append_vertices(std::string& out, const Hull& hull, const Colour& colour) {
  for (const Vec3& v : hull.vertices) {
    append(out, static_cast<float>(v.x));
    append(out, static_cast<float>(v.y));
    append(out, static_cast<float>(v.z));
    append(out, colour);
  }
}

void append_faces(std::string& out, const Hull& hull, uint32_t first_vertex, uint32_t piece,
                  const Colour& colour) {
  for (const HullFace& face : hull.faces) {
    append(out, static_cast<int32_t>(face.n_edges));
    for (const HullEdge& edge : hull.edges.subspan(face.first_edge, face.n_edges)) {
      append(out, static_cast<int32_t>(first_vertex + edge.from));
    }
    append(out, colour);
    append(out, static_cast<int32_t>(piece));
    append(out, static_cast<uint8_t>(face.is_virtual));
  }
}

}  // namespace

std::vector<uint32_t> pieces_at(const PieceTree& tree, uint32_t level) {
  std::vector<uint32_t> pieces;
  for (uint32_t i = 0; i < tree.pieces.size(); ++i) {
    const Piece& piece = tree.pieces[i];
    const bool above_is_coarser =
        piece.parent == kNoPiece || tree.pieces[piece.parent].level > level;
    if (piece.level <= level && above_is_coarser) pieces.push_back(i);
  }
  return pieces;
}

std::vector<PieceLevel> levels_of(const PieceTree& tree) {
  std::vector<PieceLevel> levels(tree.level_pieces.size());
  for (uint32_t i = 0; i < levels.size(); ++i) {
    PieceLevel& level = levels[i];
    level.least_resolution = std::numeric_limits<double>::infinity();
    for (const uint32_t k : pieces_at(tree, i)) {
      const Piece& piece = tree.pieces[k];
      ++level.pieces;
      for (const HullFace& face : tree.hull(piece).faces) {
        level.triangles += face.n_edges - 2;
        level.virtual_faces += face.is_virtual;
      }
      level.faces += piece.n_faces;
      level.deviation = std::max(level.deviation, piece.deviation);
      level.hull_distance = std::max(level.hull_distance, piece.hull_distance);
      level.least_resolution = std::min(level.least_resolution, piece.resolution);
      level.most_resolution = std::max(level.most_resolution, piece.resolution);
    }
  }
  return levels;
}

size_t bytes_of(const PieceTree& tree) {
  return tree.pieces.size_bytes() + tree.vertices.size_bytes() + tree.edges.size_bytes() +
         tree.faces.size_bytes() + tree.edge_from.size_bytes() + tree.leaf_of.size_bytes() +
         tree.level_pieces.size_bytes();
}

std::string pieces_as_ply(const PieceTree& tree, uint32_t level) {
  const std::vector<uint32_t> pieces = pieces_at(tree, level);
  size_t n_vertices = 0, n_faces = 0;
  for (const uint32_t i : pieces) {
    n_vertices += tree.pieces[i].n_vertices;
    n_faces += tree.pieces[i].n_faces;
  }
  HAPTIC_ASSERT(n_vertices <= static_cast<size_t>(std::numeric_limits<int32_t>::max()));
  std::string vertices, faces;
  uint32_t first_vertex = 0;
  for (uint32_t k = 0; k < pieces.size(); ++k) {
    const Hull hull = tree.hull(tree.pieces[pieces[k]]);
    append_vertices(vertices, hull, piece_colour(k));
    append_faces(faces, hull, first_vertex, k, piece_colour(k));
    first_vertex += static_cast<uint32_t>(hull.vertices.size());
  }
  return header_of(n_vertices, n_faces) + vertices + faces;
}

}  // namespace haptic
