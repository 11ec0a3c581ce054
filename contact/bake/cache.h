// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "contact/bake/mapped_file.h"
#include "contact/shape/mesh/triangle_mesh.h"

namespace haptic {

/// Maps a file of the cache: only if this user (or root) owns it and nobody else may write it;
/// symbolic links are not followed. Throws std::runtime_error with the reason.
MappedFile map_cached(const std::string& path);

/// Returns the key under which the cache keeps what is made of a mesh; `what` names all options
/// that it is made with.
uint64_t mesh_key(const TriangleMesh& mesh, std::string_view what);

std::string cache_path(uint64_t key);

/// Writes a file under an unpredictable temporary name and renames it, so that nobody maps a
/// partial file and nothing is written through a link. Creates the folder if it is missing; one
/// that belongs to another user, or that others may write, is not used. Returns the error, empty
/// for success.
std::string write_atomically(const std::string& path, std::span<const std::byte> bytes);

/// How use_cached came by its bytes.
struct CacheUse {
  bool from_cache = false;
  double make_time = 0;            // of `make` in this run [s]
  std::vector<std::string> lines;  // about an unusable file and an unwritable folder, for people
};

/// Gives the bytes of this key to `take`: those of the cache, else, or where `take` throws a
/// std::runtime_error, those that `make` returns, which are then cached. `take` must not throw for
/// these.
CacheUse use_cached(uint64_t key, const std::function<void(const MappedFile&)>& take,
                    const ByteMaker& make);

/// From here on use_cached() lets `make` run apart (make_apart), and what `make` keeps beside its
/// bytes is lost: for a process that locks its memory, which would hold all that baking has freed.
/// Call it once, at the start.
void bake_apart() noexcept;

}  // namespace haptic
