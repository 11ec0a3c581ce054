// SPDX-License-Identifier: GPL-3.0-or-later
#include "clients/eval/fingerprint.h"

#include <cstdio>
#include <filesystem>

#include "contact/bake/session.h"
#include "device-io/device.h"
#include "proto/config/renderer_needs.h"
#include "proto/os/message.h"
#include "proto/wire/renderer.h"

namespace haptic {
namespace {

std::string in_hex(uint64_t hash) {
  char text[32];
  std::snprintf(text, sizeof text, "%016llx", static_cast<unsigned long long>(hash));
  return text;
}

std::string hash_of(const SessionConfig& config, double seconds, const LockstepOptions& lockstep) {
  const BakedSession baked = bake_session(config);
  const ContactShapes shapes = baked.shapes();
  const std::unique_ptr<Device> hand = open_device(config.device);
  Lockstep session(config, shapes, *hand, lockstep);
  const auto ticks = static_cast<uint64_t>(seconds * config.servo_rate);
  for (uint64_t k = 0; k < ticks && session.step();) ++k;
  return in_hex(session.hash());
}

}  // namespace

std::vector<Row> eval_fingerprint(const std::vector<std::string>& configs, double seconds,
                                  const LockstepOptions& lockstep) {
  Rows rows("fingerprint");
  for (const std::string& file : configs) {
    const std::string scene = std::filesystem::path(file).stem();
    for (const RendererRow& row : kRenderers) {
      SessionConfig config = load_config(file);
      if (config.device.kind == DeviceKind::kWoodenHaptics) continue;  // it has no virtual time
      const std::string both = scene + ", " + std::string(row.name);
      try {
        use_renderer(config, row.name);
        rows.note(both, hash_of(config, seconds, lockstep));
      } catch (const MessageError& error) {
        rows.note(both, "left out: " + one_line(error.what()));
      }
    }
  }
  return rows.rows();
}

}  // namespace haptic
