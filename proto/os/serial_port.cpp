// SPDX-License-Identifier: Apache-2.0
#include "proto/os/serial_port.h"

#include <fcntl.h>
#include <linux/serial.h>
#include <sys/file.h>
#include <sys/ioctl.h>
#include <termios.h>

#include <cerrno>
#include <cstring>
#include <stdexcept>

#include "proto/os/message.h"

namespace haptic {
namespace {

std::string mend(int error) {
  switch (error) {
    case ENOENT:
    case ENXIO:
    case ENODEV:
      return "plug the device in and switch it on, or correct 'path' in [device.serial]";
    case EACCES:
    case EPERM:
      return "add the user to the group that owns it (ls -l shows it) and log in again";
    default:
      return "check 'path' in [device.serial]";
  }
}

[[noreturn]] void fail(const std::string& path, const char* what, int error) {
  throw InputError(path + ": " + what + ": " + std::strerror(error) + "; " + mend(error));
}

/// Turns off a driver's delay for collecting bytes; most drivers have none.
void ask_for_low_latency(int fd) {
  serial_struct serial{};
  if (ioctl(fd, TIOCGSERIAL, &serial) != 0) return;
  serial.flags |= ASYNC_LOW_LATENCY;
  ioctl(fd, TIOCSSERIAL, &serial);
}

}  // namespace

FileDescriptor open_serial_port(const std::string& path) {
  FileDescriptor fd(open(path.c_str(), O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC));
  if (!fd.is_open()) fail(path, "cannot be opened", errno);
  termios settings;
  if (tcgetattr(fd.get(), &settings) != 0) fail(path, "is no serial node", errno);
  if (flock(fd.get(), LOCK_EX | LOCK_NB) != 0) {
    throw std::runtime_error(path + ": another program drives it; stop that one (`fuser " + path +
                             "` shows it)");
  }
  cfmakeraw(&settings);
  cfsetspeed(&settings, B115200);
  settings.c_cflag |= CLOCAL | CREAD;
  // VMIN 1: no data gives EAGAIN, so a read of zero bytes means the device is gone
  settings.c_cc[VMIN] = 1;
  settings.c_cc[VTIME] = 0;
  if (tcsetattr(fd.get(), TCSANOW, &settings) != 0) fail(path, "cannot be set up", errno);
  ask_for_low_latency(fd.get());
  tcflush(fd.get(), TCIOFLUSH);
  return fd;
}

}  // namespace haptic
