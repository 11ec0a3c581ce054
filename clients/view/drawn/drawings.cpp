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

template <typename T>
void append_raw(std::string& bytes, std::initializer_list<T> values) {
  for (const T value : values) {
    std::array<char, sizeof value> raw;
    std::memcpy(raw.data(), &value, sizeof value);
    bytes.append(raw.data(), raw.size());
  }
}

void append_place(std::string& bytes, const Vec3& p) {
  append_raw(bytes, {static_cast<float>(p.x), static_cast<float>(p.y), static_cast<float>(p.z)});
}

void append_colour(std::string& bytes, uint32_t colour) {
  constexpr uint8_t kOpaque = 255;
  append_raw(bytes, {static_cast<uint8_t>(colour >> 16), static_cast<uint8_t>(colour >> 8),
                     static_cast<uint8_t>(colour), kOpaque});
}

}  // namespace

std::string drawing_bytes(const Drawing& drawing) {
  constexpr size_t kHeader = 16, kPoint = 4 * sizeof(float) + 4, kLine = 6 * sizeof(float) + 8;
  std::string bytes(kMagic);
  bytes.reserve(kHeader + drawing.points.size() * kPoint + drawing.lines.size() * kLine);
  append_raw(bytes, {static_cast<uint32_t>(drawing.points.size()),
                     static_cast<uint32_t>(drawing.lines.size())});
  for (const DrawnPoint& point : drawing.points) {
    append_place(bytes, point.p_W);
    append_raw(bytes, {static_cast<float>(point.radius)});
  }
  for (const DrawnLine& line : drawing.lines) {
    append_place(bytes, line.from_W);
    append_place(bytes, line.to_W);
  }
  for (const DrawnPoint& point : drawing.points) append_colour(bytes, point.colour);
  for (const DrawnLine& line : drawing.lines) {
    append_colour(bytes, line.colour);
    append_colour(bytes, line.colour);
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
