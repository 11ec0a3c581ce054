// SPDX-License-Identifier: GPL-3.0-or-later
#include "servo/hapticd/giving/give_server.h"

#include <pwd.h>
#include <sys/epoll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <utility>
#include <vector>

#include "proto/ipc/segment.h"
#include "proto/ipc/sessions.h"
#include "proto/os/message.h"
#include "proto/os/realtime.h"

namespace haptic {
namespace {

constexpr size_t kMostPeers = 2 * kMostClients;  // connected at once
constexpr int kMostAccepted = 16;                // per turn
constexpr uint64_t kDoor = 0;                    // number of the listener; peers count from 1
constexpr int64_t kPatienceNs = kNsPerSecond;    // for a step of coming
constexpr int64_t kRestNs = kNsPerSecond;        // between two segments of a name

void tell(int socket, const std::string& text) {
  // a peer that does not read is dropped when its patience is over
  static_cast<void>(send(socket, text.data(), text.size(), MSG_DONTWAIT | MSG_NOSIGNAL));
}

/// The number of the user of that name. Throws HandoutError.
uid_t user_named(std::string_view name) {
  const passwd* user = getpwnam(std::string(name).c_str());
  if (user != nullptr) return user->pw_uid;
  throw HandoutError("a [[client]] names the user '" + shown(name) +
                     "', who is unknown here; see 'getent passwd'");
}

bool any_user(const SessionConfig& config) {
  return std::any_of(config.clients.begin(), config.clients.begin() + config.n_clients,
                     [](const ClientConfig& client) { return client.user[0] != 0; });
}

}  // namespace

GiveServer::GiveServer(const std::string& session, const SessionConfig& config)
    : config_(config),
      listener_(runtime_folder() + "/" + session + kGiveSuffix, any_user(config) ? 0666 : 0600),
      epoll_(epoll_create1(EPOLL_CLOEXEC)) {
  for (uint32_t c = 0; c < config.n_clients; ++c) {
    const std::string_view name = view(config.clients[c].user);
    if (!name.empty()) users_[c] = user_named(name);
  }
  wait_for_peers();
}

void GiveServer::wait_for_peers() {
  epoll_event event{EPOLLIN, {.u64 = kDoor}};
  if (epoll_ctl(epoll_.get(), EPOLL_CTL_ADD, listener_.fd(), &event) != 0) {
    throw_errno("cannot wait for clients that give");
  }
}

void GiveServer::restore() {
  if (listener_.is_in_place()) return;
  listener_.listen_again();
  wait_for_peers();
}

bool GiveServer::is_known(uid_t user) const {
  return user == 0 || user == geteuid() ||
         std::ranges::any_of(users_, [&](const auto& known) { return known == user; });
}

bool GiveServer::accept_peer(int64_t t_ns) {
  std::optional<FileDescriptor> socket = listener_.accept();
  if (!socket || !socket->is_open()) return socket.has_value();
  Peer peer{.socket = std::move(*socket)};
  ucred who{};
  socklen_t size = sizeof who;
  if (getsockopt(peer.socket.get(), SOL_SOCKET, SO_PEERCRED, &who, &size) != 0) return true;
  peer.pid = who.pid;
  peer.user = who.uid;
  peer.since_ns = t_ns;
  // strangers take no place, however often they come
  if (!is_known(peer.user)) {
    tell(peer.socket.get(), "user " + std::to_string(peer.user) +
                                " may not give to this session; name the user in a [[client]]");
    return true;
  }
  if (peers_.size() >= kMostPeers) {
    tell(peer.socket.get(), "too many clients want to give at once; try again later");
    return true;
  }
  epoll_event event{EPOLLIN, {.u64 = next_peer_}};
  if (epoll_ctl(epoll_.get(), EPOLL_CTL_ADD, peer.socket.get(), &event) == 0) {
    peers_.emplace(next_peer_++, std::move(peer));
  }
  return true;
}

std::string GiveServer::refusal_of(const Peer& peer, std::optional<uint32_t> client,
                                   std::string_view name, int64_t t_ns) const {
  if (!client) {
    std::vector<std::string_view> known;
    for (uint32_t c = 0; c < config_.n_clients; ++c) known.push_back(view(config_.clients[c].name));
    return "no [[client]] of this session is called '" + shown(name) + "'; " +
           suggestion(name, known);
  }
  const bool may = peer.user == 0 || peer.user == geteuid() || peer.user == users_[*client];
  if (!may) {
    return "user " + std::to_string(peer.user) + " may not give as '" + shown(name) +
           "'; name the user in its [[client]]";
  }
  if (seats_[*client].is_taken) {
    return "'" + shown(name) + "' gives already, process " + std::to_string(seats_[*client].pid) +
           "; end it first";
  }
  if (told_ns_[*client] != 0 && t_ns - told_ns_[*client] < kRestNs) {
    return std::string(kTooSoon) + "'" + shown(name) + "' has just given; wait a second";
  }
  return "";
}

bool GiveServer::take_name(Peer& peer, int64_t t_ns) {
  std::array<char, sizeof(Name)> text;
  const ssize_t size = recv(peer.socket.get(), text.data(), text.size(), MSG_DONTWAIT | MSG_TRUNC);
  if (size <= 0 || size >= static_cast<ssize_t>(text.size())) return false;
  const std::string_view name(text.data(), static_cast<size_t>(size));
  std::optional<uint32_t> client;
  for (uint32_t c = 0; c < config_.n_clients; ++c) {
    if (view(config_.clients[c].name) == name) client = c;
  }
  const std::string why = refusal_of(peer, client, name, t_ns);
  if (!why.empty()) {
    tell(peer.socket.get(), why);
    return false;
  }
  peer.client = *client;
  peer.step = Step::kNamed;
  peer.since_ns = told_ns_[*client] = t_ns;
  seats_[*client] = {true, false, peer.pid, peer.user};
  const ClientConfig& known = config_.clients[*client];
  GivePlace place{*client, ++generations_[*client], known.may, {}};
  for (uint32_t i = 0; i < known.n_moves; ++i) {
    place.moves.push_back(
        {known.moves[i], std::string(view(config_.objects[known.moves[i]].name))});
  }
  tell(peer.socket.get(), text_of(place));
  return true;
}

bool GiveServer::take_segment(Peer& peer, int64_t t_ns, const Handlers& handlers) {
  const ReceivedMessage message = receive_message(peer.socket.get());
  if (message.kind == Received::kNothing) return true;
  const ClientConfig& client = config_.clients[peer.client];
  const std::string name(view(client.name));
  const bool draws = peer.step == Step::kGives;
  if (draws && message.kind == Received::kMessage && (client.may & kMayDraw) == 0) {
    tell(peer.socket.get(), "'" + name + "' may not draw; add \"draw\" to may of its [[client]]");
    return false;
  }
  const SegmentSpec spec =
      draws ? segment_spec<DrawChannels>(peer.client) : segment_spec<ClientChannels>(peer.client);
  const uint64_t generation = generations_[peer.client];
  if (message.kind != Received::kMessage || message.announcement.generation != generation ||
      message.announcement.id != spec.id) {
    tell(peer.socket.get(), "this is not the segment that was asked for");
    return false;
  }
  try {
    check_given_segment(message.fd.get(), spec, generation);
    handlers.on_offer(make_announcement(spec.id, generation, spec.name), message.fd.get());
  } catch (const SegmentError& error) {
    tell(peer.socket.get(), error.what());
    handlers.say("client '" + name + "' is refused: " + error.what());
    return false;
  }
  peer.step = draws ? Step::kDraws : Step::kGives;
  peer.since_ns = t_ns;
  seats_[peer.client].gives = true;
  tell(peer.socket.get(), "ok");
  handlers.say("client '" + name + (draws ? "' draws" : "' gives") + ", pid " +
               std::to_string(peer.pid));
  return true;
}

bool GiveServer::hear(Peer& peer, int64_t t_ns, const Handlers& handlers) {
  switch (peer.step) {
    case Step::kConnected:
      return take_name(peer, t_ns);
    case Step::kNamed:
    case Step::kGives:
      return take_segment(peer, t_ns, handlers);
    case Step::kDraws:
      // it has nothing more to say: a message, as its end, ends the connection
      return false;
  }
  return false;
}

void GiveServer::drop(uint64_t number, const Handlers& handlers) {
  const Peer& peer = peers_.at(number);
  if (peer.step != Step::kConnected) {
    if (seats_[peer.client].gives) {
      const std::string name(view(config_.clients[peer.client].name));
      handlers.say("client '" + name + "' has left");
    }
    seats_[peer.client] = {};
  }
  peers_.erase(number);
}

void GiveServer::serve(int64_t t_ns, const Handlers& handlers) {
  std::array<epoll_event, kMostPeers + 1> events;
  const int n = epoll_wait(epoll_.get(), events.data(), static_cast<int>(events.size()), 0);
  for (int i = 0; i < n; ++i) {
    const uint64_t number = events[static_cast<size_t>(i)].data.u64;
    if (number == kDoor) {
      for (int k = 0; k < kMostAccepted && accept_peer(t_ns); ++k) {
      }
    } else if (const auto found = peers_.find(number); found != peers_.end()) {
      if (!hear(found->second, t_ns, handlers)) drop(number, handlers);
    }
  }
  for (auto at = peers_.begin(); at != peers_.end();) {
    const auto& [number, peer] = *at++;
    const bool comes = peer.step == Step::kConnected || peer.step == Step::kNamed;
    const bool is_slow = comes && t_ns - peer.since_ns > kPatienceNs;
    if (is_slow) drop(number, handlers);
  }
}

}  // namespace haptic
