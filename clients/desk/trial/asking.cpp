// SPDX-License-Identifier: GPL-3.0-or-later
#include "clients/desk/trial/asking.h"

#include <poll.h>
#include <unistd.h>

#include <algorithm>
#include <iostream>

#include "clients/hapt/options.h"
#include "proto/config/devices.h"
#include "proto/os/message.h"
#include "proto/os/session_file.h"

namespace haptic {

void add_tried_device(Command& command, TriedDevice& device, const std::string& name,
                      const std::string& help) {
  command.option(name, device.what, help).required();
  command.option("--path NODE", device.path, "serial port of the device");
  command.flag("-y,--yes", device.yes, "ask nothing: the device moves by itself");
}

SessionConfig config_of(const TriedDevice& tried) {
  const auto row = std::ranges::find(kDevices, tried.what, &DeviceRow::name);
  SessionConfig config{};
  if (row != kDevices.end()) {
    config.device.kind = row->id;
  } else {
    config = load_config(find_session_file(tried.what));
  }
  const DeviceRow& device = row_of(config.device.kind);
  if (!device.has_node()) {
    throw InputError(std::string(device.name) + " is no hardware; nothing is to be tried");
  }
  if (!tried.path.empty()) assign(config.device.serial.path, tried.path);
  if (device.node == NodeKind::kSerial && view(config.device.serial.path).empty()) {
    throw InputError("give the serial port of the " + std::string(device.name) +
                     " with --path (`hapt devices` lists those that are there)");
  }
  return config;
}

void check_terminal(bool yes) {
  if (yes || isatty(STDIN_FILENO) == 1) return;
  throw UsageError(
      "each step is asked for at a terminal; for a script give --yes, which moves "
      "the device without asking");
}

bool is_agreed(TrialRun* run, bool yes, const std::string& question) {
  std::cout << '\n' << question << std::flush;
  if (yes) {
    std::cout << " yes (--yes)\n";
    return true;
  }
  std::cout << " [y/N] " << std::flush;
  const auto has_answer = [] {
    pollfd in{STDIN_FILENO, POLLIN, 0};
    return poll(&in, 1, 0) > 0;
  };
  if (run != nullptr) run->wait_for(has_answer);
  std::string answer;
  std::getline(std::cin, answer);
  return answer == "y" || answer == "Y" || answer == "yes";
}

}  // namespace haptic
