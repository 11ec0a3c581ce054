// SPDX-License-Identifier: Apache-2.0
#include "proto/ipc/sessions.h"

#include <dirent.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <filesystem>

#include "proto/config/config_names.h"
#include "proto/os/environment.h"
#include "proto/os/message.h"
#include "proto/os/realtime.h"

namespace haptic {
namespace {

constexpr int64_t kConnectPatienceNs = 2 * kNsPerSecond;  // for a place in the queue

std::string temporary_folder() {
  return "/tmp/hapticd-" + std::to_string(geteuid());
}

/// Folders in which a client looks; a server of this user makes the first.
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

/// True if a server listens there, even with a full queue.
bool is_answered(const std::string& path) {
  const FileDescriptor fd = unix_socket();
  return connect_to(fd, path) || errno == EAGAIN;
}

std::vector<std::string> sessions_in(const std::string& folder) {
  std::vector<std::string> names;
  DIR* dir = is_trusted_folder(folder) ? opendir(folder.c_str()) : nullptr;
  if (dir == nullptr) return names;
  constexpr std::string_view kSuffix = ".sock";
  while (const dirent* entry = readdir(dir)) {
    const std::string_view file = entry->d_name;
    if (file.size() <= kSuffix.size() || !file.ends_with(kSuffix)) continue;
    if (is_answered(folder + "/" + std::string(file))) {
      names.emplace_back(file.substr(0, file.size() - kSuffix.size()));
    }
  }
  closedir(dir);
  return names;
}

}  // namespace

void check_session_name(const std::string& session) {
  const std::string problem = session_name_problem(session);
  if (!problem.empty()) throw HandoutError("'" + shown(session) + "' " + problem);
}

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

namespace {

/// Possible sockets of that session, except in folders others can write.
std::vector<std::string> places_of(const std::string& session) {
  check_session_name(session);
  std::vector<std::string> places;
  for (const std::string& folder : session_folders()) {
    if (is_trusted_folder(folder)) places.push_back(folder + "/" + session + ".sock");
  }
  return places;
}

/// The only running session; throws if there is none or more than one, or if the named session
/// `not_found` does not run.
std::string only_session(const std::string& not_found) {
  // connects to every session, so done only when needed
  const std::vector<std::string> running = running_sessions();
  if (not_found.empty() && running.size() == 1) return running.front();
  if (not_found.empty() && !running.empty()) {
    throw HandoutError("several sessions are running (" + joined(running) +
                       "); choose one, as --session " + running.front());
  }
  const std::string named = not_found.empty() ? "" : " '" + shown(not_found) + "'";
  throw HandoutError("no session" + named + " is running (looked in " + joined(session_folders()) +
                     "; " +
                     (running.empty() ? "HAPTICD_RUNTIME_DIR names another folder"
                                      : "running: " + joined(running)) +
                     "); start one: hapticd CONFIG.toml" +
                     (not_found.empty() ? "" : " --session " + shown(not_found)));
}

}  // namespace

std::string find_session(const std::string& session) {
  if (session.empty()) return find_session(only_session(""));
  for (const std::string& place : places_of(session)) {
    if (is_answered(place)) return place;
  }
  return only_session(session);
}

FileDescriptor connect_session(const std::string& session) {
  if (session.empty()) return connect_session(only_session(""));
  for (const std::string& place : places_of(session)) {
    FileDescriptor fd = unix_socket();
    if (connect_to(fd, place, kConnectPatienceNs)) return fd;
    if (errno == EAGAIN) {
      throw HandoutError(place + ": others fill the queue of this session; try again");
    }
  }
  only_session(session);
  return {};
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

}  // namespace haptic
