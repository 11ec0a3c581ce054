// SPDX-License-Identifier: Apache-2.0
#pragma once

/// The SCHED_FIFO priorities of a session, from what must never wait down to what may. The kernel's
/// own threads (interrupts) are at 50, and what runs at normal priority is below all of these.
namespace haptic {

inline constexpr int kGuardPriority = 90;     // hapticd's hand on the device: it stops a servo
inline constexpr int kLineTapPriority = 85;   // of a trial: the loop waits for it
inline constexpr int kServoPriority = 80;     // the hand
inline constexpr int kEmulatorPriority = 70;  // below the servo that it stands before
inline constexpr int kContactPriority = 60;   // answers the servo
inline constexpr int kSimPriority = 50;       // of bodies with mass, which the hand moves
// hapticd and the threads that map a new segment replace a dead process: at normal priority they
// would wait tens of milliseconds for a busy processor, even to die
inline constexpr int kHousekeepingPriority = 40;
// above whoever watches: a ring holds four seconds, and sixty busy viewers may take longer from a
// recorder of normal priority
inline constexpr int kRecorderPriority = 10;
inline constexpr int kTorturePriority = 5;  // sees every frame; under the recorder it breaks
inline constexpr int kWitnessPriority = 1;  // is held up by all real-time work, and nothing else

}  // namespace haptic
