// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <fcntl.h>
#include <poll.h>
#include <pty.h>
#include <sched.h>
#include <termios.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <chrono>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <numbers>
#include <string>

/// The line of docs/your-own-device.md, all of it but the vendor's SDK: a program that attaches a
/// device is run() with five functions of its own. It needs nothing of hapticd.
namespace own_device {

/// A device in SI units and in the frame B of hapticd: x to the user, y to the right, z up,
/// right-handed. One thread calls all of these.
struct Sdk {
  bool (*open)();   // false: there is no device, or another program has it
  void (*close)();  // switches the motors off
  /// Place of the handle [m] and its rotation, three rows of a matrix whose columns are the
  /// handle's axes in B. False: the device does not answer.
  bool (*get_pose)(double p[3], double R[9]);
  unsigned (*get_buttons)();  // one bit a button, up to eight; of the pose asked for before
  /// On the hand, until the next call [N, N·m]. False: the device does not answer.
  bool (*set_force_and_torque)(const double f[3], const double t[3]);
};

inline constexpr int kModel = 7, kOneButton = 256;    // of the line: its kind, and a button beside
inline constexpr double kMetre = 1e6, kRadian = 1e5;  // counts
inline constexpr double kNewton = 5e-3, kNewtonMetre = 1e-4;  // of a number
inline constexpr int kMostNumber = 6000;                      // beyond it, zero
inline constexpr auto kWatchdog = std::chrono::milliseconds(100);

inline volatile std::sig_atomic_t stopped = 0;

/// Rotation vector of a matrix [rad]; of all that mean this rotation the nearest to `last`, so that
/// a handle that turns past half a turn does not jump.
inline std::array<double, 3> rotation_vector(const double R[9], const std::array<double, 3>& last) {
  // 4 q qᵀ; its longest row is well defined for every angle (Shepperd 1978)
  const double a = R[7] - R[5], b = R[2] - R[6], c = R[3] - R[1];
  const double d = R[1] + R[3], e = R[2] + R[6], f = R[5] + R[7];
  const double rows[4][4] = {{1 + R[0] + R[4] + R[8], a, b, c},
                             {a, 1 + R[0] - R[4] - R[8], d, e},
                             {b, d, 1 - R[0] + R[4] - R[8], f},
                             {c, e, f, 1 - R[0] - R[4] + R[8]}};
  int best = 0;
  for (int i = 1; i < 4; ++i) best = rows[i][i] > rows[best][best] ? i : best;
  const double* q = rows[best];
  const double sine = std::hypot(q[1], q[2], q[3]);
  if (sine == 0) return {};
  const std::array<double, 3> axis{q[1] / sine, q[2] / sine, q[3] / sine};
  const double angle = 2 * std::atan2(sine, q[0]), turn = 2 * std::numbers::pi;
  const double along = axis[0] * last[0] + axis[1] * last[1] + axis[2] * last[2];
  const double nearest = angle + turn * std::round((along - angle) / turn);
  return {nearest * axis[0], nearest * axis[1], nearest * axis[2]};
}

/// Finds lines in the host's bytes.
class Lines {
 public:
  std::array<int, 6> numbers{};
  int error = 0;  // of the line: not zero, it has no numbers

  /// True: this byte ends a line.
  bool take(char byte) {
    if (byte == '[') return text_.clear(), inside_ = true, false;
    if (inside_ && byte != ']') text_ += byte;
    if (byte != ']' && text_.size() < 127) return false;
    error = byte != ']' ? 128 : inside_ ? read() : 256;
    inside_ = false;
    return text_.clear(), true;
  }

 private:
  int read() {
    if (std::count(text_.begin(), text_.end(), ',') != 5) return 512;
    const char *at = text_.data(), *end = at + text_.size();
    for (int& number : numbers) {
      const auto [after, bad] = std::from_chars(at, end, number);
      if (bad != std::errc{} || (after != end && *after != ',')) return 1024;
      if (std::abs(number) > kMostNumber) number = 0;
      at = after + (after != end);
    }
    return 0;
  }

  std::string text_;
  bool inside_ = false;
};

/// Lets the hand feel the numbers of a line; false: the device does not answer.
inline bool feel(const Sdk& sdk, const std::array<int, 6>& n) {
  constexpr double f = kNewton, t = kNewtonMetre;
  const double force[3] = {f * n[0], f * n[1], f * n[2]};
  const double torque[3] = {t * n[3], t * n[4], t * n[5]};
  return sdk.set_force_and_torque(force, torque);
}

/// Answers each line with the pose of that instant. A device that fails is not answered for, and
/// hapticd takes it as lost after 20 ms.
inline void serve(const Sdk& sdk, int pty) {
  Lines lines;
  std::array<double, 3> r{};
  bool on = false;
  auto heard = std::chrono::steady_clock::now();
  while (stopped == 0) {
    pollfd wait{pty, POLLIN, 0};
    poll(&wait, 1, 10);
    char bytes[256];
    const ssize_t n = read(pty, bytes, sizeof bytes);
    for (ssize_t i = 0; i < n; ++i) {
      if (!lines.take(bytes[i])) continue;
      if (lines.error == 0) {
        heard = std::chrono::steady_clock::now(), on = feel(sdk, lines.numbers);
      }
      double p[3], R[9];
      if ((lines.error == 0 && !on) || !sdk.get_pose(p, R)) continue;
      r = rotation_vector(R, r);
      char text[128];
      const int size = std::snprintf(
          text, sizeof text, "[%u,%ld,%ld,%ld,%ld,%ld,%ld,%d]\n",
          kModel + kOneButton * sdk.get_buttons(), std::lround(kMetre * p[0]),
          std::lround(kMetre * p[1]), std::lround(kMetre * p[2]), std::lround(kRadian * r[0]),
          std::lround(kRadian * r[1]), std::lround(kRadian * r[2]), lines.error);
      if (write(pty, text, static_cast<size_t>(size)) < 0) continue;  // nobody reads
    }
    // neither the servo nor hapticd is there
    if (on && std::chrono::steady_clock::now() - heard > kWatchdog) on = !feel(sdk, {});
  }
  feel(sdk, {});
}

/// A pseudo-terminal at LINK, this end of which is returned; −1: there is none. The other end stays
/// open too, so that the device is there whether hapticd is or not.
inline int open_link(const char* link) {
  int pty = -1, kept = -1;
  char name[64];
  termios raw{};
  cfmakeraw(&raw);
  if (readlink(link, name, sizeof name) >= 0) unlink(link);  // left by a killed one
  if (openpty(&pty, &kept, name, &raw, nullptr) != 0 || symlink(name, link) != 0) return -1;
  fcntl(pty, F_SETFL, O_NONBLOCK);
  return pty;
}

/// The whole of `PROGRAM LINK`, until a signal ends it; its exit code.
inline int run(const char* program, const Sdk& sdk, int argc, char** argv) {
  if (argc != 2 || argv[1][0] == '-') return std::printf("usage: %s LINK\n", program), 2;
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) std::signal(signal, [](int) { stopped = 1; });
  if (!sdk.open()) {
    return std::fprintf(stderr, "%s: no device; is it plugged in?\n", program), 1;
  }
  const int pty = open_link(argv[1]);
  if (pty < 0) {
    std::perror(argv[1]);
    return sdk.close(), 1;
  }
  const sched_param above{50};
  sched_setscheduler(0, SCHED_FIFO, &above);  // without the right, answers may come late
  serve(sdk, pty);
  sdk.close();
  unlink(argv[1]);
  return 0;
}

}  // namespace own_device
