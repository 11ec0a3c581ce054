// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "proto/math/motion_metric.h"
#include "proto/wire/wire.h"
#include "sim/given/local_model.h"

namespace haptic {

/// What the hands do to an object between two steps.
struct HandsOnObject {
  Wrench impulse_W;      // about the object's origin [N·s, N·m·s]
  Wrench late_W;         // NewPush::late_W
  double work = 0;       // of the hands on the object, as they moved [J]
  double spring = 0;     // energy in the coupling now [J]
  double stiffness = 0;  // of the coupling [N/m]
};

/// The model of an object that a client moves, and a purse: frames may bring only as much energy
/// into it as has been earned.
///
///   inputs   statement M⁻¹, K, D, X_f, V_f, a of the newest frame; each step, HandsOnObject
///   state    X, V; the norm, a conservative own force g − K₀ (X ⊖ X_r); the extra force, by which
///            what the client says differs from it; the purse [J]; a correction that is under way
///   energy   E = ½ VᵀMV + ½ (X⊖X_r)ᵀK₀(X⊖X_r) − g·(X⊖X_r) + energy in the coupling
///   step     V by M⁻¹ [F + norm − D V]; the extra force may always brake, and drives only as far
///   as
///            the purse pays; then purse += work of the hands − change of E
///   frame    the gap to the replayed frame, times a tenth, is paid out over a period of the
///   client;
///            while the object is touched a step of it changes the force by 20 N/s at most, and its
///            energy is taken from the purse: what the purse does not pay is not done. Along what
///            no push moves (a rod, a rail) there is nothing to press on: the model goes there
///            wholly within a period, whatever the purse has
///   bound    while it is touched the hand gains at most the energy that the model had before, and
///            1 mJ. In debt the model is damped and follows no frames
///   ends     apart for half a second: the purse fills with 10 mW to 5 mJ, the client's K is the
///            norm's, and its own force becomes it within 2 s
///
/// So an object that is as its client says feels as it is, and one that is not turns into clay
/// instead of shaking the hand. Error and motor look alike: a client that drives its object says
/// with what power (GivenMotion::power), which the purse then has as income.
class GuardedModel {
 public:
  const ModelState& at() const { return at_; }
  const GivenMotion& said() const { return said_; }
  /// In the last second frames asked for more than the purse let them have: twice as much, and more
  /// than a newton of the coupling's.
  bool is_held_back() const;
  /// Of the origin, by all but hands, in W.
  Twist acceleration() const;

  /// Puts the object there at once, with what is said: nothing of it is felt.
  void place(const ModelState& at, const GivenMotion& said);
  /// Lets it stand.
  void stop() { at_.V_WO = {}; }
  /// A frame, and what it means now; `ticks`: steps in a period of the client.
  void correct(const ModelState& replayed, const GivenMotion& said, int ticks);
  /// dt [s] later, at most kMostReplay.
  void step(const HandsOnObject& hands, double dt);

 private:
  bool is_bound() const;
  Wrench norm_at(const Pose& X_WO) const;
  Wrench stated_at(const Pose& X_WO) const;
  double own_energy() const;
  void advance(const Wrench& force_W, double dt);
  void drive(const Wrench& impulse_W, double& may);
  void follow(const HandsOnObject& hands, double dt);
  Twist answering(const Twist& change) const;
  void take_correction(const HandsOnObject& hands, double dt, double trust);
  void take_led();
  void keep_apart(double dt);
  void say(const GivenMotion& said);

  GivenMotion said_{};
  Mat6 mass_;  // of what answers: the pseudo-inverse of the mobility
  ModelState at_;
  Pose X_ref_;      // of the norm
  Wrench g_W_;      // of the norm there
  Mat6 K0_;         // of the norm
  Wrench extra_W_;  // beside the norm
  StateGap left_;   // of the correction
  StateGap led_;    // of that along what no push moves
  int ticks_left_ = 0;
  double purse_ = 0;
  double since_touched_ = 1e9;   // [s]
  double energy_ = 0;            // of model and coupling at the last step
  double paid_ = 0;              // for its correction
  double asked_ = 0, done_ = 0;  // of corrections while touched, by the coupling; fading [N]
};

}  // namespace haptic
