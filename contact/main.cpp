// SPDX-License-Identifier: GPL-3.0-or-later
// haptic-contact: which surfaces the tool touches or is about to touch.
#include <cstdio>
#include <string_view>
#include <vector>

#include "contact/bake/reach.h"
#include "contact/bake/session.h"
#include "contact/loop.h"
#include "proto/os/progress.h"

namespace haptic {
namespace {

int run(const ChildArguments& arguments) {
  return run_contact(arguments, [](Child<ContactChannels>& child, ContactSet& answer) {
    child.channels().sets.publish(answer);
  });
}

/// The end of `hapticd --check-config`: opens the meshes that the session file names.
int check_meshes(const char* path) try {
  const std::vector<SessionConfig> hands = load_hands(path);
  const SessionConfig& config = hands.front();
  const std::string file = shown(path);
  StageProgress baking;
  BakeTold told;
  told.progress = [&](std::string_view stage, double share) { baking.at(stage, share); };
  for (const SessionConfig& hand : hands) {
    for (const std::string& line : scene_warnings(hand, bake_session(hand, told))) {
      std::printf("%s: warning: %s\n", file.c_str(), one_line(line).c_str());
    }
  }
  std::printf("%s: ok, session '%s', %u object%s\n", file.c_str(), config.name.data(),
              config.n_objects, config.n_objects == 1 ? "" : "s");
  return kExitClean;
} catch (const std::exception& error) {
  std::fprintf(stderr, "hapticd: %s\n", one_line(error.what()).c_str());
  return kExitBadInput;
}

}  // namespace
}  // namespace haptic

int main(int argc, char** argv) {
  if (argc == 3 && std::string_view(argv[1]) == "--check-config") {
    return haptic::check_meshes(argv[2]);
  }
  return haptic::run_child(argc, argv, haptic::run);
}
