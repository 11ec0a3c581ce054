// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/bake/pieces.h"

#include <catch2/catch.hpp>
#include <cstring>
#include <filesystem>
#include <fstream>

#include "contact/bake/cache.h"
#include "contact/bake/eye_files.h"
#include "contact/bake/session.h"
#include "proto/ipc/channels.h"
#include "proto/os/environment.h"
#include "tests/support/meshes.h"
#include "tests/support/temporary_folder.h"

using namespace haptic;
using namespace haptic::test;

namespace {

namespace fs = std::filesystem;

BakedShape baked_box(double side) {
  const Soup box = make_box({side, side, side});
  return bake_soup(box.vertices, box.triangles, {});
}

std::vector<fs::path> files_in(const fs::path& folder) {
  std::vector<fs::path> files;
  if (!fs::exists(folder)) return files;
  for (const auto& entry : fs::directory_iterator(folder)) files.push_back(entry.path());
  return files;
}

bool is_same(const PieceTree& a, const PieceTree& b) {
  const auto same = [](const auto& x, const auto& y) {
    return x.size() == y.size() && std::memcmp(x.data(), y.data(), x.size_bytes()) == 0;
  };
  return same(a.pieces, b.pieces) && same(a.vertices, b.vertices) && same(a.edges, b.edges) &&
         same(a.faces, b.faces) && same(a.edge_from, b.edge_from) && same(a.leaf_of, b.leaf_of) &&
         same(a.level_pieces, b.level_pieces);
}

}  // namespace

TEST_CASE("baked pieces: the second time from the cache, and the same to the bit") {
  const TemporaryCache cache;
  const BakedShape box = baked_box(0.02);
  const BakedPieces made = bake_pieces(box), read = bake_pieces(box);
  CHECK(!made.from_cache);
  CHECK(read.from_cache);
  CHECK(read.time == 0);
  REQUIRE(made.tree.pieces.size() == 1);
  CHECK(is_same(made.tree, read.tree));
  CHECK(!bake_pieces(baked_box(0.03)).from_cache);
}

TEST_CASE("baked pieces: a damaged cache file is baked again, and the finding says so") {
  const TemporaryCache cache;
  const BakedShape box = baked_box(0.02);
  const BakedPieces made = bake_pieces(box);
  const std::vector<fs::path> files = files_in(cache.path());
  REQUIRE(files.size() == 1);
  {
    std::fstream file(files[0], std::ios::in | std::ios::out | std::ios::binary);
    file.seekp(-20, std::ios::end);
    file.put('x');
  }
  const BakedPieces again = bake_pieces(box);
  CHECK(!again.from_cache);
  REQUIRE(again.lines.size() == 1);
  CHECK(again.lines[0].find("was unusable") != std::string::npos);
  CHECK(is_same(made.tree, again.tree));
  CHECK(bake_pieces(box).from_cache);
}

TEST_CASE("baked pieces: a session that wants them has those of all bodies, and shows them") {
  const TemporaryCache cache;
  SessionConfig config{};
  config.n_objects = 1;
  for (ShapeConfig* shape :
       {static_cast<ShapeConfig*>(&config.objects[0]), static_cast<ShapeConfig*>(&config.tool)}) {
    shape->primitive = primitive::Box{{0.02, 0.02, 0.02}};
    assign(shape->name, "box");
  }
  CHECK(bake_session(config).shapes().bodies.pieces.empty());
  config.pieces.is_wanted = 1;
  const BakedSession baked = bake_session(config);
  const ContactShapes shapes = baked.shapes();
  REQUIRE(shapes.bodies.pieces.size() == 1);
  CHECK(shapes.bodies.pieces[0].faces.size() == 6);
  CHECK(shapes.bodies.tool_pieces.faces.size() == 6);
  std::vector<SegmentId> ids;
  for (const SealedEye& eye :
       make_eye_files(config, baked, [](const std::string& line) { FAIL(line); })) {
    ids.push_back(eye.id);
  }
  CHECK(ids == std::vector{eye_id(kEyeOfTool), pieces_id(kEyeOfTool), eye_id(0), pieces_id(0)});
}
