// SPDX-License-Identifier: GPL-3.0-or-later
// hapt bake: prepares a mesh before a session needs it, and says what that came to.
#include <CLI/CLI.hpp>
#include <iostream>
#include <memory>

#include "clients/hapt_commands.h"
#include "contact/bake.h"

namespace haptic {
namespace {

constexpr uint64_t kMemoryLimit = uint64_t{4} << 30;  // as much as a session allows a mesh

struct BakeOptions {
  std::string mesh;
  double unit = 0, size = 0;
  bool allow_open = false, explain = false;
};

void run_bake(const BakeOptions& options) {
  ObjectConfig object{};
  assign(object.mesh, options.mesh);
  object.unit = options.unit;
  object.size = options.size;
  object.allow_open = options.allow_open;
  const BakeReport report = bake_object(object, kMemoryLimit).report;
  std::cout << options.mesh << ": " << report.triangles << " triangles, " << report.vertices
            << " vertices, " << 1e3 * report.size << " mm, " << (report.closed ? "closed" : "open")
            << (report.from_cache ? "; from the cache" : "; baked into the cache") << '\n';
  for (const std::string& line : report.lines) std::cout << "  " << line << '\n';
  if (!options.explain) return;
  for (const std::string& line : report.grid) std::cout << "  " << line << '\n';
}

}  // namespace

void add_bake_command(CLI::App& app) {
  const auto options = std::make_shared<BakeOptions>();
  CLI::App* command =
      app.add_subcommand("bake", "Prepare a mesh: check it and put it in the cache");
  command->add_option("mesh", options->mesh, "mesh file (OBJ, STL, PLY, OFF)")->required();
  command
      ->add_option("--unit", options->unit, "of the file [m]; left out: metres, or any with a size")
      ->check(CLI::PositiveNumber);
  command->add_option("--size", options->size, "longest side [m]")->check(CLI::PositiveNumber);
  command->add_flag("--allow-open", options->allow_open, "the mesh may have borders");
  command->add_flag("--explain", options->explain, "how the size of the grid's cells was chosen");
  command->callback([options] { run_bake(*options); });
}

}  // namespace haptic
