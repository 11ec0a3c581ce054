// SPDX-License-Identifier: GPL-3.0-or-later
#include "servo/hapticd/role.h"

#include <sys/wait.h>

#include <csignal>
#include <cstdlib>

#include "proto/ipc/process.h"
#include "proto/math/units.h"

namespace haptic {
namespace {

constexpr int kMostDeathsUnborn = 8;  // about five seconds of attempts

}  // namespace

const SegmentHeader* Role::running() const {
  if (!events || !child.is_running()) return nullptr;
  const SegmentHeader* header = std::visit([](const auto& ring) { return ring.header(); }, *events);
  return runs(header, generation) ? header : nullptr;
}

void Role::watch_pulse(HapticdLog& log, int64_t t_ns, int64_t held_up_ns) {
  int64_t silent_ns = 0;  // where no heartbeat is expected
  const SegmentHeader* header = running();
  if (life.phase == Phase::kWaking) {
    silent_ns = life.silence.look(0, life.started_ns, t_ns, held_up_ns);
  } else if (life.phase == Phase::kRunning && header != nullptr) {
    silent_ns =
        life.silence.look(header->heartbeat.load(), header->heartbeat_ns.load(), t_ns, held_up_ns);
  }
  const Pulse pulse = judge_pulse(silent_ns, period_ns);
  // one line when the state gets worse, not one per check
  if (pulse > life.pulse) {
    const bool hung = pulse == Pulse::kHung;
    log.write(hung ? LogLevel::kError : LogLevel::kWarning, name,
              std::string(hung ? "hangs: " : "late: ") + "no cycle for " +
                  std::to_string(silent_ns / kMs) + " ms" + (hung ? "; killed" : ""));
    if (hung) child.send(SIGKILL);
  }
  life.pulse = pulse;
}

void Role::write_events(HapticdLog& log) {
  const auto write = [&](auto& ring) {
    for (Event event; ring.next(event);) log.write_event(name, event);
    const uint64_t lost = ring.lost() - told_lost;
    told_lost = ring.lost();
    if (lost == 0) return;
    log.write(LogLevel::kWarning, name,
              std::to_string(lost) + " events came too fast to be written");
  };
  if (events) std::visit(write, *events);
}

std::optional<Role::Hopeless> Role::bury(int status) {
  const bool is_spare = !events, ran = life.phase == Phase::kRunning;
  if (ran || is_spare) child.preparing.clear();
  if (is_spare) return std::nullopt;
  ever_ran = ever_ran || ran;
  // what has run with this input may run again, however often it is killed
  deaths_unborn = ever_ran ? 0 : deaths_unborn + 1;
  const int code = WIFEXITED(status) ? WEXITSTATUS(status) : 0;
  // waits for a device that was there, as long as it takes
  if (code == kExitNoDevice && ever_ran) return std::nullopt;
  if (code == kExitBadInput || code == kExitNoDevice || code == kExitNoProgram) {
    return Hopeless{kExitBadInput, std::string(program) +
                                       " cannot run with this input, for the reason above; the "
                                       "session ends"};
  }
  // a mesh prepared once is in the cache, so the next attempt may succeed
  if (!child.preparing.empty() && !ever_ran) {
    return Hopeless{kExitCrash,
                    child.how_it_ended(status) +
                        "; the session ends; try that mesh alone (hapt bake), repair or decimate "
                        "it; the kernel kills what takes more memory than there is"};
  }
  if (deaths_unborn < kMostDeathsUnborn) return std::nullopt;
  return Hopeless{kExitCrash, child.how_it_ended(status) + " " + std::to_string(kMostDeathsUnborn) +
                                  " times before it ran; the session ends; look for the reason "
                                  "above"};
}

int64_t Role::put_off(int64_t t_ns) {
  const int64_t lived_ns = t_ns - life.started_ns;
  if (lived_ns >= kHealthyNs) deaths_in_a_row = 0;
  start_at_ns = t_ns + delay_ns(++deaths_in_a_row, lived_ns);
  life.phase = Phase::kWaiting;
  return start_at_ns - t_ns;
}

}  // namespace haptic
