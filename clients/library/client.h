// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "clients/library/eyes.h"
#include "proto/ipc/handout.h"
#include "proto/os/realtime.h"

namespace haptic {

/// A program that watches a session. It maps the session's rings read-only, so a client that stops
/// or crashes cannot disturb the hand.
///
///   Client client("bunny");
///   auto frames = client.ring<&ServoChannels::frames>(Start::kNewest);
///   client.start();
///   ServoFrame frame;
///   while (client.is_connected()) {
///     while (frames.next(frame)) use(frame);   // or frames.latest(frame)
///     client.sleep(0.01);
///   }
///
/// eyes() has the meshes: objects[i] in O, drawn at SceneFrame::X_WO[i], the tool in T, at X_WT.
class Client {
 public:
  /// Connects; an empty name selects the only running session. Throws HandoutError with a remedy.
  explicit Client(const std::string& session);

  /// A ring to read; call it before start().
  template <auto kMember>
  RingSource<kMember> ring(Start start) {
    return attachments_.ring<kMember>(start);
  }

  void start() { attachments_.start(); }

  /// How to draw the scene: the newest mesh of each object and of the tool. They come a moment
  /// after start(), once contact has prepared its meshes, and again after its restart. Any thread.
  Eyes eyes() const { return eyes_.eyes(); }

  bool is_connected() const { return attachments_.is_connected(); }

  /// Why the session refused this client, in one line; empty if it did not. Valid once
  /// is_connected() is false.
  const std::string& refusal() const { return attachments_.refusal(); }
  void sleep(double seconds) const;

 private:
  EyeBook eyes_;  // outlives the thread that fills it
  Attachments attachments_;
};

}  // namespace haptic
