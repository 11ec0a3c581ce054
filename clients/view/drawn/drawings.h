// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "clients/library/client.h"
#include "clients/library/drawing.h"
#include "clients/view/web/web.h"

namespace haptic {

/// The bytes of a drawing for a browser (docs/view-protocol.md).
std::string drawing_bytes(const Drawing& drawing);

/// The text message that says that nothing is drawn.
std::string no_drawings();

/// Keeps what the clients of a session draw, as pages are given it. The bytes of a drawing are made
/// when somebody asks for them, once for all.
class Drawings {
 public:
  /// Asks a client for the rings, which is not started yet.
  explicit Drawings(Client& client);

  /// Takes what is new, and forgets what clients have drawn that have left. True: there was some.
  /// `read_control` gives the newest ControlFrame once the pieces have been read.
  template <typename ReadControl>
  bool advance(const ReadControl& read_control) {
    bool is_new = read();
    return forget(read_control()) || is_new;
  }

  /// Gives the drawing of the client of that number in the session file; null: it shows nothing.
  SharedText bytes(uint32_t client);
  /// The text message that says what is there.
  std::string message() const;

 private:
  struct Shown {
    DrawingReader reader;
    SharedText bytes;
  };
  bool read();
  bool forget(const ControlFrame& control);

  std::vector<Shown> shown_;
};

}  // namespace haptic
