// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>

namespace haptic {

/// A file mapped read-only; it lives as long as `storage`.
struct MappedFile {
  std::span<const std::byte> bytes;
  std::shared_ptr<const void> storage;
};

/// Maps a file; an empty file has no bytes and no storage. Throws std::runtime_error with the
/// system's reason.
MappedFile map_file(const std::string& path);

/// Maps a file of the cache: only one that this user (or root) owns and nobody else may write is
/// believed, and no link is followed. Throws std::runtime_error with the reason.
MappedFile map_cached(const std::string& path);

/// Where the shape with this key is kept.
std::string cache_path(uint64_t key);

/// Writes a file under a temporary name that nobody can guess and renames it, so that nobody ever
/// maps half of one and nothing is written through a link. The folder is made where it is missing;
/// one that belongs to another user, or that others may write, is not used. Returns what went
/// wrong, empty for success.
std::string write_atomically(const std::string& path, std::span<const std::byte> bytes);

/// What people are told of a cache file that was not used, and of a folder that refuses one.
std::string unusable_cache(const std::string& path, const std::string& why);
std::string unwritable_cache(const std::string& why);

}  // namespace haptic
