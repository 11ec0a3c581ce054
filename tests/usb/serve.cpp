// SPDX-License-Identifier: GPL-3.0-or-later
// Plugs an emulated device into a virtual machine: haptic-usb-device KIND SOCKET [options]. QEMU
// connects to the socket by `-chardev socket,path=SOCKET -device usb-redir`. It says what the
// device has seen, as one line of key=value, when QEMU hangs up.
#include <poll.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <ctime>
#include <memory>
#include <stdexcept>
#include <string>

#include "proto/config/command_line.h"
#include "proto/ipc/process.h"
#include "proto/os/file_descriptor.h"
#include "proto/os/message.h"
#include "proto/os/realtime.h"
#include "tests/usb/devices.h"
#include "tests/usb/redirected_device.h"

namespace haptic::test {
namespace {

constexpr int64_t kSecondNs = 1'000'000'000;

struct Options {
  std::string kind, socket;
  double away = 1;  // [s]
};

volatile std::sig_atomic_t unplug_wanted = 0;

FileDescriptor accept_at(const std::string& path) {
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  if (path.size() >= sizeof address.sun_path) {
    throw std::runtime_error(path + ": is too long for a socket; use a shorter folder");
  }
  std::strcpy(address.sun_path, path.c_str());
  unlink(path.c_str());
  const FileDescriptor listener(socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0));
  if (bind(listener.get(), reinterpret_cast<sockaddr*>(&address), sizeof address) != 0 ||
      listen(listener.get(), 1) != 0) {
    throw std::runtime_error(path + ": cannot be listened at: " + std::strerror(errno) +
                             "; use a folder that you may write to");
  }
  return FileDescriptor(accept4(listener.get(), nullptr, nullptr, SOCK_CLOEXEC | SOCK_NONBLOCK));
}

/// Waits for bytes of QEMU, or for the device's next turn; by how much that turn is late [ns].
int64_t wait_for(const RedirectedDevice& redirected) {
  constexpr int64_t kTurnNs = 200'000;  // a fifth of a packet's time on a full-speed bus
  constexpr int64_t kIdleNs = 20'000'000;
  pollfd ready{redirected.socket(), POLLIN, 0};
  const timespec wait{0, redirected.has_waiting() ? kTurnNs : kIdleNs};
  const int64_t begin_ns = now_ns();
  ppoll(&ready, 1, &wait, nullptr);
  return now_ns() - begin_ns - wait.tv_nsec;
}

void serve(const Options& options) {
  const std::unique_ptr<CountedDevice> device = make_device(options.kind);
  RedirectedDevice redirected(device->usb(), accept_at(options.socket));
  int64_t away_ns = 0, stood_ns = 0;
  while (redirected.step(now_ns())) {
    const int64_t t_ns = now_ns();
    if (unplug_wanted != 0 && redirected.is_plugged()) {
      redirected.unplug();
      away_ns = t_ns;
    }
    unplug_wanted = 0;
    const bool is_back = away_ns > 0 && !redirected.is_plugged() &&
                         static_cast<double>(t_ns - away_ns) > kSecondNs * options.away;
    if (is_back) redirected.plug();
    stood_ns = std::max(stood_ns, wait_for(redirected));
  }
  device->end(now_ns());
  std::printf("%s %s stood_ms=%lld\n", options.kind.c_str(), device->account().c_str(),
              static_cast<long long>(stood_ns / 1'000'000));
}

}  // namespace
}  // namespace haptic::test

int main(int argc, char** argv) try {
  using haptic::Dimension;
  constexpr haptic::Range kTimes{0, 3600};  // longer than anybody waits
  haptic::test::Options options;
  haptic::CommandLine line("haptic-usb-device",
                           "An emulated USB device, plugged into a virtual machine of QEMU.");
  line.option("KIND", options.kind, "falcon, woodenhaptics-hid or spacemouse").required();
  line.option("SOCKET", options.socket, "QEMU's end of USB redirection").required();
  line.quantity("--away", options.away, Dimension::kTime, kTimes,
                "after SIGUSR1, which unplugs it, until it is plugged in again");
  if (const auto code = line.read(argc, argv)) return *code;
  struct sigaction unplug {};
  unplug.sa_handler = [](int) { haptic::test::unplug_wanted = 1; };
  sigaction(SIGUSR1, &unplug, nullptr);
  haptic::test::serve(options);
  return 0;
} catch (const std::exception& error) {
  return haptic::report_failure("haptic-usb-device", error);
}
