// SPDX-License-Identifier: GPL-3.0-or-later
// hapt export: a recording as CSV.
#include <cstdio>
#include <fstream>
#include <iostream>
#include <memory>
#include <string>

#include "clients/hapt/check_outputs.h"
#include "clients/hapt/commands.h"
#include "proto/config/command_line.h"
#include "proto/log/csv.h"
#include "proto/os/message.h"

namespace haptic {
namespace {

struct ExportOptions {
  std::string recording, output, topic = std::string(kServo0Topic.name);
  bool csv = false, overwrite = false;
};

/// The topic to export; throws with a list of those in the recording if it is not there.
const TopicInfo& choose_topic(const TraceReader& trace, const ExportOptions& options) {
  std::string there;
  for (const TopicInfo* topic : trace.topics()) {
    if (topic->name == options.topic) return *topic;
    there += (there.empty() ? "" : ", ") + std::string(topic->name);
  }
  throw McapError(options.recording + ": has no topic '" + shown(options.topic) + "'; it has " +
                  (there.empty() ? "none of this program" : there));
}

void run_export(const ExportOptions& options) {
  check_outputs({options.output}, {options.recording}, options.overwrite);
  const TraceReader trace(options.recording);
  const TopicInfo& topic = choose_topic(trace, options);
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
  const size_t rows = file ? export_csv(trace, topic, file) : 0;
  file.close();
  if (!file) {
    throw CsvError(options.output + ": cannot be written; check the folder and the space left");
  }
  std::cerr << rows << " rows of " << topic.name << " written to " << shown(options.output) << '\n';
}

}  // namespace

void add_export_command(Command& app) {
  const auto options = std::make_shared<ExportOptions>();
  Command command = app.subcommand("export", "Turn a recording into CSV");
  command.option("recording", options->recording, "file of `hapt record` (.mcap)").required();
  command.flag("--csv", options->csv, "comma-separated values (the only form so far)");
  command.option("-o,--output", options->output, "file to write; default: standard output");
  command.flag("--overwrite", options->overwrite, "replace the file where it exists");
  command.option("--topic", options->topic, "which records").show_default();
  command.action([options] { run_export(*options); });
}

}  // namespace haptic
