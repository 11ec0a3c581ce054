// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <sys/types.h>

#include <cstdint>
#include <string>

namespace haptic {

/// Folder of this program.
std::string own_folder();

/// Folder of the programs: $HAPTICD_LIBEXEC, else the folder of this program.
std::string program_folder();

/// True if a process with that pid exists and has not ended; a zombie has.
bool is_running(pid_t pid);

/// Start of a process in the kernel's ticks since boot; 0: no such process. Together with the pid
/// it identifies a process, since pids are reused.
uint64_t start_time_of(pid_t pid);

}  // namespace haptic
