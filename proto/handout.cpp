// SPDX-License-Identifier: Apache-2.0
#include "proto/handout.h"

#include <dirent.h>
#include <fcntl.h>
#include <poll.h>
#include <sys/epoll.h>
#include <sys/eventfd.h>
#include <sys/file.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <limits>

#include "proto/config.h"
#include "proto/environment.h"
#include "proto/unix_socket.h"

namespace haptic {
namespace {

constexpr size_t kMaxClients = 64;
constexpr int kRetirePollMs = 100;
constexpr const char* kSystemFolder = "/run/hapticd";

[[noreturn]] void throw_errno(const std::string& what) {
  throw HandoutError(what + ": " + std::strerror(errno));
}

std::string temporary_folder() {
  return "/tmp/hapticd-" + std::to_string(geteuid());
}

/// Folders in which a client looks, the one a server of this user makes first.
std::vector<std::string> session_folders() {
  std::vector<std::string> folders{runtime_folder()};
  if (!environment("HAPTICD_RUNTIME_DIR").empty()) return folders;
  for (const std::string& folder : {std::string(kSystemFolder), temporary_folder()}) {
    if (folder != folders.front()) folders.push_back(folder);
  }
  return folders;
}

bool is_trusted_folder(const std::string& folder) {
  struct stat status {};
  return lstat(folder.c_str(), &status) == 0 && S_ISDIR(status.st_mode) &&
         (status.st_uid == geteuid() || status.st_uid == 0);
}

/// Creates the folder; what lies there must be ours: in /tmp anybody could have made it.
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

void check_session_name(const std::string& session) {
  const std::string problem = session_name_problem(session);
  if (!problem.empty()) throw HandoutError("'" + session + "' " + problem);
}

/// A connected socket, or none with errno set.
FileDescriptor try_connect(const std::string& path) {
  FileDescriptor fd = unix_socket();
  return connect_to(fd, path) ? std::move(fd) : FileDescriptor{};
}

std::vector<std::string> sessions_in(const std::string& folder) {
  std::vector<std::string> names;
  DIR* dir = is_trusted_folder(folder) ? opendir(folder.c_str()) : nullptr;
  if (dir == nullptr) return names;
  constexpr std::string_view kSuffix = ".sock";
  while (const dirent* entry = readdir(dir)) {
    const std::string_view file = entry->d_name;
    if (file.size() <= kSuffix.size() || !file.ends_with(kSuffix)) continue;
    if (try_connect(folder + "/" + std::string(file)).is_open()) {
      names.emplace_back(file.substr(0, file.size() - kSuffix.size()));
    }
  }
  closedir(dir);
  return names;
}

/// One message with at most one descriptor. Never blocks.
bool send_announcement(int socket, const Announcement& announcement, int fd) {
  iovec data{const_cast<Announcement*>(&announcement), sizeof announcement};
  alignas(cmsghdr) char control[CMSG_SPACE(sizeof(int))] = {};
  msghdr message{};
  message.msg_iov = &data;
  message.msg_iovlen = 1;
  message.msg_control = control;
  message.msg_controllen = sizeof control;
  cmsghdr* part = CMSG_FIRSTHDR(&message);
  part->cmsg_level = SOL_SOCKET;
  part->cmsg_type = SCM_RIGHTS;
  part->cmsg_len = CMSG_LEN(sizeof(int));
  std::memcpy(CMSG_DATA(part), &fd, sizeof fd);
  return sendmsg(socket, &message, MSG_DONTWAIT | MSG_NOSIGNAL) == sizeof announcement;
}

enum class Received { kMessage, kNothing, kBroken };

/// One message; descriptors beyond the first cannot come (no room for them is given).
Received receive_announcement(int socket, Announcement& announcement, FileDescriptor& fd) {
  iovec data{&announcement, sizeof announcement};
  alignas(cmsghdr) char control[CMSG_SPACE(sizeof(int))] = {};
  msghdr message{};
  message.msg_iov = &data;
  message.msg_iovlen = 1;
  message.msg_control = control;
  message.msg_controllen = sizeof control;
  const ssize_t n = recvmsg(socket, &message, MSG_DONTWAIT | MSG_CMSG_CLOEXEC);
  if (n < 0 && (errno == EAGAIN || errno == EINTR)) return Received::kNothing;

  const cmsghdr* part = n > 0 ? CMSG_FIRSTHDR(&message) : nullptr;
  if (part != nullptr && part->cmsg_type == SCM_RIGHTS && part->cmsg_len == CMSG_LEN(sizeof(int))) {
    int received = -1;
    std::memcpy(&received, CMSG_DATA(part), sizeof received);
    fd = FileDescriptor(received);
  }
  const bool whole = n == sizeof announcement && fd.is_open() &&
                     (message.msg_flags & (MSG_TRUNC | MSG_CTRUNC)) == 0 &&
                     announcement.protocol == kHandoutProtocol;
  return whole ? Received::kMessage : Received::kBroken;
}

Announcement make_announcement(SegmentId id, uint64_t generation, const char* name) {
  Announcement announcement{kHandoutProtocol, id, generation, {}};
  assign(announcement.name, name);
  return announcement;
}

std::string join(const std::vector<std::string>& names) {
  std::string text;
  for (const std::string& name : names) text += (text.empty() ? "" : ", ") + name;
  return text;
}

}  // namespace

std::string runtime_folder() {
  if (std::string folder = environment("HAPTICD_RUNTIME_DIR"); !folder.empty()) return folder;
  if (const std::string user = environment("XDG_RUNTIME_DIR"); !user.empty())
    return user + "/hapticd";
  return geteuid() == 0 && access("/run", W_OK) == 0 ? kSystemFolder : temporary_folder();
}

std::vector<std::string> running_sessions() {
  std::vector<std::string> names;
  for (const std::string& folder : session_folders()) {
    for (std::string& name : sessions_in(folder)) names.push_back(std::move(name));
  }
  std::sort(names.begin(), names.end());
  names.erase(std::unique(names.begin(), names.end()), names.end());
  return names;
}

HandoutServer::HandoutServer(const std::string& session) {
  check_session_name(session);
  const std::string folder = runtime_folder();
  prepare_folder(folder);
  socket_path_ = folder + "/" + session + ".sock";
  lock_session(folder, session);
  open_socket();
}

HandoutServer::~HandoutServer() {
  unlink(socket_path_.c_str());
}

void HandoutServer::lock_session(const std::string& folder, const std::string& session) {
  const std::string path = folder + "/" + session + ".lock";
  lock_ = FileDescriptor(open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC | O_NOFOLLOW, 0644));
  if (!lock_.is_open()) throw_errno("cannot open the lock " + path);
  if (flock(lock_.get(), LOCK_EX | LOCK_NB) != 0) {
    char pid[24] = {};
    const ssize_t n = pread(lock_.get(), pid, sizeof pid - 1, 0);
    const std::string owner = n > 0 ? std::string(pid, static_cast<size_t>(n)) : "?";
    throw HandoutError("session '" + session + "' runs already (hapticd, pid " + owner +
                       "); stop it with 'kill " + owner +
                       "' or start this one with --session OTHER");
  }
  // the file stays behind when we go: removing it would let two servers lock two files
  const std::string pid = std::to_string(getpid());
  if (ftruncate(lock_.get(), 0) != 0 ||
      pwrite(lock_.get(), pid.data(), pid.size(), 0) != static_cast<ssize_t>(pid.size())) {
    throw_errno("cannot write the lock " + path);
  }
}

