// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/bake_cache.h"

#include <unistd.h>

#include <boost/interprocess/file_mapping.hpp>
#include <boost/interprocess/mapped_region.hpp>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <stdexcept>
#include <system_error>

#include "contact/bake.h"

#include "proto/environment.h"

namespace haptic {
namespace {

namespace fs = std::filesystem;
namespace ipc = boost::interprocess;

}  // namespace

std::string cache_folder() {
  if (std::string own = environment("HAPTICD_CACHE"); !own.empty()) return own;
  if (const std::string xdg = environment("XDG_CACHE_HOME"); !xdg.empty()) return xdg + "/hapticd";
  const std::string home = environment("HOME");
  return (home.empty() ? fs::temp_directory_path().string() : home + "/.cache") + "/hapticd";
}

std::string cache_path(uint64_t key) {
  std::ostringstream name;
  name << cache_folder() << "/" << std::hex << key << ".baked";
  return name.str();
}

MappedFile map_file(const std::string& path) {
  std::error_code error;
  const auto size = fs::file_size(path, error);
  if (error) throw std::runtime_error(error.message());
  if (size == 0) return {};
  try {
    const ipc::file_mapping file(path.c_str(), ipc::read_only);
    const auto region = std::make_shared<ipc::mapped_region>(file, ipc::read_only);
    return {{static_cast<const std::byte*>(region->get_address()), region->get_size()}, region};
  } catch (const ipc::interprocess_exception& refused) {
    throw std::runtime_error(refused.what());
  }
}

std::string write_atomically(const std::string& path, std::span<const std::byte> bytes) {
  std::error_code error;
  fs::create_directories(fs::path(path).parent_path(), error);
  if (error) return error.message();
  // one name per process: two that bake the same mesh do not meet
  const std::string temporary = path + "." + std::to_string(::getpid()) + ".tmp";
  {
    std::ofstream out(temporary, std::ios::binary);
    out.write(reinterpret_cast<const char*>(bytes.data()),
              static_cast<std::streamsize>(bytes.size()));
    out.close();
    if (!out) {
      fs::remove(temporary, error);
      return "cannot write " + temporary;
    }
  }
  fs::rename(temporary, path, error);
  if (!error) return {};
  std::string reason = error.message();
  fs::remove(temporary, error);
  return reason;
}

std::string unusable_cache(const std::string& path, const std::string& why) {
  return "cache " + path + " was unusable (" + why + "): baked again";
}

std::string unwritable_cache(const std::string& why) {
  return "cache folder " + cache_folder() + " cannot be written (" + why +
         "): baked at every start; set HAPTICD_CACHE";
}

}  // namespace haptic
