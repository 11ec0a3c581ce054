// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <optional>

#include "servo/given/energy_bank.h"
#include "servo/render/kept_shares.h"

/// What clients give a hand beside the contacts: wrenches, and the pushes of their planes. Of each
/// client both together are felt with at most its max_force, as far as its bank of energy lets
/// them.
namespace haptic {

/// All that is felt of the clients in a tick, on the tool at its origin, in W.
struct FeltOfClients {
  std::array<Wrench, kMostClients> of_client_W{};  // planes and wrenches
  Wrench wrenches_W;                               // of all, beside the coupling
  bool finite = true;
};

struct FeltClientsState {
  struct Client {
    EnergyBank bank;
    double energy = 0;  // given to the hand since start [J]
    Wrench felt_B;      // of the last tick at the handle, as it was felt
  };
  std::array<Client, kMostClients> clients;
  std::optional<Pose> X_BH;  // of the last tick
};

/// Notes the work at the handle of the last tick's wrenches, which were held until now.
void note_work(const ServoModel& model, const Pose& X_BH, FeltClientsState& state);

/// The share that a client's bank lets through.
double share_of(const ServoModel& model, const FeltClientsState& state, uint32_t client);

/// Lowers the shares of the surfaces to what their clients' max_force allows, and a torque of that
/// force at the rim of the tool. Their banks have eased the planes before they were met, so that
/// nothing is squeezed between a plane that is not felt and a wall that is.
void keep_surfaces(const ServoModel& model, const RenderQuestion& question,
                   const Rendered& rendered, KeptShares& shares);

/// The wrenches of a set on the tool as the hand holds it, and what the planes push with (before
/// keep()): F = w g (F0 + K δ − B V), δ the way from where F0 is for, no farther than the trust
/// radius; w by age; g the share of the client's bank.
FeltOfClients felt_of_clients(const ServoModel& model, const FeltClientsState& state,
                              const RenderQuestion& question, const KeptShares& shares,
                              const Rendered& rendered);

/// Keeps what the hand at X_BH has felt of them, by how safety has scaled force and torque.
void keep_felt(const ServoModel& model, const Pose& X_BH, const FeltOfClients& felt,
               const FeltShare& share, FeltClientsState& state);

/// What the frame says of each client of the set.
void note_felt(const ServoModel& model, const FeltClientsState& state, const FeltOfClients& felt,
               const ContactSet& set, ServoFrame& frame);

}  // namespace haptic
