// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "proto/config/config.h"
#include "proto/wire/heard_client.h"
#include "proto/wire/per_object.h"
#include "proto/wire/power_window.h"
#include "proto/wire/wire.h"

/// Hears what clients put on the tool of a hand: a wrench, and planes that it does not pass.
///
///   inputs  the newest frame of each client, at most one each two milliseconds
///   check   rights, instants, numbers; a K that is stiffer than the coupling is scaled down to it,
///           a B that brakes more than the device holds likewise, and one that drives is left out
///   weight  of a client's age, 0 to 1 (heard_client.h)
///   out     the wrenches of the answer, and the planes behind its contacts, with that weight
///
/// The servo bounds, tick by tick, what this may give the hand (servo/given).
namespace haptic {

/// Largest numbers of a wrench and of planes, in units of the scene: a K or B is measured by the
/// sum of a row in the metric of diag(translational, rotational), which bounds its eigenvalues.
struct GivenTouchLimits {
  double translational_stiffness = 0;  // of the session's coupling [N/m]; 0: none
  double rotational_stiffness = 0;     // [N·m/rad]
  double translational_damping = 0;    // that the device holds [N·s/m]; 0: none
  double rotational_damping = 0;       // [N·m·s/rad]
  double contact_stiffness = 0;        // of a soft plane [N/m]
};

/// Constant after start.
struct GivenTouchModel {
  struct Client {
    uint32_t client;  // index in the session file
    ClientConfig config;
  };
  std::vector<Client> clients;  // that may push or touch
  GivenTouchLimits limits;
  uint32_t hand = kFirstHand;
  uint32_t n_objects = 0;
};
GivenTouchModel build_given_touch(const SessionConfig& config);

/// A plane, and how far along its normal the tool's origin lies at least where its point meets it.
struct KeptPlane {
  GivenPlane plane;
  double nearest = 0;  // normal_O·object_point_O + |tool_point_T| [m]
};

/// A frame of a client, as far as it is for this hand.
struct GivenToHand {
  uint64_t generation = 0;              // of the segment it came in
  std::optional<AppliedWrench> wrench;  // as it is added to a set
  UpTo<KeptPlane, kMostGivenPlanes> planes;
  bool is_cut = false;  // its K or B is less than it says
};

struct GivenTouchState {
  struct Client {
    HeardClient heard;
    GivenToHand given;
    double weight = 0;      // of it; it falls by a ramp where another one gives now, or nobody
    PowerWindow power;      // that its wrench and planes have given the hand
    double energy = 0;      // FeltClient::energy of the last frame of the servo [J]
    bool is_short = false;  // its bank let less than half through then
  };
  std::vector<Client> clients;  // as in the model
  int64_t weighed_ns = 0;       // when the weights were found; 0: not yet
  int64_t servo_since_ns = 0;   // ServoFrame::impulses_since_ns
};
GivenTouchState begin_given_touch(const GivenTouchModel& model);

/// The newest frame of the k-th client, of the segment with that generation, at t_ns: it is taken
/// or refused. What a predecessor has given fades first.
void see_client(const GivenTouchModel& model, GivenTouchState& state, size_t k, uint64_t generation,
                const GivenFrame& given, int64_t t_ns);

/// Finds the weights of what is given at t_ns. A spare does it all along, so that nothing fades
/// when its turn comes.
void weigh_given(const GivenTouchModel& model, GivenTouchState& state, int64_t t_ns);

/// Where a tool may meet planes until the next sets.
struct TouchedFrom {
  uint32_t held_object = kMaxObjects;  // nothing pushes there; kMaxObjects: the tool holds none
  double reach = 0;                    // how far it may come, the radius of a sphere included [m]
};

/// Adds what is given to the answer to a frame of the servo, and what has been taken of the
/// clients. Planes that the tool cannot reach before the next sets are left out.
void add_given(const GivenTouchModel& model, GivenTouchState& state, const ServoFrame& servo,
               const TouchedFrom& from, ContactSet& set);

}  // namespace haptic
