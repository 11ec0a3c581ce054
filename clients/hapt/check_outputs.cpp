// SPDX-License-Identifier: GPL-3.0-or-later
#include "clients/hapt/check_outputs.h"

#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <stdexcept>

namespace haptic {
namespace {

namespace fs = std::filesystem;

bool same_file(const std::string& a, const std::string& b) {
  std::error_code error;
  return fs::weakly_canonical(a, error) == fs::weakly_canonical(b, error) ||
         fs::equivalent(a, b, error);
}

void check_output(const std::string& path, bool overwrite) {
  const auto refuse = [&](const std::string& why) { throw std::runtime_error(path + ": " + why); };
  std::error_code error;
  if (fs::is_directory(path, error)) refuse("is a folder; name a file in it");
  const bool there = fs::exists(path, error);
  // pipes and devices are written to, not replaced
  if (there && !overwrite && fs::is_regular_file(path, error)) {
    refuse("exists; choose another name or add --overwrite");
  }
  const fs::path parent = fs::path(path).parent_path();
  const std::string folder = parent.empty() ? "." : parent.string();
  if (access(there ? path.c_str() : folder.c_str(), W_OK) != 0) {
    refuse(std::string("cannot be written (") + std::strerror(errno) +
           "); check the folder and its rights");
  }
}

}  // namespace

void check_outputs(const std::vector<std::string>& outputs, const std::vector<std::string>& inputs,
                   bool overwrite) {
  for (size_t i = 0; i < outputs.size(); ++i) {
    if (outputs[i].empty()) continue;
    for (const std::string& input : inputs) {
      if (!input.empty() && same_file(outputs[i], input)) {
        throw std::runtime_error(outputs[i] + ": is read and would be overwritten; name another");
      }
    }
    for (size_t k = 0; k < i; ++k) {
      if (!outputs[k].empty() && same_file(outputs[i], outputs[k])) {
        throw std::runtime_error(outputs[i] + ": is to be written twice; name another");
      }
    }
    check_output(outputs[i], overwrite);
  }
}

}  // namespace haptic
