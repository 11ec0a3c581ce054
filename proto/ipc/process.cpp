// SPDX-License-Identifier: Apache-2.0
#include "proto/ipc/process.h"

#include <poll.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <new>
#include <stdexcept>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>

#include "proto/math/assert.h"
#include "proto/os/message.h"
#include "proto/os/priorities.h"
#include "proto/os/text.h"
#include "proto/os/version.h"

namespace haptic {
namespace {

static_assert(std::atomic<bool>::is_always_lock_free);  // stored by a signal handler
std::atomic<bool> stop_flag{false};

void on_stop_signal(int) {
  stop_flag.store(true, std::memory_order_relaxed);
}

int fail(const char* program, const std::string& what, int code) {
  std::fprintf(stderr, "%s\n", one_line(std::string(program) + ": " + what).c_str());
  return code;
}

/// The last words of a child that hapticd has started.
int fail_under_hapticd(const char* program, const std::string& what, int code) {
  return fail(program, std::string(kErrorLine) + what, code);
}

template <typename Error>
bool is_a(const std::exception& error) {
  return dynamic_cast<const Error*>(&error) != nullptr;
}

int run_parsed(const char* program, int (*run)(const ChildArguments&),
               const ChildArguments& arguments) try {
  return run(arguments);
} catch (const std::bad_alloc&) {
  return fail_under_hapticd(program, "out of memory", kExitCrash);
} catch (const std::exception& error) {
  const bool is_crash =
      is_a<std::system_error>(error) || is_a<SegmentError>(error) || is_a<HandoutError>(error);
  const int code = is_crash ? kExitCrash : is_a<DeviceError>(error) ? kExitNoDevice : kExitBadInput;
  return fail_under_hapticd(program, error.what(), code);
}

}  // namespace

ChildArguments parse_child_arguments(int argc, char** argv) {
  constexpr std::array<std::pair<std::string_view, int ChildArguments::*>, 4> kDescriptors{
      {{"--config-fd", &ChildArguments::config_fd},
       {"--control-fd", &ChildArguments::control_fd},
       {"--device-fd", &ChildArguments::device_fd},
       {"--spare-fd", &ChildArguments::spare_fd}}};
  ChildArguments arguments;
  bool ok = argc == 9 || argc == 11;  // at most one of the last two
  for (int i = 1; ok && i + 1 < argc; i += 2) {
    const std::string_view key = argv[i];
    if (key == "--generation" || key == "--hand") {
      const auto number = number_from<uint64_t>(argv[i + 1]);
      ok = number.has_value() && (key == "--generation" || *number < kMostHands);
      if (key == "--generation") arguments.generation = number.value_or(0);
      if (key == "--hand" && ok) arguments.hand = static_cast<uint32_t>(*number);
      continue;
    }
    const auto row = std::ranges::find(kDescriptors, key, [](const auto& d) { return d.first; });
    const auto fd = number_from<int>(argv[i + 1]);
    ok = row != kDescriptors.end() && fd;
    if (ok) arguments.*row->second = *fd;
  }
  if (!ok || arguments.config_fd < 0 || arguments.control_fd < 0 || arguments.generation == 0) {
    throw std::invalid_argument(
        "started by hapticd with --config-fd N --control-fd M --generation G --hand H [--device-fd "
        "D | --spare-fd S]; start 'hapticd CONFIG.toml' instead");
  }
  return arguments;
}

namespace {

/// Answers --help and --version; false: neither was asked.
bool introduce(int argc, char** argv, const char* program) {
  const std::string_view word = argc == 2 ? argv[1] : "";
  if (word == "-V" || word == "--version") {
    std::printf("%s %s\n", program, version());
  } else if (word == "-h" || word == "--help") {
    std::printf(
        "A process of a session, started by hapticd.\n\n"
        "Usage: %s --config-fd N --control-fd M --generation G --hand H\n"
        "         [--device-fd D | --spare-fd S]\n\n"
        "Example:\n  hapticd configs/bunny.toml\n",
        program);
  } else {
    return false;
  }
  return true;
}

}  // namespace

int run_child(int argc, char** argv, int (*run)(const ChildArguments&)) {
  HAPTIC_ASSERT(run != nullptr);
  const char* slash = argc > 0 ? std::strrchr(argv[0], '/') : nullptr;
  const char* program = slash != nullptr ? slash + 1 : argc > 0 ? argv[0] : "child";
  try {
    if (introduce(argc, argv, program)) return kExitClean;
    use_small_thread_stacks();
    return run_parsed(program, run, parse_child_arguments(argc, argv));
  } catch (const std::exception& error) {
    return fail(program, error.what(), kExitBadInput);
  }
}

void catch_stop_signals() {
  struct sigaction action {};
  action.sa_handler = on_stop_signal;
  for (const int signal : {SIGTERM, SIGINT, SIGHUP}) sigaction(signal, &action, nullptr);
  action.sa_handler = SIG_IGN;
  sigaction(SIGPIPE, &action, nullptr);
}

bool stop_requested() noexcept {
  return stop_flag.load(std::memory_order_relaxed);
}
void request_stop() noexcept {
  stop_flag.store(true, std::memory_order_relaxed);
}

void die_with_parent(int control_fd) {
  prctl(PR_SET_PDEATHSIG, SIGTERM);
  // if the parent died before that, no signal comes
  pollfd peer{control_fd, POLLIN, 0};
  if (poll(&peer, 1, 0) > 0 && (peer.revents & (POLLHUP | POLLERR | POLLNVAL)) != 0) raise(SIGTERM);
}

std::optional<uint32_t> await_turn(int spare_fd, const std::function<void()>& look) {
  HAPTIC_ASSERT(look != nullptr && spare_fd >= 0);
  constexpr int kLookMs = 1000;
  send(spare_fd, &kSpareReady, 1, MSG_NOSIGNAL);
  while (!stop_requested()) {
    pollfd told{spare_fd, POLLIN, 0};
    if (poll(&told, 1, kLookMs) > 0) {
      char word = 0;
      const bool is_hand = recv(spare_fd, &word, 1, 0) == 1 && word >= kSpareTurn &&
                           word < kSpareTurn + static_cast<char>(kMostHands);
      if (!is_hand) return {};
      return static_cast<uint32_t>(word - kSpareTurn);
    }
    look();
  }
  return {};
}

std::vector<SessionConfig> read_configs(int config_fd) {
  const FileDescriptor fd(config_fd);
  struct stat status {};
  const bool is_there = fstat(fd.get(), &status) == 0 && status.st_size > 0;
  const size_t size = is_there ? static_cast<size_t>(status.st_size) : 0;
  const size_t n = size / sizeof(SessionConfig);
  if (n == 0 || n > kMostHands || size != n * sizeof(SessionConfig)) {
    throw SegmentError(SegmentFault::kWrongLayout,
                       "the configuration handed over is not that of this build; build all "
                       "programs of the session from the same source");
  }
  std::vector<SessionConfig> hands(n);
  if (pread(fd.get(), hands.data(), size, 0) != static_cast<ssize_t>(size)) {
    throw std::system_error(errno, std::generic_category(), "cannot read the configuration");
  }
  return hands;
}

AttachOptions child_attach_options(const SessionConfig& config) {
  return {.lock_memory = config.realtime != 0,
          .fifo_priority = config.realtime != 0 ? kHousekeepingPriority : 0,
          .on_error =
              [](const std::string& what) { std::fprintf(stderr, "%s\n", one_line(what).c_str()); },
          .on_closed = request_stop};
}

}  // namespace haptic
