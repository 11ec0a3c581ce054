// SPDX-License-Identifier: GPL-3.0-or-later
// hapticd: starts, watches and restarts the three processes of a session, hands out their rings.
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <stdexcept>
#include <string>
#include <vector>

#include "proto/config/command_line.h"
#include "proto/config/config.h"
#include "proto/config/config_warnings.h"
#include "proto/config/devices.h"
#include "proto/config/renderer_needs.h"
#include "proto/ipc/process.h"
#include "proto/os/message.h"
#include "proto/os/programs.h"
#include "servo/hapticd/supervisor.h"

namespace {

struct Options {
  std::string config_path;
  std::string session;
  std::string replay;
  std::string renderer;
  bool check_only = false;
  bool json = false;
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
  throw std::runtime_error(program + ": cannot be started (" + std::strerror(errno) +
                           "); build it, or set HAPTICD_LIBEXEC to its folder");
}

int run(const Options& options) {
  std::string text = haptic::read_config_text(options.config_path);
  haptic::SessionConfig config = haptic::parse_config(text, options.config_path);
  if (!options.replay.empty()) {
    haptic::use_trace(config, options.replay);
    text += "\n# its device was replaced: --replay " + options.replay + "\n";
  }
  if (!options.renderer.empty()) {
    haptic::use_renderer(config, options.renderer);
    text += "\n# its renderer was replaced: --renderer " + options.renderer + "\n";
  }
  const std::vector<std::string> warnings = haptic::config_warnings(config);
  if (options.check_only) check(options.config_path, warnings);
  const std::string session =
      options.session.empty() ? std::string(haptic::view(config.name)) : options.session;
  haptic::HapticdLog log(options.json);
  for (const std::string& line : warnings) {
    log.write(haptic::LogLevel::kWarning, "hapticd", options.config_path + ": " + line);
  }
  return haptic::Supervisor(config, text, session, log).run();
}

}  // namespace

int main(int argc, char** argv) try {
  Options options;
  haptic::CommandLine line(
      "hapticd",
      "Haptics server: runs the session that a file describes until it is told to stop.");
  line.option("CONFIG.toml", options.config_path, "the scene, the device and the limits")
      .required();
  line.option("--session", options.session, "name of the session").show_default("the file's");
  line.option("--replay FILE", options.replay, "recorded hand instead of the configured device");
  line.option("--renderer", options.renderer, "instead of the file's: " + haptic::renderer_names());
  line.flag("--check-config", options.check_only, "check the file and its meshes, start nothing");
  line.flag("--log-json", options.json, "log one JSON object per line");
  line.example("hapticd configs/bunny.toml");
  if (const auto code = line.read(argc, argv)) return *code;
  return run(options);
} catch (const std::exception& error) {
  return haptic::report_failure("hapticd", error);
}
