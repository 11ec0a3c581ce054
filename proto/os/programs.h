// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <sys/types.h>

#include <cstdint>
#include <string>

namespace haptic {

/// Folder that this program lies in.
std::string own_folder();

/// Folder of the programs: $HAPTICD_LIBEXEC, else that of this one.
std::string program_folder();

/// Whether a process of that number exists and has not ended; one that waits to be reaped has.
bool is_running(pid_t pid);

/// When a process began, in the kernel's ticks since the machine started; 0: there is none. With
/// the pid it names a process for good: numbers are given again.
uint64_t start_time_of(pid_t pid);

}  // namespace haptic
