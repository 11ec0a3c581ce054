// SPDX-License-Identifier: GPL-3.0-or-later
// Two sessions that run are watched, changed and given to: live WATCHED GIVEN. The first is of
// configs/plane.toml, the second of configs/give.toml; live.sh starts them and kills the first.
#include <hapticd/client_c.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "check.h"

static hapticd_frames* opened(hapticd_session* session, hapticd_ring ring, hapticd_start start) {
  hapticd_frames* frames;
  CHECK(hapticd_frames_open(session, ring, 0, start, &frames) == HAPTICD_OK);
  return frames;
}

static void check_open(hapticd_session* session) {
  hapticd_frames* frames;
  CHECK(hapticd_frames_open(session, (hapticd_ring)9, 0, HAPTICD_FROM_NOW, &frames) ==
        HAPTICD_BAD_ARGUMENT);
  CHECK(hapticd_frames_open(session, HAPTICD_SERVO, 99, HAPTICD_FROM_NOW, &frames) ==
        HAPTICD_BAD_ARGUMENT);
  CHECK(hapticd_frames_open(session, HAPTICD_SIM, 1, HAPTICD_FROM_NOW, &frames) ==
        HAPTICD_BAD_ARGUMENT);
  CHECK(hapticd_frames_open(session, HAPTICD_SERVO, 0, (hapticd_start)7, &frames) ==
        HAPTICD_BAD_ARGUMENT);
  CHECK(strcmp(hapticd_session_message(session), "there is no such start") == 0);
  CHECK(hapticd_frames_open(session, HAPTICD_SERVO, 0, HAPTICD_FROM_NOW, NULL) ==
        HAPTICD_BAD_ARGUMENT);
}

// A struct of another version: it gets what it has room for, and zeros where it has more.
static void check_sizes(hapticd_frames* frames, const hapticd_servo* whole) {
  struct {
    hapticd_servo known;
    double newer[2];
  } longer;
  memset(&longer, 0x5a, sizeof longer);
  longer.known.size = sizeof longer;
  CHECK(hapticd_frames_servo(frames, &longer.known) == HAPTICD_OK);
  CHECK(longer.known.size == sizeof longer && longer.known.tick == whole->tick);
  CHECK(longer.newer[0] == 0 && longer.newer[1] == 0);

  hapticd_servo shorter;
  memset(&shorter, 0x5a, sizeof shorter);
  const int64_t untouched = shorter.t_ns;
  shorter.size = offsetof(hapticd_servo, t_ns);
  CHECK(hapticd_frames_servo(frames, &shorter) == HAPTICD_OK);
  CHECK(shorter.tick == whole->tick && shorter.t_ns == untouched);

  shorter.size = 3;
  CHECK(hapticd_frames_servo(frames, &shorter) == HAPTICD_BAD_ARGUMENT);
  shorter.size = 0x5a5a5a5a;
  CHECK(hapticd_frames_servo(frames, &shorter) == HAPTICD_BAD_ARGUMENT);
  CHECK(strstr(hapticd_frames_message(frames), "set its size") != NULL);
  CHECK(hapticd_frames_servo(frames, NULL) == HAPTICD_BAD_ARGUMENT);
}

static void check_servo(hapticd_session* session) {
  hapticd_frames* frames = opened(session, HAPTICD_SERVO, HAPTICD_FROM_NOW);
  hapticd_servo servo;
  servo.size = sizeof servo;
  CHECK(hapticd_frames_servo(frames, &servo) == HAPTICD_NOTHING);
  CHECK(hapticd_frames_wait(frames, NAN) == HAPTICD_BAD_ARGUMENT);
  uint64_t tick = 0;
  double furthest = 0;
  for (int n = 0; n < 500; ++n) {
    CHECK(hapticd_frames_wait(frames, 2) == HAPTICD_OK);
    // the present record stays until the next one is read
    CHECK(n == 0 || (hapticd_frames_servo(frames, &servo) == HAPTICD_OK && servo.tick == tick));
    CHECK(hapticd_frames_next(frames) == HAPTICD_OK);
    CHECK(hapticd_frames_servo(frames, &servo) == HAPTICD_OK);
    CHECK(servo.tick > tick && servo.t_ns > 0);
    tick = servo.tick;
    const double* q = servo.X_WT.q;
    CHECK(fabs(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3] - 1) < 1e-9);
    furthest = fmax(furthest, fabs(servo.X_WT.p[0]) + fabs(servo.X_WT.p[1]));
  }
  CHECK(furthest > 0 && furthest < 1);
  CHECK(hapticd_frames_lost(frames) == 0);
  check_sizes(frames, &servo);

  const void* bytes;
  size_t size, count, one;
  CHECK(hapticd_frames_record(frames, &bytes, &size) == HAPTICD_OK);
  CHECK(size > sizeof servo && memcmp(bytes, &servo.tick, sizeof servo.tick) == 0);
  CHECK(hapticd_frames_list(frames, "pushes", &bytes, &count, &one) == HAPTICD_OK);
  CHECK(bytes != NULL && one == 12 * sizeof(double));
  CHECK(hapticd_frames_list(frames, "nothing", &bytes, &count, &one) == HAPTICD_BAD_ARGUMENT);
  CHECK(hapticd_frames_list(frames, "pushes", NULL, &count, &one) == HAPTICD_BAD_ARGUMENT);

  hapticd_scene scene;
  scene.size = sizeof scene;
  CHECK(hapticd_frames_scene(frames, &scene) == HAPTICD_BAD_ARGUMENT);
  CHECK(hapticd_frames_n_objects(frames) == 0);
  hapticd_frames_close(frames);
}

