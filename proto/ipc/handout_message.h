// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>

#include "proto/config/config_names.h"
#include "proto/ipc/channels.h"
#include "proto/os/file_descriptor.h"

/// The messages between hapticd and its peers: announcements with one descriptor, refusals without.
namespace haptic {

/// A segment as announced over a socket, together with its descriptor. A repeated pair (id,
/// generation) means the same segment.
struct Announcement {
  uint32_t protocol;  // kHandoutProtocol
  SegmentId id;
  uint64_t generation;
  Name name;
};
inline constexpr uint32_t kHandoutProtocol = 1;  // raise it when an announcement changes

/// An announcement of this protocol.
Announcement make_announcement(SegmentId id, uint64_t generation, const char* name);

/// One announcement with its descriptor. Never blocks; false: it was not sent.
bool send_announcement(int socket, const Announcement& announcement, int fd);

/// For children: gives its segment to hapticd. Throws HandoutError.
void offer_segment(int socket, SegmentId id, uint64_t generation, const char* name, int fd);

/// Tells a client why it is refused, before the server hangs up. Cut at 255 bytes.
void send_refusal(int socket, const std::string& why);

enum class Received { kMessage, kRefusal, kNothing, kBroken };

/// One message of a peer, which may send anything.
struct ReceivedMessage {
  Received kind = Received::kBroken;
  Announcement announcement{};
  FileDescriptor fd;
  std::string why;  // of a refusal
};

/// Takes the next message, if there is one. Closes all descriptors that came with it, except that
/// of a valid announcement.
ReceivedMessage receive_message(int socket);

}  // namespace haptic
