// SPDX-License-Identifier: GPL-3.0-or-later
#include "clients/view/web/places.h"

#include <arpa/inet.h>
#include <linux/inet_diag.h>
#include <linux/netlink.h>
#include <linux/sock_diag.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <sys/socket.h>

#include <array>
#include <cstring>
#include <optional>

#include "proto/os/file_descriptor.h"

namespace haptic {
namespace {

/// An end of a connection: address and port in network order.
struct End {
  int family = AF_UNSPEC;
  std::array<uint32_t, 4> address{};  // of IPv4 the first
  uint16_t port = 0;
};

/// Which end a function of the kernel gives: getsockname() ours, getpeername() the other.
End end_of(int socket, int (*name)(int, sockaddr*, socklen_t*)) {
  sockaddr_storage storage{};
  socklen_t size = sizeof storage;
  End end;
  if (name(socket, reinterpret_cast<sockaddr*>(&storage), &size) != 0) return end;
  end.family = storage.ss_family;
  if (end.family == AF_INET) {
    sockaddr_in v4{};
    std::memcpy(&v4, &storage, sizeof v4);
    end.address[0] = v4.sin_addr.s_addr;
    end.port = v4.sin_port;
  } else if (end.family == AF_INET6) {
    sockaddr_in6 v6{};
    std::memcpy(&v6, &storage, sizeof v6);
    std::memcpy(end.address.data(), &v6.sin6_addr, sizeof end.address);
    end.port = v6.sin6_port;
  }
  return end;
}

struct Question {
  nlmsghdr header{};
  inet_diag_req_v2 request{};
};

Question question_of(const End& local, const End& remote) {
  Question question;
  question.header.nlmsg_len = sizeof question;
  question.header.nlmsg_type = SOCK_DIAG_BY_FAMILY;
  question.header.nlmsg_flags = NLM_F_REQUEST;
  inet_diag_req_v2& request = question.request;
  request.sdiag_family = static_cast<uint8_t>(local.family);
  request.sdiag_protocol = IPPROTO_TCP;
  request.idiag_states = 1U << TCP_ESTABLISHED;
  request.id.idiag_sport = local.port;
  request.id.idiag_dport = remote.port;
  std::memcpy(request.id.idiag_src, local.address.data(), sizeof request.id.idiag_src);
  std::memcpy(request.id.idiag_dst, remote.address.data(), sizeof request.id.idiag_dst);
  request.id.idiag_cookie[0] = request.id.idiag_cookie[1] = INET_DIAG_NOCOOKIE;
  return question;
}

/// The user whose socket of this machine has these ends; the kernel answers at once.
std::optional<uint32_t> user_of(const End& local, const End& remote) {
  const FileDescriptor kernel(socket(AF_NETLINK, SOCK_RAW | SOCK_CLOEXEC, NETLINK_SOCK_DIAG));
  const Question question = question_of(local, remote);
  if (send(kernel.get(), &question, sizeof question, 0) != sizeof question) return std::nullopt;
  std::array<char, 4096> bytes{};
  struct {
    nlmsghdr header;
    inet_diag_msg found;
  } answer{};
  const ssize_t n = recv(kernel.get(), bytes.data(), bytes.size(), MSG_DONTWAIT);
  if (n < static_cast<ssize_t>(sizeof answer)) return std::nullopt;
  std::memcpy(&answer, bytes.data(), sizeof answer);
  // a socket that listens at that port is not the one; one without a process has no user
  const bool is_it = answer.header.nlmsg_type == SOCK_DIAG_BY_FAMILY &&
                     answer.found.idiag_state == TCP_ESTABLISHED;
  return is_it ? std::optional(answer.found.idiag_uid) : std::nullopt;
}

}  // namespace

std::string person_behind(int socket) {
  const End remote = end_of(socket, getpeername);
  if (const auto user = user_of(remote, end_of(socket, getsockname))) {
    return "user " + std::to_string(*user);
  }
  std::array<uint32_t, 4> network = remote.address;
  if (remote.family == AF_INET6) network[2] = network[3] = 0;
  std::array<char, INET6_ADDRSTRLEN> text{};
  const bool is_named =
      inet_ntop(remote.family, network.data(), text.data(), text.size()) != nullptr;
  return is_named ? text.data() : "nobody";
}

std::shared_ptr<void> Places::take(const std::string& person) {
  if (taken_ >= most_) return nullptr;
  size_t& of_one = of_[person];
  if (of_one >= most_of_one_) return nullptr;
  ++of_one;
  ++taken_;
  return {this, [this, person](void*) { leave(person); }};
}

void Places::leave(const std::string& person) {
  --taken_;
  const auto one = of_.find(person);
  if (--one->second == 0) of_.erase(one);
}

}  // namespace haptic
