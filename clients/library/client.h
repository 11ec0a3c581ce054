// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <memory>
#include <string>

#include "clients/library/eyes.h"
#include "proto/ipc/attachments.h"
#include "proto/ipc/channels.h"
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
/// eyes() has the meshes: objects[i] in O, drawn at SceneFrame::objects[i].X_WO, the tool in T, at
/// X_WT.
class Client {
 public:
  /// Connects; an empty name selects the only running session. Throws HandoutError with a remedy.
  explicit Client(const std::string& session);
  /// Takes a connection to a session.
  explicit Client(FileDescriptor socket);

  /// A ring to read, where it is a hand's that of this one; call it before start().
  template <auto kMember>
  RingSource<kMember> ring(Start start, uint32_t hand = kFirstHand) {
    return attachments_.ring<kMember>(start, hand);
  }

  void start() { attachments_.start(); }

  /// How to draw the scene: the newest mesh of each object and of the tool. They come a moment
  /// after start(), once contact has prepared its meshes, and again after its restart. Any thread.
  Eyes eyes() const { return eyes_.eyes(); }

  bool is_connected() const { return attachments_.is_connected(); }

  /// Why the session refused this client, in one line; empty if it did not. Valid once
  /// is_connected() is false.
  const std::string& refusal() const { return attachments_.refusal(); }

  /// True: hapticd was stopped by command; false: it was killed, and may come back. Valid once
  /// is_connected() is false; on the thread that reads the rings.
  bool has_ended() noexcept;
  void sleep(double seconds) const;

 private:
  EyeBook eyes_;  // outlives the thread that fills it
  Attachments attachments_;
  Source<ControlChannels> control_;
};

/// The clients of a session one after the other: hapticd may be killed and started again, under the
/// same name. Each has rings of its own, for memory of a dead session is not that of the next.
///
///   Reconnect session("bunny");
///   while (Client* client = session.next()) {
///     …   // as above, until !client->is_connected()
///   }
class Reconnect {
 public:
  /// An empty name selects the only running session.
  explicit Reconnect(std::string session) : session_(std::move(session)) {}

  /// Connects; at the second call waits until hapticd is back. Null: hapticd ended as it was told
  /// to, or `stop` says true, which is asked ten times a second. Throws HandoutError with a remedy:
  /// there is no session at the first call, or it has refused this client. The client before is
  /// gone.
  Client* next(const std::function<bool()>& stop = {});

  /// The time without a session before the present client [s]; 0: it is the first.
  double missed() const { return missed_; }
  const std::string& session() const { return session_; }

 private:
  std::string session_;
  std::unique_ptr<Client> client_;
  double missed_ = 0;
};

/// True if hapticd was stopped by command, by the header of its segment, which may be null.
bool has_ended(const SegmentHeader* control) noexcept;

/// Connects once hapticd is back; a closed descriptor: `stop` said true.
FileDescriptor connect_again(const std::string& session, const std::function<bool()>& stop);

}  // namespace haptic
