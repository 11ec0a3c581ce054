// SPDX-License-Identifier: Apache-2.0
// Prints where the tool is and what the hand feels, ten times a second: 01_watch [session]
#include <hapticd/client.h>

#include <cstdio>
#include <exception>

int main(int argc, char** argv) try {
  haptic::Reconnect session(argc > 1 ? argv[1] : "");  // no name: the only session that runs
  // one client for each hapticd: it may be killed and started again
  while (haptic::Client* client = session.next()) {
    if (session.missed() > 0) std::printf("hapticd is back after %.2f s\n", session.missed());
    auto frames = client->ring<&haptic::ServoChannels::frames>(haptic::Start::kNewest);
    client->start();
    haptic::ServoFrame frame;
    while (client->is_connected()) {
      client->sleep(0.1);
      if (!frames.latest(frame)) continue;
      const haptic::Vec3 p = frame.X_WT.p, f = frame.F_device_B.f;
      std::printf("tool %8.4f %8.4f %8.4f m   force %5.2f N\n", p.x, p.y, p.z, haptic::norm(f));
      std::fflush(stdout);
    }
  }
} catch (const std::exception& error) {
  std::fprintf(stderr, "01_watch: %s\n", error.what());
  return 1;
}
