// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "proto/os/file_descriptor.h"

namespace haptic {

/// Opens a serial node for bytes as they are: raw, never blocking, not the controlling terminal,
/// without waiting for a modem, nothing old in its queues, for this program alone (an advisory lock
/// that goes with the last duplicate of the descriptor). A read of nothing gives EAGAIN, a read
/// after the device is gone 0 or an error. 115200 baud, which USB ignores. Throws
/// std::runtime_error in one line: what, why, how to mend it.
FileDescriptor open_serial_port(const std::string& path);

}  // namespace haptic
