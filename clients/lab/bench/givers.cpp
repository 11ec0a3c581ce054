// SPDX-License-Identifier: GPL-3.0-or-later
#include <fstream>
#include <memory>
#include <string>
#include <vector>

#include "clients/hapt/session_process.h"
#include "clients/lab/bench/live_session.h"
#include "clients/lab/support/measurement.h"
#include "proto/config/command_line.h"
#include "proto/config/config.h"
#include "proto/os/progress.h"
#include "proto/os/session_file.h"

namespace haptic {
namespace {

constexpr const char* kSession = "bench-givers";
constexpr double kMostP99 = 1.15;            // with the clients, against without
constexpr double kMostP50 = 5e-6;            // more with them than without [s]
constexpr int64_t kSettleNs = kNsPerSecond;  // what coming and leaving costs is none of it

struct Options {
  std::string config = "plane.toml";
  double seconds = 5;
  int rounds = 10;
};

std::string name_of(uint32_t client) {
  return "giver " + std::to_string(client);
}

/// The session with eight clients more, each with an object of its own far away from the hand.
std::string with_givers(const std::string& config, const std::string& folder) {
  std::string text = read_config_text(find_session_file(config));
  for (uint32_t client = 0; client < kMostClients; ++client) {
    text += "\n[[object]]\nname = \"" + name_of(client) +
            "\"\nprimitive = \"sphere\"\nsize = \"20 mm\"\nposition = [\"800 mm\", \"" +
            std::to_string(100 * client) + " mm\", \"500 mm\"]\n";
  }
  for (uint32_t client = 0; client < kMostClients; ++client) {
    text += "\n[[client]]\nname = \"" + name_of(client) + "\"\nmay = [\"move " + name_of(client) +
            "\", \"push\", \"touch\"]\n";
  }
  std::string path = folder + "/givers.toml";
  std::ofstream(path) << text;
  return path;
}

/// Eight programs that flood: four frames a millisecond each, of which half are valid.
class Givers {
 public:
  explicit Givers(const std::string& folder) {
    for (uint32_t client = 0; client < kMostClients; ++client) {
      programs_.push_back(std::make_unique<SessionProcess>(
          "haptic-faulty-giver",
          std::vector<std::string>{kSession, name_of(client), "0.8", std::to_string(0.1 * client),
                                   "0.5", "flood"},
          folder + "/givers.log"));
    }
    Client client(kSession);
    auto scenes = client.ring<&SimChannels::frames>(Start::kNewest);
    client.start();
    SceneFrame scene{};
    wait_until("the clients do not give", [&] {
      scenes.latest(scene);
      size_t n = 0;
      for (const GiverState& giver : scene.givers) n += giver.refused > 0 && giver.t_ns > 0;
      return n == kMostClients;
    });
  }

 private:
  std::vector<std::unique_ptr<SessionProcess>> programs_;
};

using Windows = std::vector<SessionWindow>;

void add_pair(Rows& rows, const std::string& what, const Windows& without, const Windows& with,
              double SessionWindow::*p50, double SessionWindow::*p99) {
  const double before = median_of(without, p50), after = median_of(with, p50);
  rows.add({{what + "_p50_without", before, "s"},
            {what + "_p50_with", after, "s"},
            {what + "_p50_more", after - before, "s", at_most(kMostP50)}});
  const double slow = median_of(without, p99), slower = median_of(with, p99);
  rows.add({{what + "_p99_without", slow, "s"},
            {what + "_p99_with", slower, "s"},
            {what + "_p99_ratio", slower / slow, "", at_most(kMostP99)}});
}

void all_rows(const Options& options, const Rows& all) {
  const RuntimeFolder folder;
  LiveSession session(folder, kSession, with_givers(options.config, folder.path()));
  Windows without, with;
  Progress progress("measuring rounds", options.rounds);
  for (int round = 0; round < options.rounds; ++round) {
    without.push_back(session.watch(options.seconds));
    {
      const Givers givers(folder.path());
      sleep_until(now_ns() + kSettleNs);
      with.push_back(session.watch(options.seconds));
    }
    sleep_until(now_ns() + kSettleNs);
    progress.step();
  }
  all.machine("machine");
  Rows rows = all.of("eight clients that flood");
  add_pair(rows, "servo_busy", without, with, &SessionWindow::busy_p50, &SessionWindow::busy_p99);
  add_pair(rows, "contact_step", without, with, &SessionWindow::contact_p50,
           &SessionWindow::contact_p99);
  rows.add({{"servo_wake_lateness_p99_without", median_of(without, &SessionWindow::wake_p99), "s"},
            {"servo_wake_lateness_p99_with", median_of(with, &SessionWindow::wake_p99), "s"},
            {"planes_that_push", median_of(with, &SessionWindow::contacts)}});
}

}  // namespace

/// The cost of eight hostile clients that give: the servo's work and contact's steps, with and
/// without them in turns in one session; a figure is the median over the rounds. What they cost of
/// the processors is little: they are hostile by what their rings hold.
Measured bench_givers(Command& command) {
  const auto options = std::make_shared<Options>();
  command.option("--config FILE", options->config, "session file").show_default();
  command.quantity("--for", options->seconds, Dimension::kTime, {0.2, 3600}, "of each window", "s")
      .show_default();
  add_counts(command, {rounds_of(options->rounds, "with and without them; medians are reported")});
  return measured(all_rows, options);
}

}  // namespace haptic
