// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <functional>
#include <string>
#include <vector>

#include "contact/bake/session.h"
#include "contact/shape/convex/piece_tree.h"
#include "proto/config/hand_config.h"
#include "proto/ipc/channels.h"
#include "proto/os/file_descriptor.h"

namespace haptic {

/// An eye file in sealed memory, as it is handed out.
struct SealedEye {
  SegmentId id;
  std::string name;
  FileDescriptor file;
};

/// The bytes of the eye file of one object, or of the tool (eye_of_tool): the mesh for display; of
/// the tool also the points of its voxel shell, at most 65,536 of them, evenly taken. A tool
/// without a mesh is a sphere: of the session's radius where the renderer moves a sphere, else of
/// kPointRadius. Throws EyeError.
std::vector<std::byte> make_eye(const SessionConfig& config, const BakedSession& baked,
                                uint32_t object);

/// The same of convex pieces: the hulls of the finest level that has at most 40,000 triangles; no
/// two share a vertex. Throws EyeError.
std::vector<std::byte> make_piece_eye(uint32_t object, const ShapeConfig& shape,
                                      const PieceTree& tree);

/// Those of the tool and of all objects, and of their convex pieces. One that cannot be made is
/// told and left out.
std::vector<SealedEye> make_eye_files(const SessionConfig& config, const BakedSession& baked,
                                      const std::function<void(const std::string&)>& tell);

}  // namespace haptic
