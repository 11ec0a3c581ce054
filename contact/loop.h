// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "proto/ipc/process.h"

namespace haptic {

/// What is done with an answer: publish it.
using ContactPublisher = void (*)(Child<ContactChannels>&, ContactSet&);

/// The whole of haptic-contact: bakes the objects, then answers each new ServoFrame as fast as it
/// can, and rests a quarter of what each answer took. A spare prepares everything, makes one step
/// for nobody and waits, with its priority, until its turn has come. Returns the exit code; throws
/// before the loop alone. haptic-faulty-contact runs the same with a publisher that spoils answers.
int run_contact(const ChildArguments& arguments, ContactPublisher publish);

}  // namespace haptic
