// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdlib>
#include <filesystem>
#include <stdexcept>
#include <string>
#include <system_error>

namespace haptic {

/// A private folder in the temporary folder, removed at the end unless it is to be kept.
class ScratchFolder {
 public:
  /// Throws std::runtime_error with one line.
  explicit ScratchFolder(bool keep = false) : keep_(keep) {
    if (mkdtemp(path_.data()) == nullptr) {
      throw std::runtime_error(path_ + ": cannot be made; set TMPDIR to a folder of yours");
    }
  }
  ~ScratchFolder() {
    std::error_code ignored;
    if (!keep_) std::filesystem::remove_all(path_, ignored);
  }
  ScratchFolder(const ScratchFolder&) = delete;
  const std::string& path() const { return path_; }

 private:
  std::string path_ = (std::filesystem::temp_directory_path() / "hapt-XXXXXX").string();
  bool keep_;
};

}  // namespace haptic
