// SPDX-License-Identifier: GPL-3.0-or-later
#include "device-io/falcon/usb_link.h"

#include <libusb-1.0/libusb.h>
#include <time.h>

#include <algorithm>
#include <stdexcept>
#include <string>
#include <utility>

#include "device-io/plugged/find_node.h"
#include "proto/ipc/process.h"
#include "proto/math/units.h"
#include "proto/os/realtime.h"

namespace haptic {
namespace {

constexpr uint8_t kVendorRequest = 0x40;
constexpr unsigned kRequestMs = 1000;  // for a request; a full-speed device answers within 5 ms
constexpr int kTurnUs = 2000;      // longest wait for an event: the age of a question is looked at
constexpr int kCancelTurns = 500;  // of kTurnUs: 1 s
constexpr long kRetryNs = 2'000'000;  // after cancelled transfers; hapticd's zero comes first

[[noreturn]] void fail(const char* what, int error) {
  throw DeviceError(std::string("the Falcon: ") + what + ": " + libusb_error_name(error) +
                    "; plug it out and in again, and close other programs that use it");
}

}  // namespace

void FalconLink::Close::operator()(libusb_context* context) const {
  libusb_exit(context);
}
void FalconLink::Close::operator()(libusb_device_handle* handle) const {
  libusb_release_interface(handle, kFalconInterface);
  libusb_close(handle);
}
void FalconLink::Close::operator()(libusb_transfer* transfer) const {
  libusb_free_transfer(transfer);
}

FalconLink::FalconLink(const DeviceConfig& config, FileDescriptor node, MotorMailbox& mailbox)
    : TransferThread(mailbox), exchange_(mailbox), node_(std::move(node)) {
  image_name_ = view(config.falcon.firmware);
  if (!image_name_.empty()) image_ = read_firmware(image_name_);
  if (!node_.is_open()) node_ = open_node(config);
  open();
  bring_up(port(), image_, image_name_);
  start([this] { run(); });
}

FalconLink::~FalconLink() {
  end();
  // libusb still knows a transfer that the kernel has not given back: it stays, as does its memory
  if (in_flight_) in_.release();
  if (out_flight_) out_.release();
}

/// Over the node that hapticd holds too, so that the claim outlives this process (decision 20).
void FalconLink::open() {
  libusb_set_option(nullptr, LIBUSB_OPTION_NO_DEVICE_DISCOVERY);
  libusb_context* context = nullptr;
  if (const int error = libusb_init(&context); error != 0) fail("libusb does not begin", error);
  context_.reset(context);
  libusb_device_handle* handle = nullptr;
  if (const int error = libusb_wrap_sys_device(context, node_.get(), &handle); error != 0) {
    fail("its node cannot be used", error);
  }
  handle_.reset(handle);
  // not libusb's own way to do so at each claim, which refuses a claim that hapticd has made
  // already
  if (libusb_kernel_driver_active(handle, kFalconInterface) == 1) {
    libusb_detach_kernel_driver(handle, kFalconInterface);
  }
  if (const int error = libusb_claim_interface(handle, kFalconInterface); error != 0) {
    fail("it is in use", error);
  }
  in_.reset(libusb_alloc_transfer(0));
  out_.reset(libusb_alloc_transfer(0));
  if (!in_ || !out_) throw std::runtime_error("no memory for two USB transfers; free some");
}

FtdiPort FalconLink::port() {
  FtdiPort port;
  port.control = [this](uint8_t request, uint16_t value) {
    const int n = libusb_control_transfer(handle_.get(), kVendorRequest, request, value, 0, nullptr,
                                          0, kRequestMs);
    if (n < 0) fail("a request failed", n);
  };
  port.send = [this](std::span<const uint8_t> bytes) {
    // a bring-up in the thread may take seconds, which nobody waits for at the end
    if (ending_) throw DeviceError("the Falcon: the session ends");
    std::vector<uint8_t> copy(bytes.begin(), bytes.end());
    int sent = 0;
    const int error = libusb_bulk_transfer(handle_.get(), kFalconOut, copy.data(),
                                           static_cast<int>(copy.size()), &sent, kRequestMs);
    if (error != 0) fail("nothing can be sent", error);
  };
  port.receive = [this](int64_t wait_ns) {
    const int64_t until_ns = now_ns() + wait_ns;
    std::array<uint8_t, kFtdiPacket> packet;
    do {
      int got = 0;
      const auto wait_ms = static_cast<unsigned>(std::max<int64_t>(1, (until_ns - now_ns()) / kMs));
      const int error =
          libusb_bulk_transfer(handle_.get(), kFalconIn, packet.data(), kFtdiPacket, &got, wait_ms);
      if (error != 0 && error != LIBUSB_ERROR_TIMEOUT) fail("nothing can be received", error);
      if (got > static_cast<int>(kModemStatus)) {
        return std::vector<uint8_t>(packet.begin() + kModemStatus, packet.begin() + got);
      }
    } while (now_ns() < until_ns);
    return std::vector<uint8_t>();
  };
  return port;
}

void FalconLink::submit(libusb_transfer* transfer, bool& in_flight) {
  const int error = libusb_submit_transfer(transfer);
  in_flight = error == 0;
  failed_ |= !in_flight;
  unplugged_ |= error == LIBUSB_ERROR_NO_DEVICE;
}

/// How a transfer ended. One that hapticd cancelled by releasing the interface ends as if the
/// device were gone (ESHUTDOWN); whether it is shows when the next one is submitted.
void FalconLink::note(int status) {
  failed_ |= status != LIBUSB_TRANSFER_COMPLETED;
}

bool FalconLink::is_silent() const {
  return now_ns() - std::max(began_ns_, exchange_->answered_ns()) > kSilentNs;
}

void FalconLink::ask_when_due() {
  const int64_t t_ns = now_ns();
  if (out_flight_ || !exchange_->may_ask(t_ns)) return;
  out_bytes_ = exchange_->ask(t_ns);
  if (tapped_) tell(false, out_bytes_, t_ns);
  submit(out_.get(), out_flight_);
}

/// Until a transfer fails, the firmware is silent, or this ends.
void FalconLink::serve() {
  libusb_fill_bulk_transfer(
      in_.get(), handle_.get(), kFalconIn, in_bytes_.data(), kFtdiPacket,
      [](libusb_transfer* t) {
        auto& self = *static_cast<FalconLink*>(t->user_data);
        self.in_flight_ = false;
        self.note(t->status);
        if (self.failed_) return;
        const std::span<const uint8_t> packet{t->buffer, static_cast<size_t>(t->actual_length)};
        const int64_t t_ns = now_ns();
        if (self.tapped_ && packet.size() > kModemStatus) self.tell(true, packet, t_ns);
        self.exchange_->hear(packet, t_ns);
        self.ask_when_due();
        self.submit(t, self.in_flight_);
      },
      this, 0);
  libusb_fill_bulk_transfer(
      out_.get(), handle_.get(), kFalconOut, out_bytes_.data(), kFalconPacket,
      [](libusb_transfer* t) {
        auto& self = *static_cast<FalconLink*>(t->user_data);
        self.out_flight_ = false;
        self.note(t->status);
        self.note_sent();
      },
      this, 0);
  failed_ = false;
  submit(in_.get(), in_flight_);
  if (!failed_) ask_when_due();
  while (!failed_ && !ending_) {
    // what has come is heard before a question counts as unanswered
    timeval wait{0, kTurnUs};
    libusb_handle_events_timeout_completed(context_.get(), &wait, nullptr);
    ask_when_due();
    follow_servo();
    if (is_silent() || is_tapped_anew()) break;
  }
}

void FalconLink::cancel() {
  if (in_flight_) libusb_cancel_transfer(in_.get());
  if (out_flight_) libusb_cancel_transfer(out_.get());
  for (int n = 0; n < kCancelTurns && (in_flight_ || out_flight_); ++n) {
    timeval wait{0, kTurnUs};
    libusb_handle_events_timeout_completed(context_.get(), &wait, nullptr);
  }
}

bool FalconLink::is_tapped_anew() const {
  return is_tapped() && !tapped_;
}

/// With nothing under way and an exchange that knows nothing, so that the record can be played to
/// another one. May throw, as port() does.
void FalconLink::begin_record() {
  const FtdiPort chip = port();
  while (!chip.receive(FalconExchange::kQuietNs).empty()) {
  }
  tapped_ = true;
  exchange_.emplace(mailbox_);
  began_ns_ = now_ns();
}

void FalconLink::run() {
  began_ns_ = now_ns();
  while (!ending_ && !unplugged_) {
    serve();
    cancel();
    if (ending_ || unplugged_ || in_flight_ || out_flight_) break;
    const timespec pause{0, kRetryNs};
    nanosleep(&pause, nullptr);
    try {
      if (is_tapped_anew()) {
        begin_record();
        continue;
      }
      exchange_->begin_anew(now_ns());
      if (!is_silent()) continue;
      bring_up(port(), image_, image_name_);
      began_ns_ = now_ns();
      exchange_->restart();
    } catch (const std::exception&) {
      break;  // hapticd's next servo says why
    }
  }
  mailbox_.set_gone();
}

}  // namespace haptic
