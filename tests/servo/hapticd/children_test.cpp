// SPDX-License-Identifier: GPL-3.0-or-later
// Tests for servo/hapticd/children.cpp with the real programs, turn by turn.
#include "servo/hapticd/children.h"

#include <sys/wait.h>

#include <catch2/catch.hpp>
#include <csignal>
#include <memory>

#include "proto/ipc/sessions.h"
#include "proto/os/realtime.h"
#include "proto/os/session_file.h"
#include "tests/process/programs.h"
#include "tests/support/data.h"
#include "tests/support/temporary_folder.h"

namespace haptic {
namespace {

/// Ends a child of this process, which stays to be waited for.
void kill_unseen(pid_t pid) {
  kill(pid, SIGKILL);
  siginfo_t dead;
  waitid(P_PID, static_cast<id_t>(pid), &dead, WEXITED | WNOWAIT);
}

/// sim, contact and its spare, without the loop of hapticd.
struct Nursery {
  test::TemporaryRuntimeFolder folder;
  std::string text = read_config_text(test::from_source("configs/plane.toml"));
  HapticdLog log{false};
  std::unique_ptr<SessionRun> session{
      new SessionRun{parse_hands(text, "plane.toml"), text, "nursery", log}};
  std::unique_ptr<Attachments> attachments =
      std::make_unique<Attachments>(connect_session("nursery"));
  Children children{*session, *attachments};

  SessionStatus status() {
    SessionStatus status;
    status.hands.resize(session->hands.size());
    children.report(status);
    return status;
  }
  bool has_spare() {
    session->server.serve([this](const Announcement& offer, int) { children.take_offer(offer); });
    children.start_due(now_ns());
    return status().spare.is_ready;
  }
};

}  // namespace

TEST_CASE("children: a spare takes over from contact, one that is dead does not") {
  Nursery nursery;
  nursery.children.start();
  REQUIRE(test::eventually([&] { return nursery.has_spare(); }));
  const SessionStatus before = nursery.status();
  const pid_t contact = before.processes[1].pid, spare = before.spare.pid;
  const bool dies_too = GENERATE(false, true);
  kill_unseen(contact);
  nursery.children.reap([](uint32_t) {});
  if (dies_too) kill_unseen(spare);
  nursery.children.start_due(now_ns());
  const SessionStatus after = nursery.status();
  CHECK(after.processes[1].pid > 0);
  CHECK((after.processes[1].pid == spare) == !dies_too);
  CHECK(after.spare.pid < 0);
  // what has become contact is no spare any more
  if (!dies_too) CHECK(after.spare.generation == 0);
}

}  // namespace haptic
