// SPDX-License-Identifier: GPL-3.0-or-later
#include "clients/view/drawn/drawings.h"

#include <cstring>
#include <utility>

#include "proto/os/json.h"

namespace haptic {
namespace {

// of a client in a tick of the bridge, so that its frames do not wait: 16 pieces are copied in
// about a millisecond, and 60 drawings a second of the most pieces that are allowed need 5
constexpr int kMostPiecesAtOnce = 16;
constexpr std::string_view kMagic = "HAPTDRW1";

/// Bytes written one after the other, where there is room for them.
struct ByteWriter {
  char* at;

  template <typename... T>
  void put(T... values) {
    ((std::memcpy(at, &values, sizeof values), at += sizeof values), ...);
  }
  void put_place(const Vec3& p) {
    put(static_cast<float>(p.x), static_cast<float>(p.y), static_cast<float>(p.z));
  }
  void put_colour(uint32_t colour) {
    constexpr uint8_t kOpaque = 255;
    put(static_cast<uint8_t>(colour >> 16), static_cast<uint8_t>(colour >> 8),
        static_cast<uint8_t>(colour), kOpaque);
  }
};

}  // namespace

std::string drawing_bytes(const Drawing& drawing) {
  const size_t n_points = drawing.points.size(), n_lines = drawing.lines.size();
  constexpr size_t kHeader = 16, kPoint = 4 * sizeof(float) + 4, kLine = 6 * sizeof(float) + 8;
  std::string bytes(kHeader + n_points * kPoint + n_lines * kLine, '\0');
  kMagic.copy(bytes.data(), kMagic.size());
  ByteWriter out{bytes.data() + kMagic.size()};
  out.put(static_cast<uint32_t>(n_points), static_cast<uint32_t>(n_lines));
  for (const DrawnPoint& point : drawing.points) {
    out.put_place(point.p_W);
    out.put(static_cast<float>(point.radius));
  }
  for (const DrawnLine& line : drawing.lines) {
    out.put_place(line.from_W);
    out.put_place(line.to_W);
  }
  for (const DrawnPoint& point : drawing.points) out.put_colour(point.colour);
  for (const DrawnLine& line : drawing.lines) {
    out.put_colour(line.colour);
    out.put_colour(line.colour);
  }
  return bytes;
}

Drawings::Drawings(Client& client) {
  for (uint32_t c = 0; c < kMostClients; ++c) {
    auto ring = client.ring<&DrawChannels::pieces>(Start::kOldest, c);
    shown_.push_back({DrawingReader(ring), nullptr});
  }
}

bool Drawings::read() {
  bool is_new = false;
  for (Shown& one : shown_) {
    if (!one.reader.read(kMostPiecesAtOnce)) continue;
    one.bytes.reset();
    is_new = true;
  }
  return is_new;
}

bool Drawings::forget(const ControlFrame& control) {
  bool is_new = false;
  for (uint32_t c = 0; c < kMostClients; ++c) {
    if (!shown_[c].reader.forget_unless(control.giving[c])) continue;
    shown_[c].bytes.reset();
    is_new = true;
  }
  return is_new;
}

SharedText Drawings::bytes(uint32_t client) {
  if (client >= shown_.size()) return nullptr;
  Shown& one = shown_[client];
  if (one.reader.newest().generation == 0) return nullptr;
  if (one.bytes == nullptr) one.bytes = shared_text(drawing_bytes(one.reader.newest()));
  return one.bytes;
}

std::string no_drawings() {
  return json_compact({{"type", "drawings"}, {"drawings", Json::array()}});
}

std::string Drawings::message() const {
  Json drawings = Json::array();
  for (size_t c = 0; c < shown_.size(); ++c) {
    const Drawing& drawing = shown_[c].reader.newest();
    if (drawing.generation == 0) continue;
    drawings.push_back(
        {{"client", c},
         {"number", std::to_string(drawing.generation) + "." + std::to_string(drawing.number)},
         {"points", drawing.points.size()},
         {"lines", drawing.lines.size()},
         {"path", "/drawn/" + std::to_string(c) + ".bin"}});
  }
  return json_compact({{"type", "drawings"}, {"drawings", drawings}});
}

}  // namespace haptic
