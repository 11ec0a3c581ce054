// SPDX-License-Identifier: GPL-3.0-or-later
// hapt devices: what is plugged in, whether it can be opened, how a session file chooses it.
#include <iostream>
#include <memory>

#include "clients/desk/device_list.h"
#include "clients/desk/report_facts.h"
#include "clients/desk/trial/command.h"
#include "clients/desk/trial/weigh_command.h"
#include "clients/hapt/commands.h"
#include "clients/hapt/options.h"

namespace haptic {
namespace {

void list_devices(bool json) {
  std::vector<ListedDevice> devices = supported(kDevices, list_plugged());
  for (ListedDevice& device : devices) device.access = read_access("", device.node);
  (json ? print_devices_json : print_devices)(kDevices, devices, std::cout);
}

struct DevicesOptions {
  bool json = false, tried = false;
};

}  // namespace

void add_devices_command(Command& app) {
  const auto options = std::make_shared<DevicesOptions>();
  Command command = app.subcommand(
      "devices", "List the devices that are plugged in, whether they open, how to choose them");
  add_json(command, options->json);
  add_try_command(command, options->tried,
                  [](const std::string& node) { return report_facts(node); });
  add_weigh_command(command, options->tried);
  command.example("hapt devices --json");
  command.action([options] {
    // the action of `try` or `weigh` has run before
    if (!options->tried) list_devices(options->json);
  });
}

}  // namespace haptic
