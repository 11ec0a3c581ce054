// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/bake/mapped_file.h"

#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <boost/interprocess/file_mapping.hpp>
#include <boost/interprocess/mapped_region.hpp>
#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <exception>
#include <filesystem>
#include <iterator>
#include <stdexcept>

#include "proto/math/assert.h"
#include "proto/os/regular_file.h"

namespace haptic {
namespace {

namespace ipc = boost::interprocess;

/// Makes the bytes and writes them to `file`: success is exit code 0. Nothing of the parent's is
/// destroyed or flushed here.
[[noreturn]] void make_and_exit(const ByteMaker& make, int file, pid_t parent) {
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (getppid() != parent) _exit(EXIT_FAILURE);
  try {
    const std::vector<std::byte> bytes = make();
    _exit(!bytes.empty() && write_all(file, bytes) ? EXIT_SUCCESS : EXIT_FAILURE);
  } catch (const std::exception&) {
    _exit(EXIT_FAILURE);  // the parent makes them itself, and says what is wrong
  }
}

bool succeeded(pid_t child) {
  int status = 0;
  while (waitpid(child, &status, 0) < 0) {
    if (errno != EINTR) return false;
  }
  return WIFEXITED(status) && WEXITSTATUS(status) == EXIT_SUCCESS;
}

}  // namespace

MappedFile map_descriptor(const FileDescriptor& descriptor) {
  try {
    const std::string path = "/proc/self/fd/" + std::to_string(descriptor.get());
    const ipc::file_mapping file(path.c_str(), ipc::read_only);
    const auto region = std::make_shared<ipc::mapped_region>(file, ipc::read_only);
    return {{static_cast<const std::byte*>(region->get_address()), region->get_size()}, region};
  } catch (const ipc::interprocess_exception& refused) {
    throw std::runtime_error(refused.what());
  }
}

MappedFile map_file(const std::string& path) {
  const RegularFile file = open_regular_file(path);
  if (!file.problem.empty()) throw std::runtime_error(file.problem);
  return file.size == 0 ? MappedFile{} : map_descriptor(file.descriptor);
}

MappedFile make_here(const ByteMaker& make) {
  const auto bytes = std::make_shared<std::vector<std::byte>>(make());
  return {*bytes, bytes};
}

MappedFile make_apart(const ByteMaker& make) {
  // a fork beside other threads would leave their locks held for ever
  HAPTIC_ASSERT(std::distance(std::filesystem::directory_iterator("/proc/self/task"), {}) == 1);
  const FileDescriptor file(memfd_create("haptic-baked", MFD_CLOEXEC));
  const pid_t parent = getpid();
  const pid_t child = file.is_open() ? fork() : -1;
  if (child == 0) make_and_exit(make, file.get(), parent);
  return child > 0 && succeeded(child) ? map_descriptor(file) : make_here(make);
}

}  // namespace haptic
