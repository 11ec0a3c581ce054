// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <random>
#include <vector>

#include "device-io/emulator/emulated_usb.h"
#include "device-io/emulator/fault_order.h"
#include "device-io/hand/plant.h"

namespace haptic {

struct EmulatedFalconOptions {
  SimulatedHandConfig hand{};  // the device and the hand that holds it
  Intention intention{};       // of that hand; none: its seeded one
  PlantLoad load{};            // beside hand and motors
  bool has_firmware = false;   // of an earlier program
  bool is_homed = true;        // once its firmware runs
  int wrong_echoes = 0;        // of the image: that many times one byte comes back wrong
  bool shows_homing = false;   // its homed bits are there whether or not homing is on
  int64_t latency_ns = -1;     // of the chip's timer, whatever it is told; −1: as told
  std::string serial{"EMU0001"};
};

/// A Novint Falcon behind its FTDI chip: the chip's requests, modem status and latency timer; the
/// boot loader with its echo; the firmware's 16-byte packets, homing and, as an assumption, a
/// watchdog of 100 ms. The handle is held by a hand (HandPlant). Its kinematics are solved here by
/// bisection on the legs' lengths, and its force by differences, not by the driver's formulas.
class EmulatedFalcon final : public EmulatedUsb {
 public:
  explicit EmulatedFalcon(const EmulatedFalconOptions& options);

  const UsbDescriptors& descriptors() const override { return descriptors_; }
  bool control(const UsbSetup& setup, const UsbBytes& out, UsbBytes& in, int64_t t_ns) override;
  void take(uint8_t endpoint, const uint8_t* bytes, size_t size, int64_t t_ns) override;
  bool give(uint8_t endpoint, size_t most, UsbBytes& packet, int64_t t_ns) override;

  void lie(EmulatorFault how) { lie_ = how; }
  /// The power is cut and comes back: no firmware, not homed.
  void cut_power();

  const HandPlant& plant() const { return plant_; }
  bool is_running() const { return state_ == State::kRunning; }
  /// On the hand, by the motors [N].
  const Vec3& force_B() const { return force_B_; }
  const std::array<int, 3>& motors() const { return motors_; }
  const std::array<int, 3>& counts() const { return counts_; }
  uint64_t packets() const { return packets_; }
  uint64_t rejected() const { return rejected_; }
  uint64_t answers() const { return answers_; }
  /// Packets that commanded a force.
  uint64_t pushing_packets() const { return pushing_; }
  size_t image_size() const { return image_.size(); }
  int64_t last_packet_ns() const { return last_packet_ns_; }
  /// Times from a packet that commanded a force to the next, where that is the zero of hapticd or
  /// of a servo that ends [ns].
  const std::vector<int64_t>& let_go_ns() const { return let_go_ns_; }
  /// Time goes on without a packet; its watchdog acts in it.
  void let_pass(int64_t t_ns) { advance_to(t_ns); }
  /// How often its watchdog, not a packet, has put an end to a force.
  uint64_t watchdogs() const { return watchdogs_; }
  /// Longest time between two packets, since the firmware runs [ns].
  int64_t longest_gap_ns() const { return longest_gap_ns_; }

 private:
  enum class State { kBoot, kGreeted, kLoading, kRunning };

  void take_byte(uint8_t byte, int64_t t_ns);
  void take_packet(int64_t t_ns);
  void answer();
  void send(const UsbBytes& bytes);
  void advance_to(int64_t t_ns);
  void sense();
  bool loses();

  EmulatedFalconOptions options_;
  UsbDescriptors descriptors_;
  // the chip
  int64_t latency_ns_ = 16'000'000, given_ns_ = 0;
  uint16_t divisor_ = 0;
  bool dtr_ = false;
  std::deque<uint8_t> to_host_;
  UsbBytes from_host_;
  // the processor
  State state_ = State::kBoot;
  UsbBytes image_;
  bool homing_ = false;
  EmulatorFault lie_ = EmulatorFault::kHealthy;
  std::array<int, 3> motors_{}, counts_{}, mirror_{};
  UsbBytes whole_;             // the last honest answer
  std::deque<UsbBytes> said_;  // the last answers, sent or not
  uint64_t packets_ = 0, rejected_ = 0, answers_ = 0, pushing_ = 0, watchdogs_ = 0;
  int64_t last_packet_ns_ = 0, longest_gap_ns_ = 0;
  std::vector<int64_t> let_go_ns_;
  // the arm and the hand
  HandPlant plant_;
  Intention intention_;
  Vec3 force_B_;
  int64_t t_ns_ = 0;
  std::minstd_rand random_{1};
};

}  // namespace haptic
