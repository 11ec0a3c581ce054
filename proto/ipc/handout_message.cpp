// SPDX-License-Identifier: Apache-2.0
#include "proto/ipc/handout_message.h"

#include <sys/socket.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <vector>

#include "proto/ipc/unix_socket.h"
#include "proto/math/assert.h"

namespace haptic {
namespace {

constexpr size_t kLongestRefusal = 256;  // [bytes]

/// Sent instead of an announcement, without a descriptor, before the server hangs up.
struct Refusal {
  uint32_t protocol = kHandoutProtocol;
  std::array<char, kLongestRefusal> why{};
};
static_assert(sizeof(Refusal) != sizeof(Announcement));

/// Takes all descriptors of a message, so that none stays open; returns the only one, if there is
/// just one.
FileDescriptor only_descriptor(msghdr& message) {
  std::vector<FileDescriptor> received;
  for (cmsghdr* part = CMSG_FIRSTHDR(&message); part != nullptr;
       part = CMSG_NXTHDR(&message, part)) {
    if (part->cmsg_level != SOL_SOCKET || part->cmsg_type != SCM_RIGHTS) continue;
    for (size_t at = 0; CMSG_LEN(at + sizeof(int)) <= part->cmsg_len; at += sizeof(int)) {
      int fd = -1;
      std::memcpy(&fd, CMSG_DATA(part) + at, sizeof fd);
      received.emplace_back(fd);
    }
  }
  return received.size() == 1 ? std::move(received.front()) : FileDescriptor{};
}

}  // namespace

Announcement make_announcement(SegmentId id, uint64_t generation, const char* name) {
  Announcement announcement{kHandoutProtocol, id, generation, {}};
  assign(announcement.name, name);
  return announcement;
}

bool send_announcement(int socket, const Announcement& announcement, int fd) {
  iovec data{const_cast<Announcement*>(&announcement), sizeof announcement};
  alignas(cmsghdr) char control[CMSG_SPACE(sizeof(int))] = {};
  msghdr message{};
  message.msg_iov = &data;
  message.msg_iovlen = 1;
  message.msg_control = control;
  message.msg_controllen = sizeof control;
  cmsghdr* part = CMSG_FIRSTHDR(&message);
  HAPTIC_ASSERT(part != nullptr);
  part->cmsg_level = SOL_SOCKET;
  part->cmsg_type = SCM_RIGHTS;
  part->cmsg_len = CMSG_LEN(sizeof(int));
  std::memcpy(CMSG_DATA(part), &fd, sizeof fd);
  return sendmsg(socket, &message, MSG_DONTWAIT | MSG_NOSIGNAL) == sizeof announcement;
}

void offer_segment(int socket, SegmentId id, uint64_t generation, const char* name, int fd) {
  HAPTIC_ASSERT(name != nullptr && fd >= 0);
  if (!send_announcement(socket, make_announcement(id, generation, name), fd)) {
    throw_errno(std::string("cannot offer segment '") + name + "' to hapticd");
  }
}

void send_refusal(int socket, const std::string& why) {
  Refusal refusal;
  assign(refusal.why, why.substr(0, kLongestRefusal - 1));
  send(socket, &refusal, sizeof refusal, MSG_DONTWAIT | MSG_NOSIGNAL);
}

ReceivedMessage receive_message(int socket) {
  alignas(Refusal) std::array<char, std::max(sizeof(Refusal), sizeof(Announcement))> bytes;
  iovec data{bytes.data(), bytes.size()};
  // the kernel may fill in two descriptors, since it rounds the room up: each one is closed
  alignas(cmsghdr) char control[CMSG_SPACE(2 * sizeof(int))] = {};
  msghdr message{};
  message.msg_iov = &data;
  message.msg_iovlen = 1;
  message.msg_control = control;
  message.msg_controllen = sizeof control;
  const ssize_t n = recvmsg(socket, &message, MSG_DONTWAIT | MSG_CMSG_CLOEXEC);
  ReceivedMessage out;
  if (n < 0) {
    if (errno == EAGAIN || errno == EINTR) out.kind = Received::kNothing;
    return out;
  }
  out.fd = only_descriptor(message);
  uint32_t protocol = 0;
  std::memcpy(&protocol, bytes.data(), sizeof protocol);
  const bool cut = (message.msg_flags & (MSG_TRUNC | MSG_CTRUNC)) != 0;
  if (cut || static_cast<size_t>(n) < sizeof protocol || protocol != kHandoutProtocol) return out;
  if (n == sizeof(Announcement) && out.fd.is_open()) {
    std::memcpy(&out.announcement, bytes.data(), sizeof out.announcement);
    out.announcement.name.back() = '\0';
    out.kind = Received::kMessage;
  } else if (n == sizeof(Refusal) && !out.fd.is_open()) {
    Refusal refusal;
    std::memcpy(&refusal, bytes.data(), sizeof refusal);
    refusal.why.back() = '\0';
    out.why = refusal.why.data();
    out.kind = Received::kRefusal;
  }
  return out;
}

}  // namespace haptic
