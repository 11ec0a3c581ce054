// SPDX-License-Identifier: GPL-3.0-or-later
// Without a session: each function says what is wrong, whatever is NULL. HAPTICD_RUNTIME_DIR names
// a folder without sessions.
#include <hapticd/client_c.h>
#include <string.h>

#include "check.h"

// Of the call before.
static int says(const char* part) {
  return strstr(hapticd_message(), part) != NULL;
}

static void check_attach(void) {
  hapticd_session* session = (hapticd_session*)1;
  CHECK(hapticd_attach("nobody", NULL) == HAPTICD_BAD_ARGUMENT);
  CHECK(says("an argument is NULL"));
  CHECK(hapticd_attach("nobody", &session) == HAPTICD_NO_SESSION);
  CHECK(session == NULL);
  CHECK(says("nobody"));
  CHECK(hapticd_attach(NULL, &session) == HAPTICD_NO_SESSION);
  CHECK(hapticd_attach("", &session) == HAPTICD_NO_SESSION);
  CHECK(hapticd_attach("../nobody\n", &session) == HAPTICD_NO_SESSION);
  CHECK(strchr(hapticd_message(), '\n') == NULL);
}

static void check_session_of_null(void) {
  const char* text = NULL;
  CHECK(hapticd_set(NULL, "stiffness", "800 N/m") == HAPTICD_BAD_ARGUMENT);
  CHECK(says("the handle is NULL"));
  CHECK(hapticd_arm(NULL) == HAPTICD_BAD_ARGUMENT);
  CHECK(hapticd_disarm(NULL) == HAPTICD_BAD_ARGUMENT);
  CHECK(hapticd_pause(NULL) == HAPTICD_BAD_ARGUMENT);
  CHECK(hapticd_resume(NULL) == HAPTICD_BAD_ARGUMENT);
  CHECK(hapticd_status(NULL, &text) == HAPTICD_BAD_ARGUMENT);
  CHECK(hapticd_status(NULL, NULL) == HAPTICD_BAD_ARGUMENT);
  CHECK(hapticd_say(NULL, "stop", &text) == HAPTICD_BAD_ARGUMENT);
  CHECK(hapticd_say(NULL, NULL, NULL) == HAPTICD_BAD_ARGUMENT);
  CHECK(strcmp(hapticd_name(NULL), "") == 0);
  CHECK(strcmp(hapticd_session_message(NULL), hapticd_message()) == 0);
  hapticd_detach(NULL);
}

static void check_frames_of_null(void) {
  hapticd_frames* frames = (hapticd_frames*)1;
  CHECK(hapticd_frames_open(NULL, HAPTICD_SERVO, 0, HAPTICD_FROM_NOW, &frames) ==
        HAPTICD_BAD_ARGUMENT);
  CHECK(frames == NULL);
  CHECK(hapticd_frames_open(NULL, HAPTICD_SERVO, 0, HAPTICD_FROM_NOW, NULL) ==
        HAPTICD_BAD_ARGUMENT);
  CHECK(hapticd_frames_next(NULL) == HAPTICD_BAD_ARGUMENT);
  CHECK(hapticd_frames_latest(NULL) == HAPTICD_BAD_ARGUMENT);
  CHECK(hapticd_frames_wait(NULL, 1) == HAPTICD_BAD_ARGUMENT);
  CHECK(hapticd_frames_reconnect(NULL, 1) == HAPTICD_BAD_ARGUMENT);
  CHECK(hapticd_frames_servo(NULL, NULL) == HAPTICD_BAD_ARGUMENT);
  CHECK(hapticd_frames_contact_set(NULL, NULL) == HAPTICD_BAD_ARGUMENT);
  CHECK(hapticd_frames_scene(NULL, NULL) == HAPTICD_BAD_ARGUMENT);
  CHECK(hapticd_frames_control(NULL, NULL) == HAPTICD_BAD_ARGUMENT);
  CHECK(hapticd_frames_contact(NULL, 0, NULL) == HAPTICD_BAD_ARGUMENT);
  CHECK(hapticd_frames_object(NULL, 0, NULL) == HAPTICD_BAD_ARGUMENT);
  CHECK(hapticd_frames_record(NULL, NULL, NULL) == HAPTICD_BAD_ARGUMENT);
  CHECK(hapticd_frames_list(NULL, NULL, NULL, NULL, NULL) == HAPTICD_BAD_ARGUMENT);
  CHECK(hapticd_frames_lost(NULL) == 0);
  CHECK(hapticd_frames_n_contacts(NULL) == 0);
  CHECK(hapticd_frames_n_objects(NULL) == 0);
  CHECK(strcmp(hapticd_frames_message(NULL), hapticd_message()) == 0);
  hapticd_frames_close(NULL);
}

static void check_giver_of_null(void) {
  hapticd_giver* giver = (hapticd_giver*)1;
  CHECK(hapticd_give(NULL, "ball", &giver) == HAPTICD_BAD_ARGUMENT);
  CHECK(giver == NULL);
  CHECK(hapticd_give(NULL, NULL, NULL) == HAPTICD_BAD_ARGUMENT);
  CHECK(hapticd_giver_object(NULL, NULL, NULL) == HAPTICD_BAD_ARGUMENT);
  CHECK(hapticd_giver_pushed(NULL, 0, NULL) == HAPTICD_BAD_ARGUMENT);
  CHECK(hapticd_giver_move(NULL, NULL) == HAPTICD_BAD_ARGUMENT);
  CHECK(hapticd_giver_publish(NULL) == HAPTICD_BAD_ARGUMENT);
  CHECK(hapticd_giver_draw(NULL, NULL, 0, NULL, 0) == HAPTICD_BAD_ARGUMENT);
  CHECK(strcmp(hapticd_giver_message(NULL), hapticd_message()) == 0);
  hapticd_giver_close(NULL);
}

int main(void) {
  CHECK(strcmp(hapticd_message(), "") == 0);
  CHECK(hapticd_wire_version() > 0);
  hapticd_sleep(-1);
  check_attach();
  check_session_of_null();
  check_frames_of_null();
  check_giver_of_null();
  return 0;
}
