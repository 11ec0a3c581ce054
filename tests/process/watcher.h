// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <catch2/catch.hpp>
#include <fstream>
#include <optional>
#include <string>

#include "proto/config/config.h"
#include "proto/ipc/attachments.h"
#include "proto/ipc/sessions.h"
#include "proto/os/programs.h"
#include "tests/process/hapticd_process.h"
#include "tests/support/data.h"
#include "tests/support/temporary_folder.h"

namespace haptic::test {

/// Attached to the rings of a running session.
struct Watcher {
  Attachments attachments;
  RingSource<&ServoChannels::frames> servo;
  RingSource<&ContactChannels::sets> contact;
  RingSource<&SimChannels::frames> sim;
  RingSource<&ControlChannels::frames> control;
  ServoFrame servo_frame{};
  ContactSet contact_set{};
  SceneFrame scene{};
  ControlFrame control_frame{};

  explicit Watcher(const std::string& session)
      : attachments(connect(session)),
        servo(attachments.ring<&ServoChannels::frames>(Start::kOldest)),
        contact(attachments.ring<&ContactChannels::sets>(Start::kOldest)),
        sim(attachments.ring<&SimChannels::frames>(Start::kOldest)),
        control(attachments.ring<&ControlChannels::frames>(Start::kOldest)) {
    attachments.start();
  }
  static FileDescriptor connect(const std::string& session) {
    std::optional<FileDescriptor> socket;
    eventually([&] {
      try {
        socket = connect_session(session);
      } catch (const HandoutError&) {
      }
      return socket.has_value();
    });
    return std::move(socket.value());
  }
  bool wait_for_all() {
    return eventually([&] { return servo.latest(servo_frame); }) &&
           eventually([&] { return contact.latest(contact_set); }) &&
           eventually([&] { return sim.latest(scene); }) &&
           eventually([&] { return control.latest(control_frame); });
  }
};

template <typename Source>
pid_t writer_of(const Source& source) {
  return static_cast<pid_t>(source.header()->pid.load());
}

/// Writes plane.toml without its wish for real time, so that its session runs beside one that has
/// it; returns the path.
inline std::string write_quiet_config(const std::string& folder) {
  std::string text = read_config_text(from_source("configs/plane.toml"));
  text.insert(text.find("name"), "realtime = false\n");
  std::ofstream(folder + "/quiet.toml") << text;
  return folder + "/quiet.toml";
}

/// A session that runs, and a watcher of it.
struct RunningSession {
  TemporaryRuntimeFolder folder;
  HapticdProcess hapticd;
  Watcher watcher;

  RunningSession(const std::string& config, const std::string& name)
      : hapticd({config, "--session", name}, folder.path()), watcher(name) {
    REQUIRE(watcher.wait_for_all());
  }
};

}  // namespace haptic::test
