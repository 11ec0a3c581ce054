// SPDX-License-Identifier: Apache-2.0
// A simulated sigma behind the names of dhdc.h: the hand of stand_in_sdk.cpp, which has DHD's units
// and axes. A force that it has not tears its plug out.
#include <dhdc.h>
#include <stand_in_sdk.h>
#include <torn_plug.h>

namespace {

bool forced = false, unplugged = false;

}  // namespace

int dhdOpen() {
  return sdk::open() ? 0 : -1;
}

int dhdClose(char) {
  sdk::close();
  return 0;
}

const char* dhdErrorGetLastStr() {
  return "the plug is out";
}

bool dhdHasWrist(char) {
  return true;
}

int dhdGetButton(int index, char) {
  if (unplugged || index != 0) return -1;
  return sdk::get_buttons() != 0 ? DHD_ON : DHD_OFF;
}

int dhdEnableForce(unsigned char on, char) {
  forced = on == DHD_ON;
  return 0;
}

int dhdGetPosition(double* x, double* y, double* z, char id) {
  double frame[3][3];
  return dhdGetPositionAndOrientationFrame(x, y, z, frame, id);
}

int dhdGetPositionAndOrientationFrame(double* x, double* y, double* z, double frame[3][3], char) {
  if (unplugged) return -1;
  double p[3], R[9];
  sdk::get_pose(p, R);
  *x = p[0], *y = p[1], *z = p[2];
  for (int i = 0; i < 9; ++i) frame[i / 3][i % 3] = R[i];
  return 0;
}

int dhdSetForceAndTorqueAndGripperForce(double fx, double fy, double fz, double tx, double ty,
                                        double tz, double, char) {
  const double force[3] = {fx, fy, fz}, torque[3] = {tx, ty, tz};
  unplugged = unplugged || tears_plug_out(force);
  if (unplugged) return -1;
  if (forced) sdk::set_force_and_torque(force, torque);
  return 0;
}
