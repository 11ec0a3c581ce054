// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <fstream>
#include <string>

#include "proto/os/programs.h"
#include "tests/process/hapticd_process.h"

namespace haptic::test {

/// A folder of hapticd's child programs, some replaced by shell scripts; $HAPTICD_LIBEXEC points to
/// it during its lifetime.
class Programs {
 public:
  explicit Programs(const std::string& folder) : folder_(folder + "/programs") {
    std::filesystem::create_directory(folder_);
    for (const char* name : {"haptic-sim", "haptic-contact", "haptic-servo"}) {
      std::filesystem::create_symlink(program_folder() / name, folder_ + "/" + name);
    }
    setenv("HAPTICD_LIBEXEC", folder_.c_str(), 1);
  }
  ~Programs() { unsetenv("HAPTICD_LIBEXEC"); }
  Programs(const Programs&) = delete;

  void replace(const std::string& name, const std::string& script) const {
    const std::string path = folder_ + "/" + name;
    std::filesystem::remove(path);
    std::ofstream(path) << "#!/bin/sh\n" << script << "\n";
    std::filesystem::permissions(path, std::filesystem::perms::owner_all);
  }

 private:
  std::string folder_;
};

}  // namespace haptic::test
