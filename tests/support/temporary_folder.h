// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdlib>
#include <filesystem>
#include <stdexcept>
#include <string>

namespace haptic::test {

/// A folder under /tmp that is deleted with its owner.
class TemporaryFolder {
 public:
  TemporaryFolder() {
    char name[] = "/tmp/haptic-test-XXXXXX";
    if (mkdtemp(name) == nullptr) throw std::runtime_error("cannot make a folder in /tmp");
    path_ = name;
  }
  ~TemporaryFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  TemporaryFolder(const TemporaryFolder&) = delete;
  const std::string& path() const { return path_; }

 private:
  std::string path_;
};

/// The runtime folder for every session that this process starts or looks up during its lifetime.
class TemporaryRuntimeFolder : public TemporaryFolder {
 public:
  TemporaryRuntimeFolder() { setenv("HAPTICD_RUNTIME_DIR", path().c_str(), 1); }
  ~TemporaryRuntimeFolder() { unsetenv("HAPTICD_RUNTIME_DIR"); }
};

}  // namespace haptic::test
