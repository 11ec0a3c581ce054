// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "servo/render/render.h"

namespace haptic {

/// What a grasp keeps between ticks.
struct GraspState {
  uint32_t object = kMaxObjects;  // kMaxObjects: nothing is held
  double strength = 0;            // 0 to 1
  bool is_over = false;           // it has let go
  Pose X_WT;                      // the drawn tool of the last tick
  Pose X_OP;                      // where it was held in the last tick
};

/// What holds the tool in this tick.
struct Hold {
  uint32_t object = kMaxObjects;  // kMaxObjects: nothing
  double share = 0;               // of the way to where the rows hold it, by strength and age
  int n_rows = 0;
  Pose X_WP;   // where they do
  Twist V_WP;  // its velocity, with the object
  Pose X_WT;   // the hand, as the springs see it
  Twist V_WT;
  bool holds() const { return object < kMaxObjects; }
};

/// How the object that is held does.
struct HeldBody {
  bool is_wanted = false;  // the button is down
  bool stands = false;     // it has mass, and no sim moves it: what pulls at it would be stored
};

/// What the guide rows of the contacts hold while the button is down. Their strength s grows from 0
/// to 1 within kGraspTime (proto/wire/guide.h) from their first tick on, and is multiplied by the
/// weight w that the contacts' age leaves. While the body stands it falls, within kLetGoTime, and a
/// grasp that has come to nothing is over until the button goes down again.
Hold hold_of(const ServoModel& model, GraspState& state, const RenderQuestion& question,
             const HeldBody& body);

/// Draws the question's tool towards X_WP, by the share s·w: the solver of any renderer then
/// answers for the contacts from there. Those of other objects take precedence: where they push the
/// proxy away from X_WP the hold yields. Those of the held object do not push there, where contact
/// has proven the proxy free of it; only of soft ones, which a proxy may enter, a share of 1 − s is
/// left.
void draw_tool(const Hold& hold, GraspState& state, RenderQuestion& question, TickScene& scene);

/// Adds to what the solver came to the wrench of the hold,
///   F = s w [ K (X_P − X_T) + B (V_P − V_T) ],
/// which pulls as well as pushes, no harder than the device can (safety's limit): the object is
/// pushed with −F at X_P, and never by more than the hand feels. With the proxy drawn by the same
/// share, the springs of hold and contacts are in series: together they are never stiffer than K.
void add_hold(const ServoModel& model, const Hold& hold, const RenderQuestion& question,
              Rendered& rendered);

}  // namespace haptic
