// SPDX-License-Identifier: GPL-3.0-or-later
// Whose cache is believed, and that writing one touches no other file.
#include <sys/stat.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

#include "contact/bake/cache.h"
#include "proto/os/environment.h"
#include "tests/support/hostile_text.h"
#include "tests/support/temporary_folder.h"

namespace haptic {
namespace {

namespace fs = std::filesystem;

constexpr uid_t kStranger = 65534;

std::string text_of(const std::string& path) {
  std::ifstream file(path);
  return {std::istreambuf_iterator<char>(file), {}};
}

std::string write_text(const std::string& path, const std::string& text) {
  const auto* const bytes = reinterpret_cast<const std::byte*>(text.data());
  return write_atomically(path, {bytes, text.size()});
}

/// Why a cache is not believed; empty: it is.
std::string distrust_of(const std::string& path) {
  return test::refusal([&] { map_cached(path); });
}

bool may_give_away() {
  if (geteuid() == 0) return true;
  WARN("SKIPPED: only root can give a file away");
  return false;
}

}  // namespace

TEST_CASE("cache: one's own is believed, one that others may write or that is a link is not") {
  const test::TemporaryFolder folder;
  const std::string path = folder.path() + "/key.baked";
  REQUIRE(write_text(path, "baked").empty());
  CHECK(distrust_of(path).empty());
  struct stat status {};
  REQUIRE(stat(path.c_str(), &status) == 0);
  CHECK((status.st_mode & 0777) == 0600);

  fs::permissions(path, fs::perms::others_write, fs::perm_options::add);
  CHECK(distrust_of(path) == "others may write it");
  fs::permissions(path, fs::perms::others_write, fs::perm_options::remove);

  const std::string link = folder.path() + "/link.baked";
  fs::create_symlink(path, link);
  CHECK_FALSE(distrust_of(link).empty());
}

TEST_CASE("cache: a file of another user is not believed") {
  if (!may_give_away()) return;
  const test::TemporaryFolder folder;
  const std::string path = folder.path() + "/key.baked";
  REQUIRE(write_text(path, "forged").empty());
  REQUIRE(chown(path.c_str(), kStranger, kStranger) == 0);
  CHECK(distrust_of(path) == "it belongs to user 65534");
}

TEST_CASE("cache: nothing is written into a folder of another user, nor through his link") {
  if (!may_give_away()) return;
  const test::TemporaryFolder folder;
  const std::string foreign = folder.path() + "/foreign", own = folder.path() + "/own";
  for (const std::string& made : {foreign, own}) fs::create_directory(made);
  REQUIRE(chown(foreign.c_str(), kStranger, kStranger) == 0);
  CHECK(write_text(foreign + "/key.baked", "x") == "it belongs to user 65534");

  const std::string link = folder.path() + "/link";
  fs::create_directory_symlink(own, link);
  REQUIRE(lchown(link.c_str(), kStranger, kStranger) == 0);
  CHECK(write_text(link + "/key.baked", "x") == "it is a link of another user");

  fs::permissions(own, fs::perms::others_write, fs::perm_options::add);
  CHECK(write_text(own + "/key.baked", "x") == "others may write it");
  CHECK(fs::is_empty(foreign));
  CHECK(fs::is_empty(own));
}

TEST_CASE("cache: a link in the place of the file is replaced, what it points to is not written") {
  const test::TemporaryFolder folder;
  const std::string victim = folder.path() + "/victim", path = folder.path() + "/key.baked";
  std::ofstream(victim) << "precious";
  // the name of the entry, and one that is derived from it and the process, as is often done
  const std::string guessed = path + "." + std::to_string(getpid()) + ".tmp";
  for (const std::string& link : {path, guessed}) fs::create_symlink(victim, link);
  REQUIRE(write_text(path, "baked").empty());
  CHECK(text_of(victim) == "precious");
  CHECK(text_of(path) == "baked");
  CHECK_FALSE(fs::is_symlink(path));
  CHECK(distrust_of(path).empty());
}

TEST_CASE("cache: without a home its folder is no known name of root's in /tmp") {
  const test::Environment own("HAPTICD_CACHE"), xdg("XDG_CACHE_HOME"), home("HOME");
  const std::string folder = fs::path(cache_path(1)).parent_path();
  CAPTURE(folder);
  if (geteuid() == 0) {
    CHECK(folder == "/var/cache/hapticd");
  } else {
    CHECK(folder == fs::temp_directory_path() / ("hapticd-cache-" + std::to_string(geteuid())));
  }
}

}  // namespace haptic
