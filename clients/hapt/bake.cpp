// SPDX-License-Identifier: GPL-3.0-or-later
// hapt bake: prepares a mesh before a session needs it and reports the result.
#include <fstream>
#include <iostream>
#include <optional>

#include "clients/hapt/commands.h"
#include "clients/hapt/mesh_scene.h"
#include "contact/bake/bake.h"
#include "contact/bake/cache.h"
#include "contact/bake/piece_files.h"
#include "contact/bake/pieces.h"
#include "contact/bake/reach.h"
#include "contact/bake/session.h"
#include "contact/bake/volume.h"
#include "proto/config/command_line.h"
#include "proto/config/quantity.h"
#include "proto/config/read/config_shape.h"
#include "proto/config/read/config_tool.h"
#include "proto/os/message.h"
#include "proto/os/progress.h"
#include "proto/os/text.h"

namespace haptic {
namespace {

constexpr uint64_t kMemoryLimit = uint64_t{4} << 30;  // [bytes]; the limit a session has per mesh

struct BakeOptions {
  std::string mesh, unit, ply;
  double size = 0, voxel = 0, band = 0, spacing = 0;  // 0: not given
  uint64_t level = 0;
  bool allow_open = false, explain = false, map_alone = false, as_sheet = false, pieces = false;
};

VoxelConfig voxel_options(const BakeOptions& options) {
  VoxelConfig voxel;
  voxel.size = voxel.point_spacing = options.voxel;
  voxel.band = options.band > 0 ? options.band : default_band(voxel);
  const Range bands = band_range(voxel);
  if (voxel.band < bands.min || voxel.band > bands.max) {
    throw UsageError("--band: must lie between " + quantity_text(bands.min, Dimension::kLength) +
                     " and " + quantity_text(bands.max, Dimension::kLength) +
                     " with voxels of this size");
  }
  if (options.spacing > 0) voxel.point_spacing = options.spacing;
  voxel.field = options.map_alone ? 0 : 1;
  voxel.open_as_sheet = options.as_sheet;
  return voxel;
}

std::string made_in(double seconds, bool from_cache) {
  return from_cache ? "from the cache" : formatted("%.3g s", seconds);
}

/// "0.11 MB".
std::string megabytes(size_t bytes) {
  return formatted("%.3g MB", 1e-6 * static_cast<double>(bytes));
}

void print_map(const BakedVolume& obstacle) {
  const Voxmap& map = obstacle.content.map;
  std::cout << "  map " << map.bricks[0] * kBrickSide << " x " << map.bricks[1] * kBrickSide
            << " x " << map.bricks[2] * kBrickSide << " voxels of " << 1e3 * map.size << " mm, "
            << megabytes(map.index.size_bytes() + map.data.size_bytes()) << "; "
            << made_in(obstacle.map_time, obstacle.from_cache) << '\n';
}

void print_field(const BakedVolume& obstacle) {
  const DistanceField& field = obstacle.content.field;
  const size_t bytes =
      field.index.size_bytes() + field.middle.size_bytes() + field.data.size_bytes();
  std::cout << "  distance field " << field.data.size() << " bricks, band " << 1e3 * field.band
            << " mm, " << megabytes(bytes) << "; "
            << made_in(obstacle.field_time, obstacle.from_cache) << '\n';
}

void print_shell(const BakedVolume& tool) {
  const Pointshell& shell = tool.content.shell;
  std::cout << "  as a tool " << shell.x.size() << " points, " << 1e3 * shell.spacing
            << " mm apart; " << made_in(tool.shell_time, tool.from_cache) << '\n';
}

void run_voxel(const BakedShape& shape, const VoxelConfig& voxel, const BakeProgress& show) {
  const BakedVolume obstacle = bake_obstacle(shape, voxel, show);
  const BakedVolume tool = bake_tool(shape, voxel, show);
  print_map(obstacle);
  if (voxel.field != 0) print_field(obstacle);
  print_shell(tool);
  for (const BakedVolume* volume : {&obstacle, &tool}) {
    for (const std::string& line : volume->lines) std::cout << "  " << one_line(line) << '\n';
  }
}

/// Prints one line on a level of detail.
void print_level(const std::vector<PieceLevel>& levels, size_t i) {
  const PieceLevel& level = levels[i];
  std::cout << "    level " << i << ": " << level.pieces << " pieces";
  if (i > 0) {
    const auto before = static_cast<double>(levels[i - 1].pieces);
    std::cout << formatted(" (%.3g of the level before)",
                           static_cast<double>(level.pieces) / before);
  }
  std::cout
      << ", " << level.faces << " faces, " << level.virtual_faces << " of them virtual; "
      << formatted(
             "within %.3g mm of the surface, hulls within %.3g mm; edges of %.3g to %.3g mm\n",
             1e3 * level.deviation, 1e3 * level.hull_distance, 1e3 / level.most_resolution,
             1e3 / level.least_resolution);
}

void write_ply(const PieceTree& tree, const BakeOptions& options) {
  if (options.level >= tree.level_pieces.size()) {
    throw UsageError("--level: there are " + std::to_string(tree.level_pieces.size()) +
                     " levels of detail, from 0 on");
  }
  const auto level = static_cast<uint32_t>(options.level);
  const std::string ply = pieces_as_ply(tree, level);
  std::ofstream file(options.ply, std::ios::binary | std::ios::trunc);
  file.write(ply.data(), static_cast<std::streamsize>(ply.size()));
  if (!file.flush()) {
    throw MessageError(options.ply + ": cannot be written; check the folder and the space left");
  }
  std::cout << "  wrote " << shown(options.ply) << ": the " << pieces_at(tree, level).size()
            << " pieces of level " << level << ", one colour each, in metres\n";
}

void run_pieces(const BakedShape& shape, const BakeOptions& options, const BakeProgress& show) {
  const BakedPieces baked = bake_pieces(shape, show);
  const PieceTree& tree = baked.tree;
  const std::vector<PieceLevel> levels = levels_of(tree);
  std::cout << "  " << levels.at(0).pieces << " convex pieces of " << tree.leaf_of.size()
            << " triangles, " << levels.size() << " levels of detail, " << tree.pieces.size()
            << " hulls, " << megabytes(bytes_of(tree)) << "; "
            << made_in(baked.time, baked.from_cache) << '\n';
  for (const std::string& line : baked.lines) std::cout << "  " << one_line(line) << '\n';
  for (size_t i = 0; options.explain && i < levels.size(); ++i) print_level(levels, i);
  if (!options.ply.empty()) write_ply(tree, options);
}

/// The sides of the bounding box: "80 x 20 x 20 mm".
std::string box_text(const TriangleMesh& mesh) {
  const Vec3 side = 1e3 * (mesh.upper - mesh.lower);
  return formatted("%g x %g x %g mm", side.x, side.y, side.z);
}

void run_bake(const BakeOptions& options) {
  ShapeConfig object{};
  assign(object.mesh, options.mesh);
  if (options.unit == "any" && options.size == 0) {
    throw UsageError("--unit any: scales the mesh to --size, which is missing");
  }
  object.unit = options.unit.empty() ? 0 : parse_mesh_unit(options.unit, "m");
  object.size = options.size;
  object.allow_open = options.allow_open || options.as_sheet;
  const std::optional<VoxelConfig> voxel =
      options.voxel > 0 ? std::optional(voxel_options(options)) : std::nullopt;
  StageProgress progress;
  const BakeProgress show = [&](std::string_view stage, double share) {
    progress.at(stage, share);
  };
  const BakedShape shape = bake_object(object, kMemoryLimit, show);
  const BakeReport& report = shape.report;
  std::cout << shown(options.mesh) << ": " << report.triangles << " triangles, " << report.vertices
            << " vertices, " << box_text(shape.shape.mesh) << ", "
            << (report.closed ? "closed" : "open")
            << (report.from_cache ? "; from the cache" : "; baked into the cache") << '\n';
  for (const std::string& line : report.lines) std::cout << "  " << one_line(line) << '\n';
  if (const std::string doubt = size_doubt(object, report.size); !doubt.empty()) {
    std::cout << "  warning: it " << doubt << '\n';
  }
  if (voxel) run_voxel(shape, *voxel, show);
  if (options.pieces || options.explain || !options.ply.empty()) run_pieces(shape, options, show);
  // with a real unit and a size the size is checked, not wanted
  const bool is_scaled = object.unit == 0 && object.size > 0;
  std::cout << "for a session file:\n\n"
            << object_text({options.mesh, options.unit, is_scaled ? object.size : 0,
                            object.allow_open != 0},
                           0.5 * (shape.shape.mesh.lower + shape.shape.mesh.upper));
}

}  // namespace

void add_bake_command(Command& app) {
  add_command<BakeOptions>(
      app, "bake", "Prepare a mesh: check it and put it in the cache", run_bake,
      [](Command& command, BakeOptions& options) {
        command.option("MESH", options.mesh, "mesh file (OBJ, STL, PLY, OFF)").required();
        command
            .option("--unit UNIT", options.unit,
                    "of the file: m, mm, cm, in, a length, or any to scale the mesh to --size")
            .check(problem_of_unit)
            .show_default("m, or any with --size");
        command.quantity("--size", options.size, Dimension::kLength, kMeshSizes,
                         "longest side, as \"80 mm\"; a number without unit is in metres", "m");
        command.flag("--allow-open", options.allow_open, "the mesh may have borders");
        const auto length = [&](const char* name, double& value, const Range& range,
                                const char* help) {
          return command.quantity(name, value, Dimension::kLength, range, help);
        };
        length("--voxel", options.voxel, kVoxelSizes,
               "also bake what the renderer voxel needs, with voxels of this size, as 1mm");
        length("--band", options.band, kPositive, "of the distance field")
            .needs("--voxel")
            .show_default("two voxels");
        length("--spacing", options.spacing, kVoxelSizes, "of the tool's points")
            .needs("--voxel")
            .show_default("that of --voxel");
        command.flag("--map-alone", options.map_alone, "no distance field").needs("--voxel");
        command.flag("--as-sheet", options.as_sheet, "an open mesh is a sheet one voxel thick")
            .needs("--voxel");
        command.flag("--pieces", options.pieces,
                     "also bake what the renderers localized and sensation need");
        command.flag("--explain", options.explain, "the convex pieces and their levels of detail");
        command.option("--ply FILE", options.ply, "write the convex pieces, one colour each");
        command.option("--level N", options.level, "of detail in that file; 0: the surface itself")
            .needs("--ply");
        command.example("hapt bake part.stl --unit mm");
      });
}

}  // namespace haptic
