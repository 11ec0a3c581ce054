// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "servo/render/render.h"

namespace haptic {

/// The state of a grasp between ticks.
struct GraspState {
  uint32_t object = kMaxObjects;  // kMaxObjects: nothing is held
  double strength = 0;            // 0 to 1
  Pose X_WT;                      // the drawn tool of the last tick
  Pose X_OP;                      // where it was held in the last tick
  Twist slip;  // by which the hold has given way: its springs are so much shorter [m], [rad]
  double speed = 0, spin = 0;    // at which that is taken up [m/s], [rad/s]
  double gives_way = 0;          // for how long it will still give way [s]; 0: not
  double force = 0, torque = 0;  // of the hold when nothing stood still last [N], [N·m]
};

/// The hold on the tool in this tick.
struct Hold {
  uint32_t object = kMaxObjects;  // kMaxObjects: nothing
  double share = 0;               // of the way to where the rows hold it, by strength and age
  int n_rows = 0;
  Pose X_WP;   // where they do
  Twist V_WP;  // its velocity, with the object
  Wrench F_W;  // on the tool, at X_WP
  bool holds() const { return object < kMaxObjects; }
};

/// The state of the button and of the object that is held.
struct HeldBody {
  bool is_wanted = false;  // the button is down
  bool stands = false;     // it has mass, and no sim moves it: what pulls at it would be stored
};

/// Holds the tool by the guide rows of the contacts while the button is down, with the wrench
///   F = s w [ K (X_P − X_T − slip) + B (V_P − V_T) ],
/// which pulls as well as pushes, no harder than the device can (safety's limit). The strength s
/// grows from 0 to 1 within kGraspTime (proto/wire/guide.h) from the first tick on; w is the weight
/// that the contacts' age leaves. While the body stands, since no sim moves it, and while contacts
/// fade or come back, the hold pulls as hard as it did and no harder: what hand and body move
/// beyond that is slip, or the spring would store it and throw the body afterwards. What has fallen
/// is caught with a fifth more, or 0.2 N, within a second. Then the slip is taken up, at most at 50
/// mm/s.
Hold hold_of(const ServoModel& model, GraspState& state, const RenderQuestion& question,
             const HeldBody& body);

/// Draws the question's tool towards X_WP, by the share s·w: the solver of any renderer then
/// answers for the contacts from there. Those of other objects take precedence: where they push the
/// proxy away from X_WP the hold yields. Those of the held object do not push there, where contact
/// has proven the proxy free of it; only of soft ones, which a proxy may enter, a share of 1 − s is
/// left.
void draw_tool(const Hold& hold, GraspState& state, RenderQuestion& question, TickScene& scene);

/// Adds the wrench of the hold to what the solver came to: the object is pushed with −F at X_P.
/// With the proxy drawn by the same share, the springs of hold and contacts are in series: together
/// they are never stiffer than K.
void add_hold(const Hold& hold, const RenderQuestion& question, Rendered& rendered);

}  // namespace haptic
