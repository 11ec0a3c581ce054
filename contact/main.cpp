// SPDX-License-Identifier: GPL-3.0-or-later
// haptic-contact: which surfaces the tool touches or is about to touch.
#include "contact/loop.h"

namespace haptic {
namespace {

int run(const ChildArguments& arguments) {
  return run_contact(arguments, [](Child<ContactChannels>& child, ContactSet& answer) {
    child.channels().sets.publish(answer);
  });
}

}  // namespace
}  // namespace haptic

int main(int argc, char** argv) {
  return haptic::run_child(argc, argv, haptic::run);
}