void HandoutServer::open_socket() {
  listener_ = unix_socket();
  // we hold the lock, so what lies there is left over from a server that was killed; who may enter
  // the folder may read the segments
  if (!listen_at(listener_, socket_path_)) throw_errno("cannot listen on " + socket_path_);

  epoll_ = FileDescriptor(epoll_create1(EPOLL_CLOEXEC));
  epoll_event event{EPOLLIN, {.fd = listener_.get()}};
  if (epoll_ctl(epoll_.get(), EPOLL_CTL_ADD, listener_.get(), &event) != 0) {
    throw_errno("cannot wait for clients");
  }
}

size_t HandoutServer::n_clients() const {
  return static_cast<size_t>(std::count_if(peers_.begin(), peers_.end(),
                                           [](const auto& p) { return !p.second.is_child; }));
}

bool HandoutServer::add_peer(Peer peer) {
  const int fd = peer.socket.get();
  for (const auto& [id, segment] : segments_) {
    if (!send_announcement(fd, segment.announcement, segment.fd.get())) return false;
  }
  epoll_event event{EPOLLIN, {.fd = fd}};
  if (epoll_ctl(epoll_.get(), EPOLL_CTL_ADD, fd, &event) != 0) return false;
  peers_.insert_or_assign(fd, std::move(peer));
  return true;
}

