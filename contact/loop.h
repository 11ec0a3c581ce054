// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "proto/ipc/process.h"

namespace haptic {

using ContactPublisher = void (*)(Child<ContactChannels>&, ContactSet&);

/// The main function of haptic-contact: bakes the objects, then answers each new ServoFrame as soon
/// as possible, and sleeps for a quarter of the time that each answer took. A spare prepares
/// everything, makes one warm-up step, and waits with its final priority for its turn. Returns the
/// exit code; throws only before the loop. haptic-faulty-contact runs the same with a publisher
/// that corrupts answers.
int run_contact(const ChildArguments& arguments, ContactPublisher publish);

}  // namespace haptic
