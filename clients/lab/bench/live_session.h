// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "clients/hapt/scratch_folder.h"
#include "clients/hapt/session_process.h"
#include "clients/lab/support/median.h"
#include "clients/library/client.h"
#include "clients/library/histogram.h"

namespace haptic {

/// A folder of its own for the session of a bench and what its programs say; hapticd and clients of
/// this process use it from then on.
struct RuntimeFolder {
  RuntimeFolder();
  const std::string& path() const { return folder_.path(); }

 private:
  ScratchFolder folder_;
};

/// Looks every 10 ms until it holds; throws std::runtime_error with `what` after 20 s.
void wait_until(const std::string& what, const std::function<bool()>& holds);

/// Figures of a live session over one stretch of time.
struct SessionWindow {
  double busy_p50 = 0, busy_p99 = 0;        // of the servo [s]
  double wake_p99 = 0;                      // its lateness [s]
  double contact_p50 = 0, contact_p99 = 0;  // of contact's steps [s]
  double contact_rate = 0;                  // answers a second
  double contacts = 0;                      // mean number of planes that push
  double seconds = 0;                       // how long it lasted
};

/// Median over the windows of one quantity.
template <class Window, class Part>
double median_of(const std::vector<Window>& windows, double Part::*quantity) {
  std::vector<double> values;
  for (const Window& window : windows) values.push_back(window.*quantity);
  return median(values);
}

/// hapticd with the session file at a path, and a client that watches servo and contact.
class LiveSession {
 public:
  /// Throws std::runtime_error where the servo does not run within 20 s.
  LiveSession(const RuntimeFolder& folder, const std::string& session, const std::string& config);
  SessionWindow watch(double seconds);

 private:
  SessionProcess hapticd_;
  std::optional<Client> client_;
  std::optional<RingSource<&ServoChannels::frames>> frames_;
  std::optional<RingSource<&ContactChannels::sets>> sets_;
};

}  // namespace haptic
