// SPDX-License-Identifier: Apache-2.0
#pragma once

/// Functions as vendors offer them in their SDKs, in SI units and in the frame B of hapticd: x to
/// the user, y to the right, z up, right-handed (as Force Dimension's). This stand-in plays a hand
/// that sinks 10 mm below z = 0, comes up 30 mm and tilts its handle meanwhile.
namespace sdk {

/// False: there is no device, or another program has it.
bool open();
/// Switches the motors off.
void close();

/// Place of the handle [m] and its rotation, three rows of a matrix whose columns are the handle's
/// axes in B. False: the device does not answer.
bool get_pose(double p[3], double R[9]);
/// One bit a button.
unsigned get_buttons();
/// On the hand, in B [N, N·m]. It holds until the next call. False: the device does not answer.
bool set_force_and_torque(const double f[3], const double t[3]);

}  // namespace sdk
