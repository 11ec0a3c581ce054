// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <sys/types.h>

#include <string>
#include <vector>

#include "proto/ipc/unix_socket.h"

/// Where sessions are found. hapticd listens on `<runtime folder>/<session>.sock`.
namespace haptic {

inline constexpr const char* kSystemFolder = "/run/hapticd";

/// Folder of this user's sessions: $HAPTICD_RUNTIME_DIR, else $XDG_RUNTIME_DIR/hapticd, else
/// /run/hapticd (root), else /tmp/hapticd-<uid>.
std::string runtime_folder();

/// Names of the sessions this user can reach and that answer now.
std::vector<std::string> running_sessions();

/// Throws HandoutError if a session cannot have that name.
void check_session_name(const std::string& session);

/// Path of the socket of a running session; empty name: the only one. Does not wait for a place in
/// its queue. Throws as connect_session.
std::string find_session(const std::string& session);

/// Connects to a running session; empty name: the only one. Throws HandoutError, which lists the
/// running sessions and says how to start one.
FileDescriptor connect_session(const std::string& session);

/// The other end of a connection to a session.
struct SessionPeer {
  std::string folder, session;
  pid_t hapticd = -1;
};
SessionPeer peer_of(const FileDescriptor& socket);

}  // namespace haptic
