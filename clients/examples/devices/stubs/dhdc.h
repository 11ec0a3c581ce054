// SPDX-License-Identifier: Apache-2.0
#pragma once

/// Stands in for the Force Dimension SDK's dhdc.h, so that force_dimension_device.cpp can be
/// compiled and tested without it: those names that it uses, with what the vendor's published
/// manual says of them. devices/stubs/dhdc.cpp has a simulated device behind them.

enum { DHD_NO_ERROR = 0 };
enum { DHD_OFF = 0, DHD_ON = 1 };

/// The number of the device; −1: there is none. All others but dhdHasWrist and dhdGetButton: zero
/// or a remark above it, −1 after an error. `id` −1 is the device that was opened last.
int dhdOpen();
int dhdClose(char id = -1);
const char* dhdErrorGetLastStr();

bool dhdHasWrist(char id = -1);
/// DHD_ON or DHD_OFF; −1: there is no such button.
int dhdGetButton(int index, char id = -1);

int dhdEnableForce(unsigned char on, char id = -1);
/// [m], and the rows of a matrix whose columns are the handle's axes.
int dhdGetPosition(double* x, double* y, double* z, char id = -1);
int dhdGetPositionAndOrientationFrame(double* x, double* y, double* z, double frame[3][3],
                                      char id = -1);
/// [N], [N·m]; the gripper's [N].
int dhdSetForceAndTorqueAndGripperForce(double fx, double fy, double fz, double tx, double ty,
                                        double tz, double gripper, char id = -1);
