// SPDX-License-Identifier: GPL-3.0-or-later
// hapt bake and the benchmarks of collision queries at a small size, on the real binary.
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "proto/os/programs.h"
#include "tests/process/hapt_command.h"
#include "tests/process/watcher.h"
#include "tests/support/temporary_folder.h"

namespace haptic {
namespace {

using namespace test;

/// A tetrahedron small enough to lie within every cell.
void write_mesh(const std::string& path) {
  std::ofstream(path) << "OFF\n4 4 0\n0 0 0\n0.1 0 0\n0 0.1 0\n0 0 0.1\n"
                         "3 0 2 1\n3 0 1 3\n3 0 3 2\n3 1 2 3\n";
}

/// Whether a goal is met depends on the machine, but a miss must be reported.
void check_told(const Ran& ran) {
  CHECK((ran.code == 0 || ran.code == 1));
  CHECK((ran.code == 1) == has(ran.output, "\"holds\": false"));
}

void check_rows(const Ran& ran, const std::vector<std::string>& rows) {
  for (const std::string& row : rows) {
    CAPTURE(row);
    CHECK(figure(ran.output, row) > 0);
  }
}

}  // namespace

TEST_CASE("hapt bake: the same mesh makes the same file") {
  const TemporaryRuntimeFolder folder;
  write_mesh(folder.path() + "/t.off");
  std::vector<std::string> files;
  for (const char* cache : {"/first", "/second"}) {
    const std::string words =
        std::string("HAPTICD_CACHE=$PWD") + cache + " hapt bake t.off --unit 1";
    CHECK(shell(words, folder.path()).code == 0);
    for (const auto& entry : std::filesystem::directory_iterator(folder.path() + cache)) {
      std::ifstream file(entry.path(), std::ios::binary);
      files.emplace_back(std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>());
    }
  }
  REQUIRE(files.size() == 2);
  CHECK(files[0].size() > 1000);
  CHECK(files[0] == files[1]);
}

TEST_CASE("hapt bake --explain: the pieces and their levels, the same from the cache") {
  const TemporaryRuntimeFolder folder;
  write_mesh(folder.path() + "/t.off");
  const std::string words = "HAPTICD_CACHE=$PWD/cache hapt bake t.off --unit 1";
  const Ran fresh = shell(words + " --explain", folder.path());
  const Ran cached = shell(words + " --explain", folder.path());
  const Ran brief = shell(words, folder.path());
  INFO(fresh.output);
  CHECK(fresh.code == 0);
  for (const char* part :
       {"4 triangles, 4 vertices, 100 x 100 x 100 mm, closed; baked into the cache",
        "1 convex pieces of 4 triangles, 1 levels of detail",
        "level 0: 1 pieces, 4 faces, 0 of them virtual"}) {
    CAPTURE(part);
    CHECK(has(fresh.output, part));
  }
  CHECK(has(cached.output, "; from the cache"));
  // the lines before end with the time or the cache that they took
  const auto after_times = [](const std::string& text) {
    return text.substr(text.find("  level 0"));
  };
  CHECK(after_times(fresh.output) == after_times(cached.output));
  CHECK_FALSE(has(brief.output, "level 0"));
  CHECK(hapt("bake missing.off --explain", folder.path()).code != 0);
}

TEST_CASE("hapt zwidth, passivity, bode: rows as JSON, and a drawing") {
  const TemporaryRuntimeFolder folder;
  for (const char* words : {"zwidth --damping 0 --hand none --friction 0 --encoder 0",
                            "passivity --stiffness 500", "bode --periods 1 --delay 1"}) {
    const std::string each = std::string(words) + " --json -o drawn.svg --overwrite";
    const Ran ran = hapt(each, folder.path());
    INFO(each << ran.output);
    CHECK(ran.code == 0);
    CHECK(has(ran.output, "\"metric\": "));
    std::ifstream file(folder.path() + "/drawn.svg");
    const std::string svg((std::istreambuf_iterator<char>(file)), std::istreambuf_iterator<char>());
    CHECK(has(svg, "</svg>"));
    CHECK(has(svg, "[Hz]") == !has(each, "zwidth"));
  }
  // twice the limit 2 (b - b_c)/T of a device with 1 N·s/m
  const Ran stiff = hapt("passivity --stiffness 4000 --damping 0", folder.path());
  CHECK(stiff.code == 1);
  CHECK(has(stiff.output, "MISSED (goal 2000 N/m)"));
  CHECK(hapt("passivity --stiffness \"3 kg\"", folder.path()).code == 2);
  CHECK(hapt("zwidth --turning", folder.path()).code == 2);
}

TEST_CASE("hapt bench segment, bake: every row on a tiny mesh, and what was left out") {
  const TemporaryRuntimeFolder folder;
  const Ran segment = shell(
      "HAPTICD_MESHES=$PWD hapt bench segment --mesh bump:4 --mesh bunny --segments 300 --rounds 1 "
      "--checked 50 --json",
      folder.path());
  INFO(segment.output);
  check_told(segment);
  CHECK(figure(segment.output, "triangles") == 320);
  for (const char* wrong :
       {"missed, against brute force", "extra, against brute force", "another hit than brute force",
        "different between the five searches"}) {
    CAPTURE(wrong);
    CHECK(figure(segment.output, wrong) == 0);
  }
  for (const std::string column : {"grid", "tree", "naive"}) {
    for (const std::string which : {"hits", "misses", "all"}) {
      const std::string ratio = column + " : hybrid, " + which;
      check_rows(segment, {ratio + ", mean", ratio + ", worst"});
    }
  }
  check_rows(segment, {"sweep, cheapest cell", "with witness p50"});
  // a peer is measured or listed as left out, and so is a missing mesh
  for (const char* said : {"Embree 3 robust", "CGAL AABB tree", "Bullet", "LEFT OUT: "})
    CHECK(has(segment.output, said));
  CHECK(hapt("bench segment --mesh nonsense", folder.path()).code != 0);

  const Ran bake =
      shell("HAPTICD_CACHE=$PWD hapt bench bake --n 8 --rounds 1 --json", folder.path());
  INFO(bake.output);
  check_told(bake);
  CHECK(figure(bake.output, "triangles") == 128);
  check_rows(bake, {"trees and grid built", "trees and grid built, CPU of both threads",
                    "trees and grid, bytes a triangle", "size in the cache",
                    "mapped from the cache and checked"});
  CHECK(std::filesystem::is_empty(folder.path()));
}

TEST_CASE("hapt bench point-proxy: a contact step on a tiny mesh allocates nothing") {
#if defined(__SANITIZE_THREAD__) || defined(__SANITIZE_ADDRESS__)
  WARN("SKIPPED: rt_guard and a sanitizer interpose the same functions");
  return;
#endif
  const TemporaryRuntimeFolder folder;
  const Ran ran = hapt("bench point-proxy --mesh hf:8 --repetitions 1 --json", folder.path());
  INFO(ran.output);
  check_told(ran);
  CHECK(figure(ran.output, "triangles") == 128);
  CHECK(figure(ran.output, "allocations") == 0);
  CHECK(figure(ran.output, "contact step, CPU p50") > 0);
}

TEST_CASE("hapt bench voxel: every row on tiny maps") {
  const TemporaryRuntimeFolder folder;
  const Ran ran = hapt(
      "bench voxel --side 24 --points 500 --coarse 4 --fine 8 --rounds 1 "
      "--memory-side 0 --pair peg --coarser 8 --ticks 200 --json",
      folder.path());
  INFO(ran.output);
  check_told(ran);
  for (const std::string order : {"24³, 500 points, ordered, ", "24³, 500 points, shuffled, "}) {
    check_rows(ran, {order + "points", order + "points not free", order + "scalar",
                     order + "scalar over its ceiling"});
    // SIMD is measured or listed as left out
    CHECK(has(ran.output, order + "lanes"));
  }
  check_rows(
      ran, {"24³, map", "24³, dense", "320 triangles", "1280 triangles", "many over few triangles",
            "2 mm off, tested a tick, tree alone", "5 mm off, fewer points by coherence",
            "peg in hole, points", "peg in hole, CPU p99", "peg in hole, points touching max",
            "peg in hole, budget for 0.8 ms"});
  // a peer is measured or listed as left out
  CHECK(has(ran.output, "FCL"));
  CHECK(figure(ran.output, "peg in hole, deep, points over the budget") == 0);
  CHECK(hapt("bench voxel --side 1", folder.path()).code != 0);
}

}  // namespace haptic
