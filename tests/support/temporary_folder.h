// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdlib>
#include <filesystem>
#include <optional>
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

/// Sets an environment variable while it lives; without a value there is none.
class Environment {
 public:
  explicit Environment(const char* name) : name_(name) {
    if (const char* before = std::getenv(name)) before_ = before;
    unsetenv(name);
  }
  Environment(const char* name, const std::string& value) : Environment(name) {
    setenv(name, value.c_str(), 1);
  }
  ~Environment() { before_ ? setenv(name_, before_->c_str(), 1) : unsetenv(name_); }
  Environment(const Environment&) = delete;

 private:
  const char* name_;
  std::optional<std::string> before_;
};

/// A cache of its own for what this process bakes during its lifetime.
class TemporaryCache : public TemporaryFolder {
  Environment cache_{"HAPTICD_CACHE", path()};
};

/// The runtime folder for every session that this process starts or looks up during its lifetime.
class TemporaryRuntimeFolder : public TemporaryFolder {
  Environment folder_{"HAPTICD_RUNTIME_DIR", path()};
};

}  // namespace haptic::test