static void check_objects(hapticd_session* session) {
  hapticd_frames* frames = opened(session, HAPTICD_CONTACT, HAPTICD_FROM_OLDEST);
  CHECK(hapticd_frames_wait(frames, 5) == HAPTICD_OK);
  CHECK(hapticd_frames_latest(frames) == HAPTICD_OK);
  hapticd_contact_set set;
  set.size = sizeof set;
  CHECK(hapticd_frames_contact_set(frames, &set) == HAPTICD_OK);
  CHECK(set.n_objects == 1 && hapticd_frames_n_objects(frames) == 1);
  CHECK(set.n_contacts == hapticd_frames_n_contacts(frames));
  hapticd_contact contact;
  contact.size = sizeof contact;
  for (uint32_t i = 0; i < set.n_contacts; ++i) {
    CHECK(hapticd_frames_contact(frames, i, &contact) == HAPTICD_OK);
    const double* n = contact.normal_O;
    CHECK(contact.object == 0 && fabs(n[0] * n[0] + n[1] * n[1] + n[2] * n[2] - 1) < 1e-9);
  }
  CHECK(hapticd_frames_contact(frames, set.n_contacts, &contact) == HAPTICD_BAD_ARGUMENT);
  hapticd_object object;
  object.size = sizeof object;
  CHECK(hapticd_frames_object(frames, 0, &object) == HAPTICD_OK);
  CHECK(object.X_WO.q[3] == 1);
  CHECK(hapticd_frames_object(frames, 1, &object) == HAPTICD_BAD_ARGUMENT);
  hapticd_frames_close(frames);
}

static void check_control(hapticd_session* session) {
  const char* text = NULL;
  CHECK(hapticd_set(session, "stiffness", "777 N/m") == HAPTICD_OK);
  CHECK(hapticd_set(session, "stiffness", "1 kg") == HAPTICD_BAD_ARGUMENT);
  CHECK(strstr(hapticd_session_message(session), "is a mass") != NULL);
  CHECK(hapticd_set(session, "stiffness", "1 N/m\nstop") == HAPTICD_BAD_ARGUMENT);
  CHECK(hapticd_set(session, NULL, "1 N/m") == HAPTICD_BAD_ARGUMENT);
  CHECK(hapticd_say(session, "", NULL) == HAPTICD_BAD_ARGUMENT);
  CHECK(hapticd_pause(session) == HAPTICD_OK);
  CHECK(hapticd_disarm(session) == HAPTICD_OK);

  hapticd_frames* frames = opened(session, HAPTICD_CONTROL, HAPTICD_FROM_OLDEST);
  CHECK(hapticd_frames_latest(frames) == HAPTICD_OK);
  hapticd_control control;
  control.size = sizeof control;
  CHECK(hapticd_frames_control(frames, &control) == HAPTICD_OK);
  CHECK(control.paused == 1 && control.armed == 0 && control.translational_stiffness == 777);
  hapticd_frames_close(frames);

  CHECK(hapticd_arm(session) == HAPTICD_OK);
  CHECK(hapticd_resume(session) == HAPTICD_OK);
  CHECK(hapticd_status(session, &text) == HAPTICD_OK);
  CHECK(text[0] == '{' && strstr(text, hapticd_name(session)) != NULL);
  CHECK(hapticd_say(session, "config", &text) == HAPTICD_OK);
  CHECK(strstr(text, "[[object]]") != NULL);
}

