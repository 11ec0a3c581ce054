// SPDX-License-Identifier: Apache-2.0
#include "proto/os/programs.h"

#include <filesystem>
#include <fstream>
#include <sstream>

#include "proto/os/environment.h"

namespace haptic {
namespace {

/// The fields of /proc/PID/stat after the name, which may itself contain brackets: state, parent
/// and so on. Empty: no such process.
std::string stat_of(pid_t pid) {
  std::ifstream file("/proc/" + std::to_string(pid) + "/stat");
  std::string text;
  std::getline(file, text);
  const size_t bracket = text.rfind(')');
  return bracket == std::string::npos || text.size() < bracket + 2 ? "" : text.substr(bracket + 2);
}

}  // namespace

std::string own_folder() {
  return std::filesystem::read_symlink("/proc/self/exe").parent_path().string();
}

std::string program_folder() {
  const std::string folder = environment("HAPTICD_LIBEXEC");
  return folder.empty() ? own_folder() : folder;
}

bool is_running(pid_t pid) {
  const std::string stat = stat_of(pid);
  return !stat.empty() && stat.front() != 'Z';
}

uint64_t start_time_of(pid_t pid) {
  constexpr int kFieldsBefore = 19;  // state … itrealvalue, proc(5)
  std::istringstream fields(stat_of(pid));
  std::string skipped;
  for (int i = 0; i < kFieldsBefore; ++i) fields >> skipped;
  uint64_t ticks = 0;
  fields >> ticks;
  return ticks;
}

}  // namespace haptic
