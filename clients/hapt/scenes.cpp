// SPDX-License-Identifier: GPL-3.0-or-later
#include "clients/hapt/scenes.h"

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <iostream>
#include <stdexcept>

#include "clients/hapt/session_process.h"
#include "proto/config/read/config_shape.h"
#include "proto/os/programs.h"
#include "proto/os/realtime.h"
#include "proto/os/session_file.h"
#include "proto/os/source_tree.h"

namespace haptic {
namespace {

const Scene& scene_of(const std::string& name) {
  return *std::ranges::find(kScenes, name, &Scene::name);
}

/// True in an installation that has not fetched the bunny yet, which its licence keeps out of the
/// package. A checkout has `./run meshes`.
bool lacks_bunny() {
  const auto has_it = [](const std::filesystem::path& folder) {
    std::error_code error;
    return std::filesystem::exists(folder / "bunny00.off", error);
  };
  const std::vector<std::filesystem::path> folders = mesh_folders();
  return source_tree().empty() && std::none_of(folders.begin(), folders.end(), has_it);
}

constexpr int64_t kPollPeriod = 20'000'000;  // [ns]

void fetch_meshes() {
  SessionProcess fetch("fetch-meshes", {fetched_meshes().string()});
  while (!fetch.exit_code()) sleep_until(now_ns() + kPollPeriod);
  if (fetch.exit_code() != 0) {
    throw std::runtime_error("the bunny is not there; `hapt demo peg` needs no mesh");
  }
}

}  // namespace

std::vector<std::string> scene_names() {
  std::vector<std::string> names;
  for (const Scene& scene : kScenes) names.emplace_back(scene.name);
  return names;
}

std::string scene_title(const std::string& name) {
  return scene_of(name).title;
}

void list_scenes(std::ostream& out) {
  for (const Scene& scene : kScenes) {
    const std::string name = scene.name;
    out << "hapt demo " << name << std::string(15 - name.size(), ' ') << scene.title << '\n';
  }
  out << "hapt demo --mesh part.stl --unit mm   a mesh of yours\n";
}

std::string default_scene() {
  if (!lacks_bunny()) return "bunny";
  std::cerr << "playing 'peg', a peg in a hole; `hapt demo bunny` fetches the bunny first\n";
  return "peg";
}

std::string prepare_scene(const std::string& name) {
  const Scene& scene = scene_of(name);
  if (scene.has_bunny && lacks_bunny()) fetch_meshes();
  return scene.file;
}

std::string scene_script(const std::string& name) {
  const char* script = scene_of(name).script;
  if (script == nullptr) return "";
  namespace fs = std::filesystem;
  const fs::path tree = source_tree();
  const fs::path folder =
      tree.empty() ? shared_folder("examples") : tree / "clients/python/examples";
  // the module of a checkout lies beside the programs
  const fs::path built = fs::path(program_folder()).parent_path() / "python";
  std::error_code error;
  if (fs::exists(built, error)) setenv("PYTHONPATH", built.c_str(), 1);
  SessionProcess imports(kPython, {"-c", "import hapticd"}, "/dev/null");
  while (!imports.exit_code()) sleep_until(now_ns() + kPollPeriod);
  if (imports.exit_code() != 0 || !fs::exists(folder / script, error)) {
    throw std::runtime_error("'" + name +
                             "' is computed by a Python script, and the package "
                             "python3-hapticd is not there; install it, or ./run build a checkout");
  }
  return (folder / script).string();
}

}  // namespace haptic