void HandoutServer::accept_client() {
  Peer peer;
  peer.socket =
      FileDescriptor(accept4(listener_.get(), nullptr, nullptr, SOCK_CLOEXEC | SOCK_NONBLOCK));
  if (peer.socket.is_open() && n_clients() < kMaxClients) add_peer(std::move(peer));
}

FileDescriptor HandoutServer::connect_child(SegmentId id, uint64_t generation) {
  std::erase_if(peers_,
                [id](const auto& p) { return p.second.is_child && p.second.may_offer == id; });
  int ends[2];
  if (socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0, ends) != 0) {
    throw_errno("cannot make a socket pair for a child");
  }
  FileDescriptor child_end(ends[1]);
  Peer peer{FileDescriptor(ends[0]), true, id, generation};
  if (!add_peer(std::move(peer))) throw_errno("cannot hand the segments to a child");
  return child_end;
}

void HandoutServer::announce(SegmentId id, uint64_t generation, const char* name, int fd) {
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
  send_to_all(segment);
  return true;
}

void HandoutServer::send_to_all(const Segment& segment) {
  // a full socket belongs to somebody who has not read for hundreds of messages
  std::erase_if(peers_, [&](const auto& p) {
    return !send_announcement(p.second.socket.get(), segment.announcement, segment.fd.get());
  });
}

bool HandoutServer::receive_from(Peer& peer, const OfferHandler& on_offer) {
  Announcement announcement{};
  FileDescriptor fd;
  const Received result = receive_announcement(peer.socket.get(), announcement, fd);
  if (result == Received::kNothing) return true;
  announcement.name.back() = '\0';
  const bool allowed = result == Received::kMessage && peer.is_child &&
                       announcement.id == peer.may_offer &&
                       announcement.generation >= peer.generation;
  if (!allowed) return false;
  try {
    FileDescriptor read_only = reopen_read_only(fd.get());
    const int shown = read_only.get();
    if (store(announcement, std::move(read_only)) && on_offer) on_offer(announcement, shown);
  } catch (const SegmentError&) {
    return false;
  }
  return true;
}

void HandoutServer::serve(const OfferHandler& on_offer) {
  epoll_event events[kMaxClients];
  const int n = epoll_wait(epoll_.get(), events, static_cast<int>(kMaxClients), 0);
  for (int i = 0; i < n; ++i) {
    const int fd = events[i].data.fd;
    if (fd == listener_.get()) {
      accept_client();
      continue;
    }
    // an earlier event of this round may have dropped it
    const auto peer = peers_.find(fd);
    if (peer == peers_.end()) continue;
    if (!receive_from(peer->second, on_offer)) peers_.erase(fd);
  }
}

FileDescriptor connect_session(const std::string& session) {
  if (!session.empty()) {
    check_session_name(session);
    const std::string socket = "/" + session + ".sock";
    for (const std::string& folder : session_folders()) {
      if (!is_trusted_folder(folder)) continue;
      FileDescriptor fd = try_connect(folder + socket);
      if (fd.is_open()) return fd;
    }
  }
  // listing knocks at every session, so only when it is needed
  const std::vector<std::string> running = running_sessions();
  if (session.empty() && running.size() == 1) return connect_session(running.front());
  std::string what = session.empty() ? "which session?" : "no session '" + session + "' is running";
  what += running.empty() ? "; none is running here" : "; running: " + join(running);
  throw HandoutError(what + "; start one with 'hapticd CONFIG.toml" +
                     (session.empty() ? "'" : " --session " + session + "'"));
}

