// SPDX-License-Identifier: GPL-3.0-or-later
// What a session costs whose meshes nobody has prepared before.
#include <catch2/catch.hpp>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include "tests/process/hapticd_process.h"
#include "tests/process/watcher.h"
#include "tests/support/temporary_folder.h"

namespace haptic {
namespace {

using namespace test;

constexpr double kMoreThanWarm = 1.25;  // a cold start may hold this much of what a warm one does

/// Writes the plane and a sphere of 20·4ⁿ triangles; returns the path.
std::string write_sphere(const std::string& folder, int n) {
  std::ofstream(folder + "/sphere.toml")
      << std::ifstream(from_source("configs/plane.toml")).rdbuf()
      << "\n[[object]]\nname = \"fine\"\nprimitive = \"sphere\"\nsize = \"100 mm\"\n"
      << "subdivisions = " << n << "\n";
  return folder + "/sphere.toml";
}

/// A line of /proc/PID/status, as "VmRSS" [kB].
double kilobytes_of(pid_t pid, const std::string& key) {
  std::ifstream status("/proc/" + std::to_string(pid) + "/status");
  for (std::string line; std::getline(status, line);) {
    if (line.starts_with(key + ":")) return std::stod(line.substr(key.size() + 1));
  }
  return 0;
}

/// The most memory that contact had until it answered [kB].
double peak_of_contact(const std::string& config, const std::string& name) {
  const RunningSession session(config, name);
  INFO(session.hapticd.log());
  return kilobytes_of(writer_of(session.watcher.contact), "VmHWM");
}

std::vector<pid_t> children_of(pid_t pid) {
  const std::string id = std::to_string(pid);
  std::ifstream list("/proc/" + id + "/task/" + id + "/children");
  return {std::istream_iterator<pid_t>(list), {}};
}

/// The child of a child of hapticd: contact's, where nothing has mass that sim would prepare. 0:
/// there is none.
pid_t baker_of(pid_t hapticd) {
  for (const pid_t child : children_of(hapticd)) {
    for (const pid_t baker : children_of(child)) return baker;
  }
  return 0;
}

}  // namespace

TEST_CASE("cold start: contact holds what it does of a mesh that was prepared before") {
  const TemporaryFolder folder;
  const std::string config = write_sphere(folder.path(), 6);
  const TemporaryCache cache;
  const double cold = peak_of_contact(config, "cold"), warm = peak_of_contact(config, "warm");
  CAPTURE(cold, warm);
  REQUIRE(warm > 0);
  CHECK(cold < kMoreThanWarm * warm);
  // nor where nothing can be kept
  const Environment nowhere("HAPTICD_CACHE", "/proc/nowhere");
  const double uncached = peak_of_contact(config, "uncached");
  CAPTURE(uncached);
  CHECK(uncached < kMoreThanWarm * warm);
}

TEST_CASE("cold start: who prepares a mesh ends with its session") {
  const TemporaryCache cache;
  const TemporaryRuntimeFolder folder;
  HapticdProcess hapticd({write_sphere(folder.path(), 8), "--session", "short"}, folder.path());
  REQUIRE(eventually([&] { return hapticd.said("contact0: preparing primitive:sphere"); }));
  pid_t baker = 0;
  REQUIRE(eventually([&] { return (baker = baker_of(hapticd.pid())) > 0; }));
  SECTION("that is stopped") {
    hapticd.send(SIGTERM);
    CHECK(hapticd.exit_code() == kExitClean);
  }
  SECTION("that is killed") {
    hapticd.send(SIGKILL);
    CHECK(hapticd.exit_code() == -SIGKILL);
  }
  CHECK(eventually([&] { return !is_alive(uint64_t(baker)); }));
}

}  // namespace haptic
