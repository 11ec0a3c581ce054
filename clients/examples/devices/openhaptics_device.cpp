// SPDX-License-Identifier: Apache-2.0
// Attaches a 3D Systems Touch through your own OpenHaptics: openhaptics_device LINK; hapticd finds
// it at LINK (kind = "own-device", docs/your-own-device.md). Compile it in clients/examples:
//   g++ -std=c++20 -O2 -I. devices/openhaptics_device.cpp -o openhaptics_device -lHD -pthread
// with -I and -L of your SDK where it is not installed for all; or try it without a device and an
// SDK: -Idevices/stubs devices/stubs/hd.cpp stand_in_sdk.cpp in place of -lHD.
//
// NOT TRIED ON HARDWARE. The names and rules are from the vendor's published manual; the program
// has met the stub in devices/stubs alone. Begin with `hapt devices try own-device --path LINK`, a
// hand on the plug.
//
// OpenHaptics calls servo() from a thread of its own, a thousand times a second. That thread and
// the one that answers hapticd exchange numbers without a lock: neither may wait for the other, as
// the answer is due within a tick and a late callback is a device that buzzes. For the same reason
// the answer does not come through hdScheduleSynchronous, which waits for the next callback, up to
// a millisecond, and for ever where the scheduler has died.
#include <HD/hd.h>
#include <own_device_line.h>

#include <atomic>
#include <thread>
#include <utility>

namespace {

/// Numbers of one instant, from one thread to one other. Each value is stored with release and
/// loaded with acquire, so a reader that sees a new one also sees that the version has changed.
template <size_t n>
class Newest {
 public:
  void write(const std::array<double, n>& values) {
    const unsigned version = version_.load(std::memory_order_relaxed);
    version_.store(version + 1, std::memory_order_relaxed);  // odd: not whole
    for (size_t i = 0; i < n; ++i) values_[i].store(values[i], std::memory_order_release);
    version_.store(version + 2, std::memory_order_release);
  }
  /// Leaves `kept` as it is where the other thread is writing just now: it does not wait.
  void read(std::array<double, n>& kept) const {
    std::array<double, n> values;
    const unsigned version = version_.load(std::memory_order_acquire);
    for (size_t i = 0; i < n; ++i) values[i] = values_[i].load(std::memory_order_acquire);
    if (version % 2 == 0 && version_.load(std::memory_order_relaxed) == version) kept = values;
  }

