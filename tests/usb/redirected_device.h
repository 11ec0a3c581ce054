// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <usbredirparser.h>

#include <array>
#include <cstdint>
#include <list>
#include <memory>

#include "device-io/emulator/emulated_usb.h"
#include "proto/os/file_descriptor.h"

namespace haptic::test {

/// One end of USB redirection: an emulated device, plugged into a virtual machine over a socket to
/// QEMU's `usb-redir`. To the guest's kernel it is a full-speed device on a host controller.
///
/// Protocol: usb-redir 0.7, by libusbredirparser. Bulk IN transfers wait until the device has
/// something; interrupt endpoints push what it has.
class RedirectedDevice {
 public:
  /// Answers the guest as this device until it is destroyed. `socket` is connected to QEMU.
  RedirectedDevice(EmulatedUsb& device, FileDescriptor socket);

  /// Reads what QEMU has sent, lets the device answer, writes. False: QEMU has hung up.
  bool step(int64_t t_ns);

  /// Unplugs it: the guest's transfers end with "no such device".
  void unplug();

  /// Plugs it in again.
  void plug();
  bool is_plugged() const { return plugged_; }

  int socket() const { return socket_.get(); }

  /// Some transfer waits for the device.
  bool has_waiting() const { return !waiting_.empty() || pushing_ != 0; }

 private:
  struct Waiting {
    uint64_t id;
    usb_redir_bulk_packet_header header;
  };
  struct Destroy {
    void operator()(usbredirparser* parser) const { usbredirparser_destroy(parser); }
  };

  static RedirectedDevice& of(void* self) { return *static_cast<RedirectedDevice*>(self); }
  static int read_socket(void* self, uint8_t* bytes, int size);
  static int write_socket(void* self, uint8_t* bytes, int size);
  static void log(void* self, int level, const char* text);
  void answer_questions();
  void answer_transfers();
  void answer_control(uint64_t id, usb_redir_control_packet_header header, const UsbBytes& out);
  bool answer_standard(const UsbSetup& setup, UsbBytes& in) const;
  void answer_bulk(uint64_t id, usb_redir_bulk_packet_header header, const uint8_t* data, int size);
  void cancel(uint64_t id);
  void give_waiting();
  void push_reports();

  EmulatedUsb& device_;
  FileDescriptor socket_;
  std::unique_ptr<usbredirparser, Destroy> parser_;
  std::list<Waiting> waiting_;  // bulk IN
  uint64_t next_report_ = 0;
  uint8_t pushing_ = 0;  // interrupt endpoint that pushes
  int64_t t_ns_ = 0;
  bool plugged_ = false;
};

}  // namespace haptic::test
