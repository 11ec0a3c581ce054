// SPDX-License-Identifier: Apache-2.0
// Prints where the tool is and what the hand feels, ten times a second, from C: 01_watch_c
// [session]
#include <hapticd/client_c.h>
#include <math.h>
#include <stdio.h>

static int failed(const char* message) {
  fprintf(stderr, "01_watch: %s\n", message);
  return 1;
}

int main(int argc, char** argv) {
  hapticd_session* session;
  hapticd_frames* frames;
  // no name: the only session that runs
  if (hapticd_attach(argc > 1 ? argv[1] : NULL, &session) != HAPTICD_OK ||
      hapticd_frames_open(session, HAPTICD_SERVO, 0, HAPTICD_FROM_NOW, &frames) != HAPTICD_OK) {
    return failed(hapticd_message());
  }
  hapticd_servo servo;
  servo.size = sizeof servo;
  hapticd_result result;
  do {
    hapticd_sleep(0.1);
    result = hapticd_frames_latest(frames);
    if (result == HAPTICD_OK) {
      hapticd_frames_servo(frames, &servo);
      const double *p = servo.X_WT.p, *f = servo.F_device_B.f;
      const double force = sqrt(f[0] * f[0] + f[1] * f[1] + f[2] * f[2]);
      printf("tool %8.4f %8.4f %8.4f m   force %5.2f N\n", p[0], p[1], p[2], force);
      fflush(stdout);
    } else if (result == HAPTICD_LOST) {
      fprintf(stderr, "hapticd was killed; waiting until it is back\n");
      result = hapticd_frames_reconnect(frames, -1);
    }
  } while (result == HAPTICD_OK || result == HAPTICD_NOTHING);
  if (result != HAPTICD_ENDED) return failed(hapticd_frames_message(frames));
  hapticd_frames_close(frames);
  hapticd_detach(session);
  return 0;
}
