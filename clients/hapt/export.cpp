// SPDX-License-Identifier: GPL-3.0-or-later
// hapt export: a recording as CSV.
#include <algorithm>
#include <cstdio>
#include <fstream>
#include <iostream>
#include <optional>
#include <string>

#include "clients/hapt/check_outputs.h"
#include "clients/hapt/commands.h"
#include "clients/hapt/options.h"
#include "proto/log/csv.h"
#include "proto/os/message.h"
#include "proto/os/progress.h"

namespace haptic {
namespace {

struct ExportOptions {
  std::string recording, output, topic;
  uint32_t hand = kFirstHand;  // whose servo, without a topic
  bool overwrite = false;
};

/// The topic to export; throws with a list of those in the recording if it is not there.
TopicInfo choose_topic(const TraceReader& trace, const ExportOptions& options) {
  const std::vector<TopicInfo> topics = trace.topics();
  const std::string_view wanted =
      options.topic.empty() ? servo_topic(options.hand).name : std::string_view(options.topic);
  const auto topic = std::ranges::find(topics, wanted, &TopicInfo::name);
  if (topic != topics.end()) return *topic;
  const std::string there = joined(topics, &TopicInfo::name);
  throw McapError(options.recording + ": has no topic '" + shown(wanted) + "'; it has " +
                  (there.empty() ? "none of this program" : shown(there)));
}

void run_export(const ExportOptions& options) {
  check_outputs({options.output}, {options.recording}, options.overwrite);
  const TraceReader trace(options.recording);
  const TopicInfo topic = choose_topic(trace, options);
  if (!trace.mcap().finished()) {
    std::cerr << shown(options.recording) << ": its writer was killed; exporting what is whole\n";
  }
  if (const std::string notice = trace.notice(topic); !notice.empty()) {
    std::cerr << shown(options.recording) << ": " << notice << '\n';
  }
  if (options.output.empty()) {
    export_csv(trace, topic, std::cout);
    return;
  }
  std::ofstream file(options.output, std::ios::binary | std::ios::trunc);
  std::optional<Progress> progress(std::in_place, "writing", 1);
  const size_t rows =
      file ? export_csv(trace, topic, file, [&](double share) { progress->at(share); }) : 0;
  progress.reset();
  file.close();
  if (!file) {
    throw MessageError(options.output + ": cannot be written; check the folder and the space left");
  }
  std::cerr << rows << " rows of " << topic.name << " written to " << shown(options.output) << '\n';
}

}  // namespace

void add_export_command(Command& app) {
  add_command<ExportOptions>(
      app, "export", "Turn a recording into CSV", run_export,
      [](Command& command, ExportOptions& options) {
        command.option("RECORDING", options.recording, "file of 'hapt record' (.mcap)").required();
        command.option("-o,--output FILE.csv", options.output, "file to write")
            .show_default("standard output");
        add_overwrite(command, options.overwrite);
        command.option("--topic TOPIC", options.topic, "which records")
            .show_default("those of the hand's servo");
        add_hand(command, options.hand);
        command.example("hapt export out.mcap -o out.csv");
      });
}

}  // namespace haptic
