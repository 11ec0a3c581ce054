// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>

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
    Wrench felt_W;      // of the last tick, as it was felt
  };
  std::array<Client, kMostClients> clients;
};

/// Notes the work of the last tick's wrenches, which were held while the tool has gone this way.
void note_work(const ServoModel& model, const Twist& way, FeltClientsState& state);

/// Lowers the shares of the surfaces to what their clients may be felt with.
void keep_surfaces(const ServoModel& model, const FeltClientsState& state, const TickScene& scene,
                   const Rendered& rendered, KeptShares& shares);

/// The wrenches of a set on the tool as the hand holds it, and what the planes push with (before
/// keep()): F = w g (F0 + K δ − B V), δ the way from where F0 is for, no farther than the trust
/// radius; w by age; g the share of the client's bank.
FeltOfClients felt_of_clients(const ServoModel& model, const FeltClientsState& state,
                              const RenderQuestion& question, const KeptShares& shares,
                              const Rendered& rendered);

/// Keeps what the hand has felt of them, by how safety has scaled force and torque.
void keep_felt(const FeltOfClients& felt, const FeltShare& share, FeltClientsState& state);

/// What the frame says of each client of the set.
void note_felt(const ServoModel& model, const FeltClientsState& state, const FeltOfClients& felt,
               const ContactSet& set, ServoFrame& frame);

}  // namespace haptic
