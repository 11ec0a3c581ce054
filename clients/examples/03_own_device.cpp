// SPDX-License-Identifier: Apache-2.0
// Attaches a device that only its vendor's SDK can drive: 03_own_device LINK. The SDK runs in this
// process; hapticd finds a serial node at LINK (kind = "own-device"), whose line is described in
// docs/your-own-device.md. For your device replace stand_in_sdk.h and what is called in sdk::.
#include <fcntl.h>
#include <poll.h>
#include <pty.h>
#include <sched.h>
#include <stand_in_sdk.h>
#include <termios.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <chrono>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <numbers>
#include <string>

namespace {

constexpr int kModel = 7, kOneButton = 256;    // of the line: its kind, and a button beside it
constexpr double kMetre = 1e6, kRadian = 1e5;  // counts
constexpr double kNewton = 5e-3, kNewtonMetre = 1e-4;  // of a number
constexpr int kMostNumber = 6000;                      // beyond it, zero
constexpr auto kWatchdog = std::chrono::milliseconds(100);

volatile std::sig_atomic_t stopped = 0;

/// Rotation vector of a matrix [rad]; of all that mean this rotation the nearest to `last`, so that
/// a handle that turns past half a turn does not jump.
std::array<double, 3> rotation_vector(const double R[9], const std::array<double, 3>& last) {
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

bool feel(const std::array<int, 6>& n) {
  constexpr double f = kNewton, t = kNewtonMetre;
  const double force[3] = {f * n[0], f * n[1], f * n[2]};
  const double torque[3] = {t * n[3], t * n[4], t * n[5]};
  return sdk::set_force_and_torque(force, torque);
}

/// Answers each line with the pose of that instant. A device that fails is not answered for, and
/// hapticd takes it as lost after 20 ms.
void serve(int pty) {
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
      if (lines.error == 0) heard = std::chrono::steady_clock::now(), on = feel(lines.numbers);
      double p[3], R[9];
      if ((lines.error == 0 && !on) || !sdk::get_pose(p, R)) continue;
      r = rotation_vector(R, r);
      char text[128];
      const int size = std::snprintf(
          text, sizeof text, "[%u,%ld,%ld,%ld,%ld,%ld,%ld,%d]\n",
          kModel + kOneButton * sdk::get_buttons(), std::lround(kMetre * p[0]),
          std::lround(kMetre * p[1]), std::lround(kMetre * p[2]), std::lround(kRadian * r[0]),
          std::lround(kRadian * r[1]), std::lround(kRadian * r[2]), lines.error);
      if (write(pty, text, static_cast<size_t>(size)) < 0) continue;  // nobody reads
    }
    // neither the servo nor hapticd is there
    if (on && std::chrono::steady_clock::now() - heard > kWatchdog) on = !feel({});
  }
  feel({});
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2 || argv[1][0] == '-') return std::puts("usage: 03_own_device LINK"), 2;
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) std::signal(signal, [](int) { stopped = 1; });
  // this end of the pty stays open, so that the device is there whether hapticd is or not
  int pty = -1, kept = -1;
  char name[64];
  termios raw{};
  cfmakeraw(&raw);
  if (!sdk::open()) return std::fputs("03_own_device: no device; is it plugged in?\n", stderr), 1;
  if (readlink(argv[1], name, sizeof name) >= 0) unlink(argv[1]);  // left by a killed one
  if (openpty(&pty, &kept, name, &raw, nullptr) != 0 || symlink(name, argv[1]) != 0) {
    return std::perror(argv[1]), 1;
  }
  fcntl(pty, F_SETFL, O_NONBLOCK);
  const sched_param above{50};
  sched_setscheduler(0, SCHED_FIFO, &above);  // without the right, answers may come late
  serve(pty);
  sdk::close();
  unlink(argv[1]);
}