// How often these bytes are in the memory that this process shows to viewers.
static int n_drawn(const void* bytes, size_t size) {
  FILE* maps = fopen("/proc/self/maps", "r");
  char line[512];
  int n = 0;
  CHECK(maps != NULL);
  while (fgets(line, sizeof line, maps) != NULL) {
    unsigned long begin, end;
    if (strstr(line, "draw0") == NULL || sscanf(line, "%lx-%lx", &begin, &end) != 2) continue;
    for (const char* at = (const char*)begin; at + size <= (const char*)end; at += 8) {
      n += memcmp(at, bytes, size) == 0;
    }
  }
  fclose(maps);
  return n;
}

static void check_draw(hapticd_giver* giver) {
  static hapticd_point points[3000];
  for (int i = 0; i < 3000; ++i) {
    points[i] = (hapticd_point){{i, 2, 3}, 0.5, (uint32_t)i, 0};
  }
  const hapticd_line lines[2] = {{{1, 2, 3}, {4, 5, 6}, 0x102030, 0}, {{7, 8, 9}, {0, 0, 0}, 1, 0}};
  CHECK(hapticd_giver_draw(NULL, points, 1, NULL, 0) == HAPTICD_BAD_ARGUMENT);
  CHECK(hapticd_giver_draw(giver, NULL, 1, NULL, 0) == HAPTICD_BAD_ARGUMENT);
  CHECK(hapticd_giver_draw(giver, points, 3000, lines, 2) == HAPTICD_BAD_ARGUMENT);
  CHECK(strstr(hapticd_giver_message(giver), "point 1001 of a drawing cannot be shown") != NULL);
  for (int i = 0; i < 3000; ++i) points[i].p[0] = 1e-3 * i;
  CHECK(n_drawn(&points[2999], sizeof points[2999]) == 0);
  CHECK(hapticd_giver_draw(giver, points, 3000, lines, 2) == HAPTICD_OK);
  CHECK(n_drawn(&points[0], sizeof points[0]) == 1);
  CHECK(n_drawn(&points[2999], sizeof points[2999]) == 1);
  CHECK(n_drawn(&lines[1], sizeof lines[1]) == 1);
  // a loop without a pause draws too often, and one that pauses does not
  hapticd_result result = HAPTICD_OK;
  for (int n = 0; n < 1000 && result == HAPTICD_OK; ++n) {
    result = hapticd_giver_draw(giver, points, 1, NULL, 0);
  }
  CHECK(result == HAPTICD_NOTHING);
  hapticd_sleep(0.1);
  CHECK(hapticd_giver_draw(giver, NULL, 0, NULL, 0) == HAPTICD_OK);
  static hapticd_point many[200001];
  CHECK(hapticd_giver_draw(giver, many, 200001, NULL, 0) == HAPTICD_BAD_ARGUMENT);
  CHECK(strstr(hapticd_giver_message(giver), "at most 200000 are shown") != NULL);
}

