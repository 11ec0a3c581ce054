// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "device-io/falcon/bring_up.h"
#include "device-io/falcon/exchange.h"
#include "device-io/motors/transfer_thread.h"
#include "proto/config/device_config.h"
#include "proto/os/file_descriptor.h"

struct libusb_context;
struct libusb_device_handle;
struct libusb_transfer;

namespace haptic {

inline constexpr uint8_t kFalconInterface = 0, kFalconIn = 0x81,
                         kFalconOut = 0x02;  // endpoints, by the device's descriptor

/// The USB side of a Falcon: brings it up, then keeps two asynchronous transfers in flight in a
/// thread of its own, which serves the mailbox until the device is unplugged or this is destroyed.
///
/// A tap hears the packets of the exchange, not of the bring-up: the firmware's image is not
/// for handing on.
///
/// The thread's own code does not allocate. libusb 1.0.26 allocates on Linux an array of URBs for
/// each transfer that is submitted, and frees it when the transfer is reaped: on this thread, never
/// on the servo's.
///
/// Transfers that were cancelled (hapticd has let go of the device for a servo that was late) begin
/// anew. A firmware that stops answering while its chip does not (the power was cut) is brought up
/// anew after kSilentNs; the device is then not homed.
class FalconLink final : public TransferThread {
 public:
  /// Takes the open node, or finds and opens it. Blocks for up to some seconds, for the firmware.
  /// Throws DeviceError or InputError in one line.
  FalconLink(const DeviceConfig& config, FileDescriptor node, MotorMailbox& mailbox);
  ~FalconLink() override;

  static constexpr int64_t kSilentNs = 2'000'000'000;

 private:
  struct Close {
    void operator()(libusb_context* context) const;
    void operator()(libusb_device_handle* handle) const;
    void operator()(libusb_transfer* transfer) const;
  };

  FtdiPort port();
  void open();
  void run();
  void serve();
  void note(int status);
  bool is_silent() const;
  void submit(libusb_transfer* transfer, bool& in_flight);
  void ask_when_due();
  void cancel();
  bool is_tapped_anew() const;
  void begin_record();

  std::optional<FalconExchange> exchange_;
  FileDescriptor node_;  // outlives the handle
  std::vector<uint8_t> image_;
  std::string image_name_;
  std::unique_ptr<libusb_context, Close> context_;
  std::unique_ptr<libusb_device_handle, Close> handle_;
  std::unique_ptr<libusb_transfer, Close> in_, out_;
  std::array<uint8_t, kFtdiPacket> in_bytes_{};
  FalconBytes out_bytes_{};
  bool in_flight_ = false, out_flight_ = false, failed_ = false, unplugged_ = false;
  bool tapped_ = false;
  int64_t began_ns_ = 0;
};

}  // namespace haptic
