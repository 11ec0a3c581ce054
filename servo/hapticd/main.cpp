// SPDX-License-Identifier: GPL-3.0-or-later
// hapticd: starts, watches and restarts the three processes of a session, hands out their rings.
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "proto/config/command_line.h"
#include "proto/config/config.h"
#include "proto/config/config_warnings.h"
#include "proto/config/devices.h"
#include "proto/config/renderer_needs.h"
#include "proto/ipc/process.h"
#include "proto/os/message.h"
#include "proto/os/programs.h"
#include "proto/os/session_file.h"
#include "proto/os/source_tree.h"
#include "servo/hapticd/supervisor.h"

namespace {

struct Options {
  std::string config_path;
  std::string session;
  haptic::ReplayChoice replay;
  std::string renderer;
  bool check_only = false;
  bool json = false;
  bool force = false;
};

/// Prints the warnings and leaves the meshes to haptic-contact, which can read them.
[[noreturn]] void check(const std::string& path, const std::vector<std::string>& warnings) {
  const std::string file = haptic::shown(path);
  for (const std::string& line : warnings) {
    std::printf("%s: warning: %s\n", file.c_str(), line.c_str());
  }
  std::fflush(stdout);
  const std::string program = haptic::program_folder() + "/haptic-contact";
  execl(program.c_str(), "haptic-contact", "--check-config", path.c_str(), nullptr);
  throw std::runtime_error(haptic::cannot_start(program, errno));
}

/// The eye files of a scene alone may be 520 descriptors, where a login allows 1024.
void allow_descriptors() {
  constexpr rlim_t kWanted = 4096;
  rlimit limit{};
  if (getrlimit(RLIMIT_NOFILE, &limit) != 0 || limit.rlim_cur >= kWanted) return;
  limit.rlim_cur = std::min(limit.rlim_max, kWanted);
  // refused: the server says to each client that it cannot take
  static_cast<void>(setrlimit(RLIMIT_NOFILE, &limit));
}

int run(Options options) {
  allow_descriptors();
  options.config_path = haptic::find_session_file(options.config_path);
  std::string text = haptic::read_config_text(options.config_path);
  std::vector<haptic::SessionConfig> hands = haptic::parse_hands(text, options.config_path);
  // what the command line replaces is the first hand's
  haptic::SessionConfig& first = hands.front();
  if (options.replay.is_any()) {
    haptic::use_replay(first, options.replay);
    text += "\n# replaced by the command line:" + haptic::replay_words(options.replay) + "\n";
  }
  if (!options.renderer.empty()) {
    haptic::use_renderer(first, options.renderer);
    text += "\n# its renderer was replaced: --renderer " + options.renderer + "\n";
  }
  std::string beyond;
  std::vector<std::string> warnings;
  for (const haptic::SessionConfig& hand : hands) {
    if (beyond.empty()) beyond = haptic::too_stiff(hand);
    for (const std::string& line : haptic::config_warnings(hand)) {
      if (std::ranges::find(warnings, line) == warnings.end()) warnings.push_back(line);
    }
  }
  if (!beyond.empty()) {
    if (!options.force) throw haptic::InputError(options.config_path + ": " + beyond);
    text += "\n# forced: --force\n";
  }
  if (options.check_only) check(options.config_path, warnings);
  const std::string session =
      options.session.empty() ? std::string(haptic::view(first.name)) : options.session;
  haptic::HapticdLog log(options.json);
  for (const std::string& line : warnings) {
    log.write(haptic::LogLevel::kWarning, "hapticd", options.config_path + ": " + line);
  }
  return haptic::Supervisor(std::move(hands), text, session, log).run();
}

}  // namespace

int main(int argc, char** argv) try {
  Options options;
  haptic::CommandLine line(
      "hapticd",
      "Haptics server: runs the session that a file describes until it is told to stop.");
  line.option("CONFIG.toml", options.config_path,
              "the scene, the device and the limits: a path, or a name as peg or plane")
      .required();
  line.option("--session", options.session, "name of the session").show_default("the file's");
  line.option("--replay FILE", options.replay.trace,
              "recorded hand instead of the configured device");
  line.option("--renderer", options.renderer, "instead of the file's: " + haptic::renderer_names());
  using haptic::Dimension;
  line.number("--replay-speed", options.replay.speed, haptic::kReplaySpeeds,
              "of the recorded hand");
  line.quantity("--replay-from", options.replay.from, Dimension::kTime, haptic::kNotNegative,
                "start of the played part, from the first sample", "s");
  line.quantity("--replay-to", options.replay.to, Dimension::kTime, haptic::kPositive, "its end",
                "s");
  line.flag("--replay-loop", options.replay.loop, "again and again, with a soft return");
  line.flag("--closed-loop", options.replay.closed_loop,
            "the recording is the intention of the simulated hand");
  line.quantity("--stiffness", options.replay.stiffness, Dimension::kStiffness, haptic::kPositive,
                "of the coupling, instead of the file's", "N/m");
  line.flag("--check-config", options.check_only, "check the file and its meshes, start nothing");
  line.flag("--force", options.force,
            "start it even if its coupling is stiffer than the device can hold");
  line.flag("--log-json", options.json, "log one JSON object per line");
  line.example("hapticd configs/bunny.toml");
  line.example("hapticd peg");
  if (const auto code = line.read(argc, argv)) return *code;
  return run(options);
} catch (const std::exception& error) {
  return haptic::report_failure("hapticd", error);
}