 private:
  std::atomic<unsigned> version_{0};
  std::array<std::atomic<double>, n> values_{};
};

// OpenHaptics has x to the right, y up, z to the user
constexpr size_t kAxis[3] = {2, 0, 1};  // of OpenHaptics, which are x, y, z of B
constexpr double kMillimetre = 1e-3;
constexpr double kOldestPose = 5e-3;         // that is answered with [s]
constexpr double kOldestForce = 0.1;         // as the line's watchdog, should that thread hang [s]
constexpr size_t kButtons = 12, kWhen = 13;  // after three of the place and nine of the rotation

Newest<14> pose_of_device;   // written by servo()
Newest<4> force_of_hapticd;  // read by servo(): in B [N], and when it was asked for [s]
std::atomic<HDerror> failure{HD_SUCCESS};
std::atomic<bool> wants_inkwell{false};
HHD touch = HD_INVALID_HANDLE;
HDenum calibration_style = 0;  // 0: only its owner can calibrate it

double seconds() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

/// True: OpenHaptics drops the force for a while, and the device is well.
bool is_passing(HDerror error) {
  return error == HD_EXCEEDED_MAX_FORCE || error == HD_EXCEEDED_MAX_FORCE_IMPULSE ||
         error == HD_EXCEEDED_MAX_VELOCITY || error == HD_FORCE_ERROR || error == HD_WARM_MOTORS;
}

/// Takes the errors off the SDK's stack; the first that does not pass is kept.
void note_errors() {
  for (HDErrorInfo error = hdGetError(); HD_DEVICE_ERROR(error); error = hdGetError()) {
    if (!is_passing(error.errorCode) && failure == HD_SUCCESS) failure = error.errorCode;
  }
}

/// True: places are absolute. A Touch is calibrated in its inkwell, of itself once it is there.
bool is_calibrated() {
  const HDenum status = hdCheckCalibration();
  wants_inkwell = status == HD_CALIBRATION_NEEDS_MANUAL_INPUT;
  if (status == HD_CALIBRATION_NEEDS_UPDATE && calibration_style != 0) {
    hdUpdateCalibration(calibration_style);
  }
  return status == HD_CALIBRATION_OK;
}

/// In OpenHaptics' thread: sends the newest force and publishes the pose.
HDCallbackCode HDCALLBACK servo(void* /*nothing*/) {
  static std::array<double, 4> force{};
  const bool good = is_calibrated() && failure == HD_SUCCESS;
  const double now = seconds();
  HDdouble columns[16] = {}, f[3] = {};  // of the matrix, one after another
  HDint buttons = 0;
  hdBeginFrame(touch);
  hdGetDoublev(HD_CURRENT_TRANSFORM, columns);
  hdGetIntegerv(HD_CURRENT_BUTTONS, &buttons);
  force_of_hapticd.read(force);
  const bool pushes = good && now - force[3] < kOldestForce;
  for (size_t i = 0; i < 3; ++i) f[kAxis[i]] = pushes ? force[i] : 0;
  hdSetDoublev(HD_CURRENT_FORCE, f);
  hdEndFrame(touch);
  note_errors();
  if (!good || failure != HD_SUCCESS) return HD_CALLBACK_CONTINUE;  // with zero, and no pose

  std::array<double, 14> pose{};
  for (size_t i = 0; i < 3; ++i) {
    pose[i] = kMillimetre * columns[12 + kAxis[i]];
    for (size_t j = 0; j < 3; ++j) pose[3 + 3 * i + j] = columns[4 * kAxis[j] + kAxis[i]];
  }
  pose[kButtons] = buttons;
  pose[kWhen] = now;
  pose_of_device.write(pose);
  return HD_CALLBACK_CONTINUE;
}

std::array<double, 14> newest_pose{};  // of the thread that answers, as all below

bool open_touch() {
  touch = hdInitDevice(HD_DEFAULT_DEVICE);
  if (const HDErrorInfo error = hdGetError();
      HD_DEVICE_ERROR(error) || touch == HD_INVALID_HANDLE) {
    return std::fprintf(stderr, "OpenHaptics: %s\n", hdGetErrorString(error.errorCode)), false;
  }
  HDint styles = 0;
  hdGetIntegerv(HD_CALIBRATION_STYLE, &styles);
  for (const HDenum style : {HD_CALIBRATION_INKWELL, HD_CALIBRATION_AUTO}) {
    if ((static_cast<HDenum>(styles) & style) != 0) calibration_style = style;
  }
  hdEnable(HD_FORCE_OUTPUT);
  hdScheduleAsynchronous(servo, nullptr, HD_MAX_SCHEDULER_PRIORITY);
  hdStartScheduler();
  return true;  // an error of these is found by servo(), or there is no pose
}

void close_touch() {
  // the last force was zero: the scheduler sends it before it ends
  std::this_thread::sleep_for(std::chrono::milliseconds(5));
  hdStopScheduler();
  hdDisableDevice(touch);
}

/// Says why there is no pose, each reason once.
void tell_why(HDerror error) {
  static bool told_error = false, told_inkwell = false;
  if (error != HD_SUCCESS && !std::exchange(told_error, true)) {
    std::fprintf(stderr, "OpenHaptics: %s; start this again when it is mended\n",
                 hdGetErrorString(error));
  } else if (error == HD_SUCCESS && wants_inkwell && !std::exchange(told_inkwell, true)) {
    std::fputs("put the stylus into the inkwell\n", stderr);
  }
}

bool get_touch_pose(double p[3], double R[9]) {
  pose_of_device.read(newest_pose);
  const HDerror error = failure;
  if (error != HD_SUCCESS || seconds() - newest_pose[kWhen] > kOldestPose) {
    return tell_why(error), false;
  }
  std::copy_n(newest_pose.begin(), 3, p);
  std::copy_n(newest_pose.begin() + 3, 9, R);
  return true;
}

unsigned get_touch_buttons() {
  return static_cast<unsigned>(newest_pose[kButtons]) & 0xffU;
}

/// A Touch has no motors for a torque, which is dropped.
bool set_touch_force(const double f[3], const double /*t*/[3]) {
  force_of_hapticd.write({f[0], f[1], f[2], seconds()});
  const HDerror error = failure;
  return error == HD_SUCCESS ? true : (tell_why(error), false);
}

}  // namespace

int main(int argc, char** argv) {
  constexpr own_device::Sdk openhaptics{.open = open_touch,
                                        .close = close_touch,
                                        .get_pose = get_touch_pose,
                                        .get_buttons = get_touch_buttons,
                                        .set_force_and_torque = set_touch_force};
  return own_device::run("openhaptics_device", openhaptics, argc, argv);
}
