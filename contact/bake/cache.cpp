// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/bake/cache.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <sstream>
#include <stdexcept>
#include <system_error>

#include "contact/shape/baked/block.h"
#include "proto/os/environment.h"
#include "proto/os/file_descriptor.h"
#include "proto/os/realtime.h"
#include "proto/os/regular_file.h"

namespace haptic {
namespace {

namespace fs = std::filesystem;

}  // namespace

std::string cache_folder() {
  if (std::string own = environment("HAPTICD_CACHE"); !own.empty()) return own;
  if (const std::string xdg = environment("XDG_CACHE_HOME"); !xdg.empty()) return xdg + "/hapticd";
  if (const std::string home = environment("HOME"); !home.empty()) return home + "/.cache/hapticd";
  // root is a service: a known name in /tmp may belong to anybody
  return geteuid() == 0
             ? "/var/cache/hapticd"
             : fs::temp_directory_path() / ("hapticd-cache-" + std::to_string(geteuid()));
}

uint64_t mesh_key(const TriangleMesh& mesh, std::string_view what) {
  const uint64_t seed = hash_bytes(std::as_bytes(std::span(what)), kBakeVersion);
  return hash_bytes(std::as_bytes(mesh.triangles), hash_bytes(std::as_bytes(mesh.vertices), seed));
}

std::string cache_path(uint64_t key) {
  std::ostringstream name;
  name << cache_folder() << "/" << std::hex << key << ".baked";
  return name.str();
}

namespace {

/// Why a file or folder is not trusted; empty: it is.
std::string distrust(const struct stat& status) {
  if (status.st_uid != geteuid() && status.st_uid != 0) {
    return "it belongs to user " + std::to_string(status.st_uid);
  }
  return (status.st_mode & 022) != 0 ? "others may write it" : "";
}

std::string distrust_folder(const std::string& folder) {
  struct stat name {
  }, status{};
  if (lstat(folder.c_str(), &name) != 0 || stat(folder.c_str(), &status) != 0) {
    return std::strerror(errno);
  }
  const bool is_own = name.st_uid == geteuid() || name.st_uid == 0;
  if (S_ISLNK(name.st_mode) && !is_own) return "it is a link of another user";
  return S_ISDIR(status.st_mode) ? distrust(status) : "it is no folder";
}

}  // namespace

MappedFile map_cached(const std::string& path) {
  const FileDescriptor file(open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK));
  struct stat status {};
  if (!file.is_open() || fstat(file.get(), &status) != 0) {
    throw std::runtime_error(std::strerror(errno));
  }
  if (!S_ISREG(status.st_mode)) throw std::runtime_error("it is no file");
  if (const std::string why = distrust(status); !why.empty()) throw std::runtime_error(why);
  if (status.st_size == 0) return {};
  return map_descriptor(file);
}

std::string write_atomically(const std::string& path, std::span<const std::byte> bytes) {
  const fs::path folder = fs::path(path).parent_path();
  std::error_code error;
  if (fs::create_directories(folder, error)) {
    fs::permissions(folder, fs::perms::owner_all, error);
  }
  if (error) return error.message();
  if (const std::string why = distrust_folder(folder); !why.empty()) return why;
  std::string temporary = path + ".XXXXXX";
  const FileDescriptor file(mkostemp(temporary.data(), O_CLOEXEC));
  if (!file.is_open()) return std::string("cannot write there: ") + std::strerror(errno);
  if (write_all(file.get(), bytes) && rename(temporary.c_str(), path.c_str()) == 0) return {};
  std::string reason = std::strerror(errno);
  unlink(temporary.c_str());
  return reason;
}

namespace {

std::atomic<bool> makes_apart{false};

/// Puts the bytes into the cache and maps them there, where every process shares them. Where the
/// cache refuses them, they are returned as they are, and `use` says so.
MappedFile keep_cached(const std::string& path, const MappedFile& made, CacheUse& use) {
  std::string refused = write_atomically(path, made.bytes);
  try {
    if (refused.empty()) return map_cached(path);
  } catch (const std::runtime_error& error) {
    refused = error.what();
  }
  use.lines.push_back("cache folder " + cache_folder() + " cannot be used (" + refused +
                      "): baked at every start; set HAPTICD_CACHE");
  return made;
}

}  // namespace

void bake_apart() noexcept {
  makes_apart.store(true);
}

CacheUse use_cached(uint64_t key, const std::function<void(const MappedFile&)>& take,
                    const ByteMaker& make) {
  const std::string path = cache_path(key);
  CacheUse use;
  if (std::error_code error; fs::exists(path, error)) {
    try {
      take(map_cached(path));
      use.from_cache = true;
      return use;
    } catch (const std::runtime_error& refusal) {
      use.lines.push_back("cache " + path + " was unusable (" + refusal.what() + "): baked again");
    }
  }
  const int64_t start_ns = now_ns();
  const MappedFile made = makes_apart.load() ? make_apart(make) : make_here(make);
  use.make_time = 1e-9 * static_cast<double>(now_ns() - start_ns);
  take(keep_cached(path, made, use));
  return use;
}

}  // namespace haptic
