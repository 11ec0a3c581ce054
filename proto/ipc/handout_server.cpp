// SPDX-License-Identifier: Apache-2.0
#include "proto/ipc/handout_server.h"

#include <fcntl.h>
#include <linux/sockios.h>
#include <sys/epoll.h>
#include <sys/file.h>
#include <sys/ioctl.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdio>
#include <limits>
#include <ranges>

#include "proto/ipc/segment.h"
#include "proto/ipc/sessions.h"
#include "proto/math/assert.h"
#include "proto/os/programs.h"

namespace haptic {
namespace {

constexpr size_t kLongestQuestion = 32;  // of a client [bytes]
constexpr size_t kMostEvents = 64;       // per epoll_wait
constexpr int kMostAccepted = 16;        // per turn; commands are served in between
constexpr size_t kMostOfStranger = 16;   // connections per user, except owner and root
constexpr size_t kMostOfStrangers = 64;  // connections of all such users
// kept for children: three restarts need about thirty, the eye files one each, with pieces two
constexpr rlim_t kKeptForChildren = 48 + 2 * kMostEyes;
// descriptors of the process that strangers cannot take: 48 more are left to its own user
constexpr rlim_t kKeptForStrangers = kKeptForChildren + 48;
constexpr size_t kMostEyesAtOnce = 4;  // unread by a client: as many as there are segments

/// Clients alone map what clients draw.
constexpr bool is_drawn(SegmentId id) {
  return id >= DrawChannels::id(0) && id <= DrawChannels::id(kMostClients - 1);
}

/// Creates the folder; an existing one must be ours, since anybody can make one in /tmp.
void prepare_folder(const std::string& folder) {
  const bool shared = folder == kSystemFolder;
  if (mkdir(folder.c_str(), shared ? 0755 : 0700) != 0 && errno != EEXIST) {
    throw_errno("cannot create the runtime folder " + folder +
                " (set HAPTICD_RUNTIME_DIR to a folder you may write)");
  }
  struct stat status {};
  if (lstat(folder.c_str(), &status) != 0 || !S_ISDIR(status.st_mode)) {
    throw HandoutError("runtime folder " + folder +
                       " is not a folder; remove it or set HAPTICD_RUNTIME_DIR");
  }
  if (status.st_uid != geteuid()) {
    throw HandoutError("runtime folder " + folder + " belongs to user " +
                       std::to_string(status.st_uid) +
                       "; remove it or set HAPTICD_RUNTIME_DIR to a folder of yours");
  }
  if ((status.st_mode & 022) != 0) {
    throw HandoutError("runtime folder " + folder + " can be written by others; run 'chmod 700 " +
                       folder + "'");
  }
}

/// Limit of open descriptors of this process.
rlim_t descriptor_limit() {
  rlimit limit{};
  return getrlimit(RLIMIT_NOFILE, &limit) == 0 ? limit.rlim_cur : RLIM_INFINITY;
}

}  // namespace

namespace {

/// Names the lock's holder to a second server: the hapticd that wrote the file, or a process that
/// merely holds it. The start time tells a reused pid.
[[noreturn]] void refuse_twin(const FileDescriptor& lock, const std::string& path,
                              const std::string& session) {
  char text[64] = {};
  const ssize_t n = pread(lock.get(), text, sizeof text - 1, 0);
  long pid = -1;
  unsigned long long started = 0;
  const bool known = n > 0 && std::sscanf(text, "%ld %llu", &pid, &started) == 2 && pid > 0 &&
                     start_time_of(static_cast<pid_t>(pid)) == started;
  if (known) {
    throw HandoutError("session '" + session + "' runs already (hapticd, pid " +
                       std::to_string(pid) + "); end it with 'hapt stop --session " + session +
                       "' or start this one with --session OTHER");
  }
  throw HandoutError("the lock " + path +
                     " is held by a process that is no running hapticd; 'fuser " + path +
                     "' names it, remove the file when it is gone, or start this one with "
                     "--session OTHER");
}

}  // namespace

HandoutServer::HandoutServer(const std::string& session) : session_(session) {
  check_session_name(session);
  folder_ = runtime_folder();
  lock_path_ = folder_ + "/" + session + ".lock";
  prepare_folder(folder_);
  lock_session();
  // with the lock held, an existing socket is left over from a killed server; everybody who may
  // enter the folder may read the segments
  listener_.emplace(folder_ + "/" + session + ".sock", 0666);
  epoll_ = FileDescriptor(epoll_create1(EPOLL_CLOEXEC));
  wait_for_clients();
}

HandoutServer::~HandoutServer() = default;

void HandoutServer::lock_session() {
  const std::string& path = lock_path_;
  FileDescriptor lock(open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC | O_NOFOLLOW, 0600));
  if (!lock.is_open()) throw_errno("cannot open the lock " + path);
  // older versions let everybody open the lock, and so hold it
  if (fchmod(lock.get(), 0600) != 0) throw_errno("cannot keep others from the lock " + path);
  if (flock(lock.get(), LOCK_EX | LOCK_NB) != 0) refuse_twin(lock, path, session_);
  // the file is never removed: two servers could then lock two files
  const std::string owner =
      std::to_string(getpid()) + " " + std::to_string(start_time_of(getpid()));
  if (ftruncate(lock.get(), 0) != 0 ||
      pwrite(lock.get(), owner.data(), owner.size(), 0) != static_cast<ssize_t>(owner.size())) {
    throw_errno("cannot write the lock " + path);
  }
  lock_ = std::move(lock);
}

