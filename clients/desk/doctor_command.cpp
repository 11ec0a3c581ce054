// SPDX-License-Identifier: GPL-3.0-or-later
// hapt doctor: what keeps this machine from good sessions, and how to mend it.
#include <iostream>
#include <memory>

#include "clients/desk/findings.h"
#include "clients/hapt/commands.h"
#include "clients/hapt/options.h"
#include "proto/ipc/sessions.h"

namespace haptic {
namespace {

void examine(bool json) {
  MachineFacts facts = read_machine("", runtime_folder());
  read_devices(facts);
  const std::vector<Finding> findings = findings_of(facts);
  (json ? print_findings_json : print_findings)(findings, std::cout);
  if (is_any_wrong(findings)) throw ExitCode{kExitFailed};
}

}  // namespace

void add_doctor_command(Command& app) {
  const auto json = std::make_shared<bool>(false);
  Command command = app.subcommand(
      "doctor", "Check rights, kernel, clock and devices of this machine, and say what to mend");
  add_json(command, *json);
  command.example("hapt doctor");
  command.action([json] { examine(*json); });
}

}  // namespace haptic
