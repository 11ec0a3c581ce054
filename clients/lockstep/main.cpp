// SPDX-License-Identifier: GPL-3.0-or-later
// haptic-lockstep: a session step by step, for a program that moves the hand itself.
//
// In:   DeviceState records on standard input, as they lie in memory (docs/wire.md); each is the
//       hand's sample of one tick.
// Loop: read a sample; make one tick of servo, contact and sim on virtual time (Lockstep); write.
// Out:  one line of JSON, then of each tick the ServoFrame, the ContactSet that it used (an empty
//       one before the first) and the SceneFrame: each a uint32 number of words of 8 bytes, a
//       uint32 zero, and these words, packed (proto/wire/packing.h). What is read decides what is
//       written, to the last bit: there is no clock, thread or chance in it.
// Ends: at the end of input, or after a sample that is kDeviceEnded. Half a record is an error.
// Bound: one sample and one tick are in memory, whatever is sent; a sample that no hand can be at
//       is the servo's to flag, and its instant is that of its tick, so that no sample is of later.
#include <array>
#include <cerrno>
#include <cstdio>
#include <memory>
#include <string>
#include <system_error>

#include "clients/lockstep/lockstep.h"
#include "contact/bake/session.h"
#include "proto/config/command_line.h"
#include "proto/config/devices.h"
#include "proto/config/renderer_needs.h"
#include "proto/os/message.h"
#include "proto/os/realtime.h"
#include "proto/os/session_file.h"
#include "proto/os/text.h"
#include "proto/wire/packing.h"
#include "proto/wire/wire.h"

namespace haptic {
namespace {

constexpr size_t kOutputBuffer = 64 * 1024;  // a tick of some objects is one write [bytes]

/// A hand whose place is said from outside, tick by tick.
class ToldHand : public Device {
 public:
  explicit ToldHand(const DeviceConfig& config)
      : caps_{.max_force = config.max_force, .max_torque = config.max_torque, .simulated = true} {}

  DeviceCaps caps() const override { return caps_; }
  std::string description() const override { return "a hand that another program moves"; }
  bool read(const TickTime& tick, DeviceState& state) override {
    const bool is_fresh = (told.flags & kDeviceFresh) != 0;
    if (is_fresh) measured_ns_ = tick.now_ns;
    state = told;
    state.t_ns = measured_ns_;
    return is_fresh;
  }
  void write(const Wrench& /*F_B*/) override {}
  void stop() override {}

  DeviceState told{};

 private:
  DeviceCaps caps_;
  int64_t measured_ns_ = 0;
};

/// The session of a file, whatever its device: no motor is behind it.
SessionConfig load(const std::string& path, const std::string& renderer) {
  SessionConfig config = load_config(path);
  if (!renderer.empty()) use_renderer(config, renderer);
  if (config.device.kind == DeviceKind::kSimulatedArm) {
    throw InputError(shown(path) +
                     ": the arm of an admittance device is where the servo moves it; " +
                     "name a device that the hand moves, as kind = \"simulated-hand\" in [device]");
  }
  if (row_of(config.device.kind).has_node()) config.safety.armed_at_start = 1;
  return config;
}

/// False: the end of input. Throws InputError where it ends within a record.
bool read_sample(DeviceState& sample) {
  const size_t n = std::fread(&sample, 1, sizeof sample, stdin);
  if (std::ferror(stdin) != 0) {
    throw std::system_error(errno, std::generic_category(), "standard input cannot be read");
  }
  if (n == 0 || n == sizeof sample) return n != 0;
  throw InputError(
      formatted("standard input ends %zu bytes after the beginning of a DeviceState, "
                "which has %zu; write whole records (docs/wire.md)",
                n, sizeof sample));
}

template <typename T>
void write_record(const T& record) {
  size_t length = 0;
  Packing<T>::for_each_run(record, [&](const std::byte*, size_t bytes) { length += bytes; });
  const std::array<uint32_t, 2> head{static_cast<uint32_t>(length / 8), 0};
  std::fwrite(head.data(), sizeof head, 1, stdout);
  Packing<T>::for_each_run(
      record, [](const std::byte* begin, size_t bytes) { std::fwrite(begin, bytes, 1, stdout); });
}

/// The reader gets all that has been written.
void flush() {
  if (std::fflush(stdout) == 0 && std::ferror(stdout) == 0) return;
  throw std::system_error(errno, std::generic_category(), "standard output cannot be written");
}

void run(const std::string& file, const std::string& renderer) {
  const std::string path = find_session_file(file);
  const SessionConfig config = load(path, renderer);
  const BakedSession baked = bake_session(config);
  const ContactShapes shapes = baked.shapes();
  ToldHand hand(config.device);
  const auto lockstep = std::make_unique<Lockstep>(config, shapes, hand);
  std::setvbuf(stdout, nullptr, _IOFBF, kOutputBuffer);
  std::printf("{\"abi\": %u, \"period_ns\": %lld, \"servo_rate\": %.17g, \"t_ns\": %lld}\n",
              kAbiMajor, static_cast<long long>(period_ns(config.servo_rate)), config.servo_rate,
              static_cast<long long>(lockstep->next_t_ns()));
  flush();
  const auto none = std::make_unique<ContactSet>();
  while (read_sample(hand.told) && lockstep->step()) {
    const ContactSet* const used = lockstep->contacts();
    write_record(lockstep->frame());
    write_record(used != nullptr ? *used : *none);
    write_record(lockstep->scene());
    flush();
  }
}

}  // namespace
}  // namespace haptic

int main(int argc, char** argv) try {
  std::string file, renderer;
  haptic::CommandLine line("haptic-lockstep",
                           "Runs a session step by step on virtual time: a tick for each "
                           "DeviceState on standard input, its frames on standard output.");
  line.option("CONFIG.toml", file, "the scene and the limits: a path, or a name as peg or plane")
      .required();
  line.option("--renderer", renderer, "instead of the file's: " + haptic::renderer_names());
  if (const auto code = line.read(argc, argv)) return *code;
  haptic::run(file, renderer);
  return 0;
} catch (const std::exception& error) {
  return haptic::report_failure("haptic-lockstep", error);
}