// A ball on a spring, which the hand pushes; it is where sim says it is.
static void check_give(hapticd_session* session) {
  hapticd_giver* giver;
  CHECK(hapticd_give(session, "nobody", &giver) == HAPTICD_REFUSED);
  CHECK(giver == NULL);
  CHECK(hapticd_give(session, "ball", &giver) == HAPTICD_OK);
  hapticd_motion motion;
  memset(&motion, 0, sizeof motion);
  motion.size = sizeof motion;
  CHECK(hapticd_giver_object(giver, "bell", &motion.object) == HAPTICD_BAD_ARGUMENT);
  CHECK(strstr(hapticd_giver_message(giver), "ball") != NULL);
  CHECK(hapticd_giver_object(giver, "ball", &motion.object) == HAPTICD_OK);
  CHECK(hapticd_giver_move(giver, &motion) == HAPTICD_BAD_ARGUMENT);  // no rotation
  motion.X_WO.q[3] = 1;
  for (int i = 0; i < 3; ++i) {
    motion.mobility[7 * i] = 1 / 0.1;
    motion.stiffness[7 * i] = 200;
    motion.damping[7 * i] = 0.5;
  }
  hapticd_push push;
  push.size = sizeof push;
  CHECK(hapticd_giver_pushed(giver, 99, &push) == HAPTICD_BAD_ARGUMENT);
  CHECK(hapticd_giver_pushed(giver, motion.object, NULL) == HAPTICD_BAD_ARGUMENT);
  CHECK(hapticd_giver_publish(giver) == HAPTICD_OK);

  hapticd_frames* frames = opened(session, HAPTICD_SIM, HAPTICD_FROM_NOW);
  hapticd_object object;
  object.size = sizeof object;
  object.mover = 0;
  double impulse = 0, furthest = 0;
  double *p = motion.X_WO.p, *v = motion.V_WO.v;
  for (int n = 0; n < 120; ++n) {
    CHECK(hapticd_giver_pushed(giver, motion.object, &push) == HAPTICD_OK);
    for (double t = 0; t < push.span; t += 1e-4) {
      for (int i = 0; i < 3; ++i) {
        const double f = push.mean[i] + (t - 0.5 * push.span) * push.slope[i];
        v[i] += 1e-4 / 0.1 * (f - 200 * p[i] - 0.5 * v[i]);
        p[i] += 1e-4 * v[i];
        impulse += 1e-4 * fabs(f);
      }
    }
    for (int i = 0; i < 3; ++i) motion.acceleration_W.v[i] = (-200 * p[i] - 0.5 * v[i]) / 0.1;
    CHECK(hapticd_giver_move(giver, &motion) == HAPTICD_OK);
    CHECK(hapticd_giver_publish(giver) == HAPTICD_OK);
    if (hapticd_frames_latest(frames) == HAPTICD_OK) {
      CHECK(hapticd_frames_object(frames, motion.object, &object) == HAPTICD_OK);
      for (int i = 0; i < 3; ++i) furthest = fmax(furthest, fabs(object.X_WO.p[i]));
    }
    hapticd_sleep(0.01);
  }
  CHECK(object.mover == 1);
  printf("impulse %.4f N·s, furthest %.4f m\n", impulse, furthest);
  CHECK(impulse > 0 && furthest > 1e-4 && furthest < 0.05);
  hapticd_frames_close(frames);

  motion.power = NAN;
  CHECK(hapticd_giver_move(giver, &motion) == HAPTICD_BAD_ARGUMENT);
  motion.power = 0;
  motion.size -= 1;
  CHECK(hapticd_giver_move(giver, &motion) == HAPTICD_BAD_ARGUMENT);
  struct {
    hapticd_motion known;
    double newer;
  } longer = {motion, 0};
  longer.known.size = sizeof longer;
  CHECK(hapticd_giver_move(giver, &longer.known) == HAPTICD_OK);
  longer.newer = 1;
  CHECK(hapticd_giver_move(giver, &longer.known) == HAPTICD_BAD_ARGUMENT);

  check_draw(giver);

  // the frames and the giver live on without the session; told to stop, hapticd has ended
  CHECK(hapticd_say(session, "stop", NULL) == HAPTICD_OK);
  hapticd_detach(session);
  hapticd_result result;
  for (int n = 0; (result = hapticd_giver_publish(giver)) == HAPTICD_OK && n < 300; ++n) {
    hapticd_sleep(0.01);
  }
  CHECK(result == HAPTICD_ENDED);
  hapticd_giver_close(giver);
}

// hapticd is killed and comes back.
static void check_lost(hapticd_session* session) {
  hapticd_frames* frames = opened(session, HAPTICD_SERVO, HAPTICD_FROM_NOW);
  printf("kill\n");
  fflush(stdout);
  hapticd_result result;
  while ((result = hapticd_frames_wait(frames, 5)) == HAPTICD_OK) hapticd_frames_next(frames);
  CHECK(result == HAPTICD_LOST);
  CHECK(strcmp(hapticd_frames_message(frames), "") != 0);
  CHECK(hapticd_frames_reconnect(frames, 0) == HAPTICD_NOTHING);
  printf("start\n");
  fflush(stdout);
  CHECK(hapticd_frames_reconnect(frames, 10) == HAPTICD_OK);
  CHECK(hapticd_frames_wait(frames, 5) == HAPTICD_OK);
  CHECK(hapticd_frames_next(frames) == HAPTICD_OK);
  hapticd_frames_close(frames);
}

int main(int argc, char** argv) {
  CHECK(argc == 3);
  hapticd_session *watched, *given;
  CHECK(hapticd_attach(argv[1], &watched) == HAPTICD_OK);
  CHECK(strcmp(hapticd_name(watched), argv[1]) == 0);
  CHECK(strcmp(hapticd_session_message(watched), "") == 0);
  CHECK(hapticd_attach(argv[2], &given) == HAPTICD_OK);
  check_open(watched);
  check_servo(watched);
  check_objects(watched);
  check_control(watched);
  check_give(given);
  check_lost(watched);
  hapticd_detach(watched);
  return 0;
}
