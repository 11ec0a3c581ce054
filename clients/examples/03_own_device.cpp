// SPDX-License-Identifier: Apache-2.0
// Attaches a device that only its vendor's SDK can drive: 03_own_device LINK. The SDK runs in this
// process; hapticd finds a serial node at LINK (kind = "own-device"), whose line is described in
// docs/your-own-device.md and spoken by own_device_line.h. For your device replace stand_in_sdk.h
// and the five functions; devices/ has those of two vendors.
#include <own_device_line.h>
#include <stand_in_sdk.h>

int main(int argc, char** argv) {
  // this stand-in has the units, the frame and the calls that the line wants; with an SDK that has
  // others each of these is a function of yours, which converts
  constexpr own_device::Sdk stand_in{.open = sdk::open,
                                     .close = sdk::close,
                                     .get_pose = sdk::get_pose,
                                     .get_buttons = sdk::get_buttons,
                                     .set_force_and_torque = sdk::set_force_and_torque};
  return own_device::run("03_own_device", stand_in, argc, argv);
}
