// SPDX-License-Identifier: GPL-3.0-or-later
#include "clients/lab/torture/process_waits.h"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <string>
#include <system_error>

namespace haptic {
namespace {

std::string folder_of(pid_t pid) {
  return "/proc/" + std::to_string(pid);
}

/// Returns how long a thread has waited for a processor since its start [ns]; −1: unknown. The
/// folder of a process is that of its first thread.
int64_t read_time_waited(const std::string& folder) {
  int64_t ran_ns = 0, waited_ns = -1;
  std::ifstream(folder + "/schedstat") >> ran_ns >> waited_ns;
  return waited_ns;
}

/// Returns the sum of that over all threads of a process; −1: unknown.
int64_t read_time_threads_waited(const std::string& folder) {
  namespace fs = std::filesystem;
  int64_t sum_ns = -1;
  // a process may end while it is looked at
  std::error_code gone;
  const fs::directory_iterator end;
  for (fs::directory_iterator thread(folder + "/task", gone); !gone && thread != end;
       thread.increment(gone)) {
    const int64_t waited_ns = read_time_waited(thread->path());
    if (waited_ns >= 0) sum_ns = std::max<int64_t>(sum_ns, 0) + waited_ns;
  }
  return sum_ns;
}

bool is_stopped(const std::string& folder) {
  std::string line;
  std::getline(std::ifstream(folder + "/stat"), line);
  // after the process name, which may contain anything
  const size_t name_end = line.rfind(") ");
  return name_end != std::string::npos && line[name_end + 2] == 'T';
}

}  // namespace

int64_t time_waited(pid_t pid) {
  return std::max<int64_t>(0, read_time_waited(folder_of(pid)));
}

void ProcessWaits::look(int64_t t_ns) {
  const std::string folder = folder_of(pid_);
  const int64_t waited_ns = read_time_threads_waited(folder);
  if (waited_ns < 0) return;
  if (looked_ns_ != 0) {
    const int64_t longest_ns = t_ns - looked_ns_;
    const int64_t lost_ns =
        is_stopped(folder) ? longest_ns : std::min(waited_ns - waited_ns_, longest_ns);
    if (lost_ns > 0) stalls_.push_back({t_ns - lost_ns, t_ns});
  }
  looked_ns_ = t_ns;
  waited_ns_ = waited_ns;
}

std::vector<Stall> ProcessWaits::stalls(int64_t since_ns) const {
  return stalls_since(stalls_, since_ns);
}

}  // namespace haptic
