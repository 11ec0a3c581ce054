// SPDX-License-Identifier: Apache-2.0
// A simulated Touch behind the names of HD/hd.h: the hand of stand_in_sdk.cpp in OpenHaptics' units
// and axes, with a scheduler of a thousand callbacks a second. It is to be calibrated once, and a
// force that no Touch has tears its plug out.
#include <HD/hd.h>
#include <stand_in_sdk.h>
#include <torn_plug.h>

#include <array>
#include <atomic>
#include <chrono>
#include <thread>

namespace {

using Clock = std::chrono::steady_clock;

HDSchedulerCallback scheduled = nullptr;
void* scheduled_data = nullptr;
std::thread scheduler;
std::atomic<bool> ends{false};
bool enabled = false, calibrated = false;
bool torn = false, told = false;  // without its plug; told in this frame

void call_back_each_millisecond() {
  for (auto next = Clock::now(); !ends; std::this_thread::sleep_until(next)) {
    next += std::chrono::milliseconds(1);
    if (scheduled(scheduled_data) == HD_CALLBACK_DONE) return;
  }
}

}  // namespace

HHD hdInitDevice(HDstring) {
  return sdk::open() ? 0U : static_cast<HHD>(HD_INVALID_HANDLE);
}

void hdDisableDevice(HHD) {
  sdk::close();
}

void hdEnable(HDenum capability) {
  enabled = enabled || capability == HD_FORCE_OUTPUT;
}

HDSchedulerHandle hdScheduleAsynchronous(HDSchedulerCallback callback, void* data, HDushort) {
  scheduled = callback;
  scheduled_data = data;
  return 1;
}

void hdStartScheduler() {
  scheduler = std::thread(call_back_each_millisecond);
}

void hdStopScheduler() {
  ends = true;
  scheduler.join();
}

void hdBeginFrame(HHD) {
  told = false;
}

void hdEndFrame(HHD) {}

// B has x to the user, y to the right, z up; OpenHaptics has x to the right, y up, z to the user
void hdGetDoublev(HDenum, HDdouble* m) {
  double p[3], R[9];
  sdk::get_pose(p, R);
  const std::array<HDdouble, 16> columns{R[4],       R[7],       R[1],       0,  //
                                         R[5],       R[8],       R[2],       0,  //
                                         R[3],       R[6],       R[0],       0,  //
                                         1e3 * p[1], 1e3 * p[2], 1e3 * p[0], 1};
  for (size_t i = 0; i < columns.size(); ++i) m[i] = columns[i];
}

void hdGetIntegerv(HDenum name, HDint* values) {
  *values = name == HD_CALIBRATION_STYLE ? static_cast<HDint>(HD_CALIBRATION_INKWELL)
                                         : static_cast<HDint>(sdk::get_buttons());
}

void hdSetDoublev(HDenum, const HDdouble* f) {
  torn = torn || tears_plug_out(f);
  if (torn || !enabled) return;
  const double force_B[3] = {f[2], f[0], f[1]}, no_torque[3] = {};
  sdk::set_force_and_torque(force_B, no_torque);
}

HDenum hdCheckCalibration() {
  return calibrated ? HD_CALIBRATION_OK : HD_CALIBRATION_NEEDS_UPDATE;
}

void hdUpdateCalibration(HDenum style) {
  calibrated = style == HD_CALIBRATION_INKWELL;
}

HDErrorInfo hdGetError() {
  const bool tells = torn && !told;
  told = told || tells;
  return {tells ? HD_COMM_ERROR : HD_SUCCESS, 0, 0};
}

HDstring hdGetErrorString(HDerror) {
  return "the plug is out";
}
