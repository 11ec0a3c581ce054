// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <sys/types.h>

#include <catch2/catch.hpp>
#include <filesystem>
#include <fstream>
#include <set>
#include <sstream>
#include <string>

namespace haptic::test {

/// Inodes of all internet sockets on this machine.
inline std::set<std::string> network_sockets() {
  std::set<std::string> inodes;
  for (const char* table : {"tcp", "tcp6", "udp", "udp6", "raw", "raw6"}) {
    std::ifstream file(std::string("/proc/net/") + table);
    std::string line;
    std::getline(file, line);
    while (std::getline(file, line)) {
      std::istringstream words(line);
      std::string word;
      for (int i = 0; i < 10; ++i) words >> word;
      inodes.insert("socket:[" + word + "]");
    }
  }
  return inodes;
}

/// Whether a process has such a socket open.
inline bool is_on_a_network(pid_t pid) {
  const auto sockets = network_sockets();
  const std::string folder = "/proc/" + std::to_string(pid) + "/fd";
  size_t looked_at = 0;
  std::error_code ended;
  for (const auto& entry : std::filesystem::directory_iterator(folder, ended)) {
    std::error_code gone;
    const std::string target = std::filesystem::read_symlink(entry.path(), gone).string();
    if (sockets.count(target) != 0) return true;
    ++looked_at;
  }
  // a process that was replaced in the meantime has none
  if (!ended) REQUIRE(looked_at > 3);
  return false;
}

}  // namespace haptic::test
