// SPDX-License-Identifier: GPL-3.0-or-later
// A pipe in place of a mesh or its cache: opening one blocks until there is a writer.
#include <sys/stat.h>

#include <catch2/catch.hpp>
#include <filesystem>
#include <fstream>
#include <string>

#include "contact/bake/bake.h"
#include "tests/support/mesh_files.h"
#include "tests/support/temporary_folder.h"

namespace haptic {
namespace {

constexpr uint64_t kPlenty = uint64_t{4} << 30;

/// A folder for a mesh, with the cache inside it.
struct Bench {
  test::TemporaryFolder folder;
  std::string cache = folder.path() + "/cache";
  Bench() { ::setenv("HAPTICD_CACHE", cache.c_str(), 1); }
  ~Bench() { ::unsetenv("HAPTICD_CACHE"); }
};

ObjectConfig object_at(const std::string& path) {
  ObjectConfig object;
  assign(object.name, "thing");
  assign(object.mesh, path);
  object.unit = 1;
  return object;
}

}  // namespace

TEST_CASE("bake: a pipe in the place of a mesh is refused, and nobody waits") {
  const Bench bench;
  const std::string pipe = bench.folder.path() + "/pipe.off";
  REQUIRE(::mkfifo(pipe.c_str(), 0600) == 0);
  CHECK_THROWS_WITH(bake_object(object_at(pipe), kPlenty), pipe + ": is a pipe; check the path");
}

TEST_CASE("bake: a pipe in the place of a cache is no cache, and nobody waits") {
  const Bench bench;
  const std::string path = bench.folder.path() + "/s.off";
  std::ofstream(path, std::ios::binary) << test::as_off(make_icosphere(0.05, 2));
  const ObjectConfig object = object_at(path);
  bake_object(object, kPlenty);
  const std::filesystem::path cached = *std::filesystem::directory_iterator(bench.cache);
  std::filesystem::remove(cached);
  REQUIRE(::mkfifo(cached.c_str(), 0600) == 0);
  const BakedShape again = bake_object(object, kPlenty);
  CHECK_FALSE(again.report.from_cache);
  CHECK_THAT(again.report.lines.back(),
             Catch::Contains("unusable (it is no file)") && Catch::Contains("baked again"));
  CHECK(bake_object(object, kPlenty).report.from_cache);
}

}  // namespace haptic
