// SPDX-License-Identifier: Apache-2.0
// Attaches an omega, delta, sigma or lambda, or a Falcon, through your own Force Dimension SDK:
// force_dimension_device LINK; hapticd finds it at LINK (kind = "own-device",
// docs/your-own-device.md). Compile it in clients/examples, in one line, with your SDK in $SDK:
//   g++ -std=c++20 -O2 -I. -I$SDK/include devices/force_dimension_device.cpp
//       -o force_dimension_device -L$SDK/lib -ldhd -lusb-1.0 -lrt -ldl -pthread
// with -L of the folder in which its libdhd lies; or try it without a device and an SDK:
// -Idevices/stubs devices/stubs/dhdc.cpp stand_in_sdk.cpp in place of -I, -L and the libraries.
//
// NOT TRIED ON HARDWARE. The names and rules are from the vendor's published manual; the program
// has met the stub in devices/stubs alone. Begin with `hapt devices try own-device --path LINK`, a
// hand on the plug. Calibrate the device before, as its manual says: a place from before counts as
// any other here.
//
// DHD calls nobody back: one thread asks for the pose and sets the force, within the answer to
// each line. Should that thread hang within the SDK, the device holds its last force, unless its
// own watchdog ends it; find out whether yours has one.
#include <dhdc.h>
#include <own_device_line.h>

namespace {

constexpr int kButtonsOfLine = 8;

bool has_wrist = false;  // without one the handle does not turn
bool is_lost = false;

/// False, and says why, once, if the SDK reports an error. What is above zero is a remark: the
/// motors are at their limit, or the device was asked sooner than it measures.
bool is_fine(int result) {
  if (result >= DHD_NO_ERROR) return true;
  if (!is_lost) std::fprintf(stderr, "Force Dimension: %s\n", dhdErrorGetLastStr());
  is_lost = true;
  return false;
}

bool open_dhd() {
  if (!is_fine(dhdOpen())) return false;
  has_wrist = dhdHasWrist();
  if (is_fine(dhdEnableForce(DHD_ON))) return true;
  dhdClose();
  return false;
}

void close_dhd() {
  dhdEnableForce(DHD_OFF);
  dhdClose();
}

/// DHD has the units and the frame of B. A device that was lost stays so until this is started
/// again: its handle may have been anywhere meanwhile.
bool get_dhd_pose(double p[3], double R[9]) {
  double frame[3][3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  if (is_lost || !is_fine(has_wrist ? dhdGetPositionAndOrientationFrame(&p[0], &p[1], &p[2], frame)
                                    : dhdGetPosition(&p[0], &p[1], &p[2]))) {
    return false;
  }
  for (int i = 0; i < 9; ++i) R[i] = frame[i / 3][i % 3];
  return true;
}

unsigned get_dhd_buttons() {
  unsigned pressed = 0;
  // a button that the device has not is an error of its own, and none of the device
  for (int i = 0; i < kButtonsOfLine; ++i) pressed |= dhdGetButton(i) == DHD_ON ? 1U << i : 0;
  return pressed;
}

/// A torque is dropped by a device without motors in its wrist. A gripper is left without force.
bool set_dhd_force(const double f[3], const double t[3]) {
  return !is_lost &&
         is_fine(dhdSetForceAndTorqueAndGripperForce(f[0], f[1], f[2], t[0], t[1], t[2], 0));
}

}  // namespace

int main(int argc, char** argv) {
  constexpr own_device::Sdk force_dimension{.open = open_dhd,
                                            .close = close_dhd,
                                            .get_pose = get_dhd_pose,
                                            .get_buttons = get_dhd_buttons,
                                            .set_force_and_torque = set_dhd_force};
  return own_device::run("force_dimension_device", force_dimension, argc, argv);
}