bool HandoutServer::has_lock() const {
  struct stat held {};
  const std::optional<FileIdentity> named = identity_of(lock_path_);
  return named && fstat(lock_.get(), &held) == 0 &&
         *named == FileIdentity{held.st_dev, held.st_ino};
}

bool HandoutServer::restore() {
  const bool locked = has_lock();
  if (locked && listener_->is_in_place()) return false;
  prepare_folder(folder_);
  if (!locked) lock_session();
  listener_->listen_again();
  wait_for_clients();
  return true;
}

void HandoutServer::wait_for_clients() {
  HAPTIC_ASSERT(listener_.has_value());
  epoll_event event{EPOLLIN, {.fd = listener_->fd()}};
  if (epoll_ctl(epoll_.get(), EPOLL_CTL_ADD, listener_->fd(), &event) != 0) {
    throw_errno("cannot wait for clients");
  }
}

size_t HandoutServer::n_clients() const {
  return static_cast<size_t>(std::count_if(peers_.begin(), peers_.end(),
                                           [](const auto& p) { return !p.second.is_child; }));
}

bool HandoutServer::add_peer(Peer peer) {
  HAPTIC_ASSERT(peer.socket.is_open());
  const int fd = peer.socket.get();
  // hapticd's own, which is always there, comes last: a child that has it has all there were
  for (const auto& [id, segment] : std::views::reverse(segments_)) {
    if (is_eye(id)) {
      if (!peer.is_child) peer.owed.insert(id);
    } else if (peer.is_child && is_drawn(id)) {
      continue;
    } else if (!send_announcement(fd, segment.announcement, segment.fd.get())) {
      return false;
    }
  }
  epoll_event event{EPOLLIN, {.fd = fd}};
  if (epoll_ctl(epoll_.get(), EPOLL_CTL_ADD, fd, &event) != 0) return false;
  peers_.insert_or_assign(fd, std::move(peer));
  return true;
}

/// Why a client is refused; empty: it is served. Descriptors are numbered from the lowest free one,
/// so the newest tells how many are left.
std::string HandoutServer::refusal_of(uid_t user, int fd) const {
  const rlim_t limit = descriptor_limit();
  const bool known = user == 0 || user == geteuid();
  const rlim_t kept = known ? kKeptForChildren : kKeptForStrangers;
  if (limit != RLIM_INFINITY && static_cast<rlim_t>(fd) + kept >= limit) {
    return "the session has no descriptor left for another client (its limit is " +
           std::to_string(limit) + "); end some clients, or start hapticd with a larger ulimit -n";
  }
  if (known) return "";
  size_t of_user = 0, of_strangers = 0;
  for (const auto& [number, peer] : peers_) {
    if (peer.is_child || peer.user == 0 || peer.user == geteuid()) continue;
    ++of_strangers;
    of_user += peer.user == user;
  }
  if (of_user >= kMostOfStranger) {
    return "user " + std::to_string(user) + " already watches this session " +
           std::to_string(of_user) + " times, no more are served; end one of them";
  }
  if (of_strangers >= kMostOfStrangers) {
    return "other users already watch this session " + std::to_string(of_strangers) +
           " times, no more are served; try again later";
  }
  return "";
}

bool HandoutServer::accept_client() {
  std::optional<FileDescriptor> socket = listener_->accept();
  if (!socket || !socket->is_open()) return socket.has_value();
  Peer peer{.socket = std::move(*socket)};
  peer.user = user_of(peer.socket.get()).value_or(std::numeric_limits<uid_t>::max());
  const std::string why = refusal_of(peer.user, peer.socket.get());
  if (why.empty()) {
    add_peer(std::move(peer));
  } else {
    send_refusal(peer.socket.get(), why);
  }
  return true;
}

FileDescriptor HandoutServer::connect_child(SegmentId id, uint64_t generation) {
  int ends[2];
  if (socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0, ends) != 0) {
    throw_errno("cannot make a socket pair for a child");
  }
  FileDescriptor child_end(ends[1]);
  Peer peer{FileDescriptor(ends[0]), true, id, generation};
  if (!add_peer(std::move(peer))) throw_errno("cannot hand the segments to a child");
  return child_end;
}

