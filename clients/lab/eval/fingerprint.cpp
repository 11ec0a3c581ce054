// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <filesystem>
#include <fstream>
#include <optional>

#include "clients/hapt/options.h"
#include "clients/lab/support/measurement.h"
#include "clients/lab/support/offline_session.h"
#include "proto/config/devices.h"
#include "proto/config/renderer_needs.h"
#include "proto/os/message.h"
#include "proto/os/progress.h"
#include "proto/os/session_file.h"
#include "proto/wire/renderer.h"

namespace haptic {
namespace {

struct FingerprintEval {
  std::vector<std::string> configs;  // session files
  double seconds = 4;                // of each
  LockstepOptions lockstep;
  std::string forces;  // folder of the forces of another build; none: only hashes
};

struct Run {
  std::string hash;
  std::vector<Wrench> F_W;  // of the coupling, tick by tick
};

Run run_session(const SessionConfig& config, const FingerprintEval& eval) {
  PlayedSession played(config, eval.lockstep);
  Lockstep& session = played.lockstep;
  const auto ticks = static_cast<uint64_t>(eval.seconds * config.servo_rate);
  Run run;
  for (uint64_t k = 0; k < ticks && session.step(); ++k) {
    run.F_W.push_back(session.frame().F_coupling_W);
  }
  run.hash = in_hex(session.hash());
  return run;
}

/// The largest difference from the forces in the file [N]; nothing: it was not there, and is now.
std::optional<double> compare(const std::string& path, const std::vector<Wrench>& F_W) {
  std::vector<Wrench> other(F_W.size());
  const auto size = static_cast<std::streamsize>(F_W.size() * sizeof(Wrench));
  if (std::ifstream file(path, std::ios::binary); file) {
    file.read(reinterpret_cast<char*>(other.data()), size);
    if (file.gcount() != size || file.peek() != std::ifstream::traits_type::eof()) {
      throw ConfigError(path + ": holds the forces of another time; give the same --for");
    }
    double largest = 0;
    for (size_t i = 0; i < F_W.size(); ++i) {
      largest = std::max(largest, norm(F_W[i].f - other[i].f));
    }
    return largest;
  }
  std::ofstream file(path, std::ios::binary);
  file.write(reinterpret_cast<const char*>(F_W.data()), size);
  if (!file.flush()) throw ConfigError(path + ": cannot be written; name another folder");
  return std::nullopt;
}

void eval_fingerprint(const FingerprintEval& eval, const Rows& all) {
  Rows rows = all.of("fingerprint");
  Progress progress("eval fingerprint",
                    static_cast<double>(eval.configs.size() * kRenderers.size()));
  for (const std::string& file : eval.configs) {
    const std::string scene = std::filesystem::path(file).stem();
    for (const RendererRow& row : kRenderers) {
      progress.step();
      SessionConfig config = load_config(file);
      if (row_of(config.device.kind).has_node()) continue;  // it has no virtual time
      const std::string both = scene + ", " + std::string(row.name);
      try {
        use_renderer(config, row.name);
        const Run run = run_session(config, eval);
        rows.note(both, run.hash);
        if (eval.forces.empty()) continue;
        const auto difference = compare(eval.forces + "/" + both, run.F_W);
        if (difference) rows.add(both + ", largest difference of force", *difference, "N");
      } catch (const MessageError& error) {
        rows.note(both, "left out: " + one_line(error.what()));
      }
    }
  }
}

}  // namespace

/// Hashes of the results of every tick, for each session file and each renderer that can play it. A
/// change of the code that is to change no behaviour must leave the hashes as they are. With a
/// folder, the wrenches of each session are kept there; if it holds them already, the largest
/// difference of a force is a row. A session whose hand is recorded plays its recording; one on a
/// device or without its meshes is left out, and a row says why. Throws ConfigError for a file that
/// cannot be read.
Measured suite_fingerprint(Command& command) {
  const auto eval = std::make_shared<FingerprintEval>();
  add_duration(command, "--for", eval->seconds, "of each session").show_default();
  add_lockstep(command, eval->lockstep);
  command.option(
      "--forces FOLDER", eval->forces,
      "keeps the forces of one build here and prints the largest difference of the next");
  return [eval](Report& report) {
    // all session files beside the default one
    const std::filesystem::path usual = find_session_file(OfflineSession{}.config);
    for (const auto& entry : std::filesystem::directory_iterator(usual.parent_path())) {
      if (entry.path().extension() == ".toml") eval->configs.push_back(entry.path());
    }
    std::sort(eval->configs.begin(), eval->configs.end());
    eval_fingerprint(*eval, report.rows);
  };
}

}  // namespace haptic
