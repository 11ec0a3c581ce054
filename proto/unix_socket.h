// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <sys/un.h>

#include <string>

#include "proto/file_descriptor.h"

namespace haptic {

/// A socket of this machine that keeps messages apart and blocks nobody; not open where the kernel
/// has none left, with errno set.
FileDescriptor unix_socket();

/// The address of a path. Throws HandoutError where the kernel's 107 characters do not hold it.
sockaddr_un unix_address(const std::string& path);

/// Whether the socket is connected to what listens at the path; errno says why not.
bool connect_to(const FileDescriptor& socket, const std::string& path);

/// Puts the socket at the path, open to everybody, in the place of what was left there. False with
/// errno set.
bool listen_at(const FileDescriptor& socket, const std::string& path);

}  // namespace haptic