SessionPeer peer_of(const FileDescriptor& socket) {
  SessionPeer peer;
  sockaddr_un address{};
  socklen_t size = sizeof address;
  if (getpeername(socket.get(), reinterpret_cast<sockaddr*>(&address), &size) == 0) {
    const std::filesystem::path path = address.sun_path;
    peer.folder = path.parent_path().string();
    peer.session = path.stem().string();
  }
  ucred credentials{};
  size = sizeof credentials;
  if (getsockopt(socket.get(), SOL_SOCKET, SO_PEERCRED, &credentials, &size) == 0) {
    peer.hapticd = credentials.pid;
  }
  return peer;
}

void offer_segment(int socket, SegmentId id, uint64_t generation, const char* name, int fd) {
  if (!send_announcement(socket, make_announcement(id, generation, name), fd)) {
    throw_errno(std::string("cannot offer segment '") + name + "' to hapticd");
  }
}

Attachments::Attachments(FileDescriptor socket, AttachOptions options)
    : socket_(std::move(socket)),
      stop_event_(eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK)),
      options_(std::move(options)) {
  if (!stop_event_.is_open()) throw_errno("cannot make an event descriptor");
}

Attachments::~Attachments() {
  if (!thread_.joinable()) return;
  eventfd_write(stop_event_.get(), 1);
  thread_.join();
}

detail::Feed& Attachments::feed_of(const SegmentSpec& spec) {
  detail::Feed& feed = feeds_[spec.id];
  feed.spec = &spec;
  return feed;
}

detail::ReaderMark* Attachments::add_reader(detail::Feed& feed) {
  if (thread_.joinable()) throw HandoutError("sources are to be made before the start");
  feed.readers.push_back(std::make_unique<detail::ReaderMark>());
  return feed.readers.back().get();
}

void Attachments::start() {
  thread_ = std::thread([this] { run(); });
}

void Attachments::run() {
  bool retiring = false;
  for (;;) {
    pollfd waiting[] = {{socket_.get(), POLLIN, 0}, {stop_event_.get(), POLLIN, 0}};
    // readers do not wake us: look again while old generations are left
    poll(waiting, 2, retiring ? kRetirePollMs : -1);
    if (waiting[1].revents != 0) return;
    if (waiting[0].revents != 0 && !receive()) break;
    retiring = free_retired();
  }
  connected_.store(false, std::memory_order_release);
  if (options_.on_closed) options_.on_closed();
}

bool Attachments::receive() {
  Announcement announcement{};
  FileDescriptor fd;
  const Received result = receive_announcement(socket_.get(), announcement, fd);
  if (result == Received::kBroken) return false;
  if (result == Received::kMessage) attach(announcement, std::move(fd));
  return true;
}

void Attachments::attach(const Announcement& announcement, FileDescriptor fd) {
  const auto found = feeds_.find(announcement.id);
  if (found == feeds_.end()) return;
  detail::Feed& feed = found->second;
  detail::Generation* last =
      feed.generations.empty() ? feed.before_first.get() : feed.generations.back().get();
  // the same announcement may come twice
  if (last->mapping != nullptr && last->mapping->generation() >= announcement.generation) return;
  try {
    auto next = std::make_unique<detail::Generation>();
    next->mapping = std::make_unique<SegmentMapping>(
        std::move(fd), *feed.spec, ViewOptions{.lock_memory = options_.lock_memory});
    if (next->mapping->generation() != announcement.generation) {
      throw HandoutError(std::string("segment '") + feed.spec->name +
                         "' was announced with another generation than it holds");
    }
    next->serial = last->serial + 1;
    feed.generations.push_back(std::move(next));
    last->next.store(feed.generations.back().get(), std::memory_order_release);
  } catch (const std::exception& error) {
    if (options_.on_error) options_.on_error(error.what());
  }
}

bool Attachments::free_retired() {
  bool some_left = false;
  for (auto& [id, feed] : feeds_) {
    uint64_t reached = std::numeric_limits<uint64_t>::max();
    for (const auto& reader : feed.readers) {
      reached = std::min(reached, reader->serial.load(std::memory_order_acquire));
    }
    // the last one stays: the next is linked to it
    while (feed.generations.size() > 1 && feed.generations.front()->serial < reached) {
      feed.generations.erase(feed.generations.begin());
    }
    some_left = some_left || feed.generations.size() > 1;
  }
  return some_left;
}

}  // namespace haptic
