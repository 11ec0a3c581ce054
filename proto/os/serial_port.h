// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "proto/os/file_descriptor.h"

namespace haptic {

/// Opens a serial node in raw, non-blocking mode: not as controlling terminal, ignoring modem
/// lines, queues flushed, exclusively (an advisory lock that ends with the last duplicate of the
/// descriptor). Reading nothing gives EAGAIN; after the device is gone a read gives 0 or an error.
/// 115200 baud, which USB ignores. Throws std::runtime_error in one line: what, why, how to mend
/// it.
FileDescriptor open_serial_port(const std::string& path);

}  // namespace haptic