void HandoutServer::become(SegmentId id, uint64_t generation, SegmentId other) {
  for (auto& [number, peer] : peers_) {
    const bool is_it = peer.is_child && peer.owns == id && peer.generation == generation;
    if (is_it) peer.owns = other;
  }
}

void HandoutServer::forget_children(SegmentId id, uint64_t before_generation) {
  std::erase_if(peers_, [&](const auto& p) {
    const Peer& peer = p.second;
    return peer.is_child && peer.owns == id && peer.generation < before_generation;
  });
}

void HandoutServer::announce(SegmentId id, uint64_t generation, const char* name, int fd) {
  HAPTIC_ASSERT(name != nullptr && fd >= 0);
  store(make_announcement(id, generation, name), reopen_read_only(fd));
}

bool HandoutServer::store(const Announcement& announcement, FileDescriptor fd) {
  const auto present = segments_.find(announcement.id);
  if (present != segments_.end() &&
      present->second.announcement.generation >= announcement.generation) {
    return false;
  }
  Segment& segment = segments_[announcement.id];
  segment = {announcement, std::move(fd)};
  if (is_eye(announcement.id)) {
    for (auto& [number, peer] : peers_) {
      if (!peer.is_child) peer.owed.insert(announcement.id);
    }
  } else {
    send_to_all(segment);
  }
  return true;
}

void HandoutServer::send_to_all(const Segment& segment) {
  // a full socket belongs to a peer that has not read hundreds of messages
  std::erase_if(peers_, [&](const auto& p) {
    if (p.second.is_child && is_drawn(segment.announcement.id)) return false;
    return !send_announcement(p.second.socket.get(), segment.announcement, segment.fd.get());
  });
}

namespace {

/// True if the other end has read all that it was sent.
bool has_read_all(int socket) {
  int unread = 0;  // [bytes]
  return ioctl(socket, SIOCOUTQ, &unread) == 0 && unread == 0;
}

}  // namespace

/// The next eye files a client lacks, once it has read the last ones. False: it is to be dropped.
bool HandoutServer::send_owed(Peer& peer) {
  if (peer.owed.empty() || !has_read_all(peer.socket.get())) return true;
  for (size_t n = 0; n < kMostEyesAtOnce && !peer.owed.empty(); ++n) {
    const Segment& segment = segments_.at(*peer.owed.begin());
    if (!send_announcement(peer.socket.get(), segment.announcement, segment.fd.get())) return false;
    peer.owed.erase(peer.owed.begin());
  }
  return true;
}

namespace {

/// Hears what a client asks and answers. Returns whether it goes on watching: it said nothing.
bool answer_client(int socket, const HandoutServer::QuestionHandler& on_question) {
  std::array<char, kLongestQuestion> line;
  const ssize_t size = recv(socket, line.data(), line.size(), MSG_DONTWAIT | MSG_TRUNC);
  if (size < 0 && (errno == EAGAIN || errno == EINTR)) return true;
  if (size <= 0 || size > static_cast<ssize_t>(line.size()) || !on_question) return false;
  const std::string answer = on_question({line.data(), static_cast<size_t>(size)});
  if (!answer.empty()) send(socket, answer.data(), answer.size(), MSG_DONTWAIT | MSG_NOSIGNAL);
  return false;
}

}  // namespace

bool HandoutServer::receive_from(Peer& peer, const OfferHandler& on_offer,
                                 const QuestionHandler& on_question) {
  if (!peer.is_child) return answer_client(peer.socket.get(), on_question);
  const ReceivedMessage message = receive_message(peer.socket.get());
  if (message.kind == Received::kNothing) return true;
  const Announcement& offer = message.announcement;
  const bool allowed = message.kind == Received::kMessage && may_offer(peer.owns, offer.id) &&
                       offer.generation >= peer.generation;
  if (!allowed) return false;
  try {
    FileDescriptor read_only = reopen_read_only(message.fd.get());
    const int shown = read_only.get();
    if (store(offer, std::move(read_only)) && on_offer) on_offer(offer, shown);
  } catch (const SegmentError&) {
    return false;
  }
  return true;
}

void HandoutServer::serve(const OfferHandler& on_offer, const QuestionHandler& on_question) {
  epoll_event events[kMostEvents];
  const int n = epoll_wait(epoll_.get(), events, static_cast<int>(kMostEvents), 0);
  for (int i = 0; i < n; ++i) {
    const int fd = events[i].data.fd;
    if (fd == listener_->fd()) {
      for (int k = 0; k < kMostAccepted && accept_client(); ++k) {
      }
      continue;
    }
    // an earlier event of this round may have dropped it
    const auto peer = peers_.find(fd);
    if (peer == peers_.end()) continue;
    if (!receive_from(peer->second, on_offer, on_question)) peers_.erase(fd);
  }
  for (auto peer = peers_.begin(); peer != peers_.end();) {
    peer = send_owed(peer->second) ? std::next(peer) : peers_.erase(peer);
  }
}

}  // namespace haptic
