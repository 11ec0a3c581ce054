// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/support/usb/umock_usb.h"

#include <sys/ioctl.h>
// after it: the macros of the requests
#include <linux/usbdevice_fs.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <stdexcept>

#include "proto/os/realtime.h"

namespace haptic::test {
namespace {

constexpr uint8_t kToHost = 0x80, kTypeMask = 0x60;
constexpr size_t kSetup = 8;
constexpr int kFullSpeed = 2;  // of USBDEVFS_GET_SPEED

std::string hex_of(const UsbBytes& bytes) {
  std::string text;
  for (const uint8_t byte : bytes) {
    char two[3];
    std::snprintf(two, sizeof two, "%02X", byte);
    text += two;
  }
  return text;
}

usbdevfs_urb& urb_of(UMockdevIoctlData* data) {
  return *reinterpret_cast<usbdevfs_urb*>(data->data);
}

UMockdevIoctlData* resolved(UMockdevIoctlData* data, size_t offset, size_t size) {
  return umockdev_ioctl_data_resolve(data, offset, size, nullptr);
}

void complete(UMockdevIoctlClient* client, long result, int error) {
  umockdev_ioctl_client_complete(client, result, error);
}

}  // namespace

UmockUsb::UmockUsb(UMockdevTestbed* testbed, EmulatedUsb& device, int number)
    : testbed_(testbed), device_(device), port_("1-" + std::to_string(number)), number_(number) {
  handler_ = umockdev_ioctl_base_new();
  g_signal_connect(handler_, "handle-ioctl", G_CALLBACK(handle), this);
  add();
}

UmockUsb::~UmockUsb() {
  umockdev_testbed_detach_ioctl(testbed_, node_.c_str(), nullptr);
  g_object_unref(handler_);
}

void UmockUsb::add() {
  char three[8];
  std::snprintf(three, sizeof three, "%03d", number_);
  node_ = std::string("/dev/bus/usb/001/") + three;
  path_ = "/sys/devices/pci0000:00/usb1/" + port_;
  GError* error = nullptr;
  umockdev_testbed_attach_ioctl(testbed_, node_.c_str(), handler_, &error);
  if (error != nullptr) throw std::runtime_error(error->message);
  const UsbDescriptors& all = device_.descriptors();
  UsbBytes both = all.device;
  both.insert(both.end(), all.configuration.begin(), all.configuration.end());
  const auto attribute = [](const char* name, const std::string& value) {
    return std::string("A: ") + name + "=" + value + "\\n\n";
  };
  const auto id = [](uint16_t number) {
    char text[8];
    std::snprintf(text, sizeof text, "%04x", number);
    return std::string(text);
  };
  const std::string number = std::to_string(number_);
  std::string text = "P: /devices/pci0000:00/usb1/" + port_ + "\nN: bus/usb/001/" + three + "=" +
                     hex_of(both) +
                     "\nE: SUBSYSTEM=usb\nE: DRIVER=usb\nE: BUSNUM=001\nE: DEVNUM=" + three +
                     "\nE: DEVNAME=" + node_ + "\nE: DEVTYPE=usb_device\n";
  text += attribute("bConfigurationValue", "1") + attribute("busnum", "1") +
          attribute("devnum", number) + attribute("speed", "12") +
          attribute("idVendor", id(all.vendor)) + attribute("idProduct", id(all.product)) +
          attribute("bcdDevice", "0400") + attribute("manufacturer", all.strings.at(0)) +
          attribute("product", all.strings.at(1)) + attribute("serial", all.strings.at(2)) +
          "H: descriptors=" + hex_of(both) + "\n";
  if (!umockdev_testbed_add_from_string(testbed_, text.c_str(), &error)) {
    throw std::runtime_error(error->message);
  }
}

void UmockUsb::unplug() {
  {
    const std::lock_guard guard(lock_);
    gone_ = true;
    end_all(-ENODEV);
  }
  umockdev_testbed_uevent(testbed_, path_.c_str(), "remove");
  umockdev_testbed_remove_device(testbed_, path_.c_str());
  umockdev_testbed_detach_ioctl(testbed_, node_.c_str(), nullptr);
}

void UmockUsb::plug(int number) {
  number_ = number;
  {
    const std::lock_guard guard(lock_);
    gone_ = false;
    in_flight_.clear();
    done_.clear();
  }
  add();
  umockdev_testbed_uevent(testbed_, path_.c_str(), "add");
}

UsbfsAccount UmockUsb::account() {
  const std::lock_guard guard(lock_);
  return account_;
}

gboolean UmockUsb::handle(UMockdevIoctlBase*, UMockdevIoctlClient* client, gpointer self) {
  auto& usb = *static_cast<UmockUsb*>(self);
  const std::lock_guard guard(usb.lock_);
  return usb.answer(client, umockdev_ioctl_client_get_request(client),
                    umockdev_ioctl_client_get_arg(client))
             ? TRUE
             : FALSE;
}

void UmockUsb::end_all(int status) {
  for (UMockdevIoctlData* urb : in_flight_) {
    urb_of(urb).status = status;
    urb_of(urb).actual_length = 0;
    done_.push_back(urb);
  }
  in_flight_.clear();
}

bool UmockUsb::answer(UMockdevIoctlClient* client, unsigned long request,
                      UMockdevIoctlData* argument) {
  const bool reaps = request == USBDEVFS_REAPURB || request == USBDEVFS_REAPURBNDELAY;
  if (gone_ && !reaps) {
    complete(client, -1, ENODEV);
    return true;
  }
  switch (request) {
    case USBDEVFS_GET_CAPABILITIES: {
      UMockdevIoctlData* data = resolved(argument, 0, sizeof(uint32_t));
      const uint32_t all = USBDEVFS_CAP_ZERO_PACKET | USBDEVFS_CAP_BULK_CONTINUATION |
                           USBDEVFS_CAP_NO_PACKET_SIZE_LIM | USBDEVFS_CAP_REAP_AFTER_DISCONNECT;
      std::memcpy(data->data, &all, sizeof all);
      complete(client, 0, 0);
      umockdev_ioctl_data_unref(data);
      return true;
    }
    case USBDEVFS_CONNECTINFO: {
      UMockdevIoctlData* data = resolved(argument, 0, sizeof(usbdevfs_connectinfo));
      const usbdevfs_connectinfo info{static_cast<unsigned>(number_), 0};
      std::memcpy(data->data, &info, sizeof info);
      complete(client, 0, 0);
      umockdev_ioctl_data_unref(data);
      return true;
    }
    case USBDEVFS_GET_SPEED:
      complete(client, kFullSpeed, 0);
      return true;
    case USBDEVFS_GETDRIVER:
    case USBDEVFS_IOCTL:
      complete(client, -1, ENODATA);
      return true;
    case USBDEVFS_CLAIMINTERFACE:
    case USBDEVFS_DISCONNECT_CLAIM:
      ++account_.claims;
      complete(client, 0, 0);
      return true;
    case USBDEVFS_RELEASEINTERFACE:
      ++account_.releases;
      account_.cancelled += in_flight_.size();
      end_all(-ENOENT);
      complete(client, 0, 0);
      return true;
    case USBDEVFS_CLEAR_HALT:
    case USBDEVFS_RESET:
    case USBDEVFS_SETINTERFACE:
    case USBDEVFS_SETCONFIGURATION:
      complete(client, 0, 0);
      return true;
    case USBDEVFS_SUBMITURB:
      submit(resolved(argument, 0, sizeof(usbdevfs_urb)));
      complete(client, 0, 0);
      return true;
    case USBDEVFS_REAPURB:
    case USBDEVFS_REAPURBNDELAY: {
      const bool any = reap(argument);
      complete(client, any ? 0 : -1, any ? 0 : (gone_ ? ENODEV : EAGAIN));
      return true;
    }
    case USBDEVFS_DISCARDURB: {
      const bool found = discard(argument);
      complete(client, found ? 0 : -1, found ? 0 : EINVAL);
      return true;
    }
    case USBDEVFS_BULK: {
      UMockdevIoctlData* data = resolved(argument, 0, sizeof(usbdevfs_bulktransfer));
      const auto size = reinterpret_cast<usbdevfs_bulktransfer*>(data->data)->len;
      bulk(data);
      complete(client, static_cast<long>(size), 0);
      umockdev_ioctl_data_unref(data);
      return true;
    }
    default:
      complete(client, -1, ENOTTY);
      return true;
  }
}

void UmockUsb::bulk(UMockdevIoctlData* data) {
  const auto* transfer = reinterpret_cast<usbdevfs_bulktransfer*>(data->data);
  const size_t at = offsetof(usbdevfs_bulktransfer, data);
  UMockdevIoctlData* bytes = resolved(data, at, transfer->len);
  ++account_.bulks;
  account_.in_flight_then = in_flight_.size();
  device_.take(static_cast<uint8_t>(transfer->ep), bytes->data, transfer->len, now_ns());
  umockdev_ioctl_data_unref(bytes);
}

bool UmockUsb::standard(const UsbSetup& setup, UsbBytes& in) const {
  const UsbDescriptors& all = device_.descriptors();
  constexpr uint8_t kGetDescriptor = 6;
  if (setup.request != kGetDescriptor) return true;
  const unsigned index = setup.value & 255u;
  switch (setup.value >> 8) {
    case 1:
      in = all.device;
      return true;
    case 2:
      in = all.configuration;
      return true;
    case 3:
      if (index == 0) in = {4, 3, 9, 4};
      if (index == 0) return true;
      if (index > all.strings.size()) return false;
      in = {static_cast<uint8_t>(2 + 2 * all.strings[index - 1].size()), 3};
      for (const char c : all.strings[index - 1]) {
        in.insert(in.end(), {static_cast<uint8_t>(c), 0});
      }
      return true;
    default:
      return false;
  }
}

bool UmockUsb::control(uint8_t* bytes, int size, int& actual) {
  const auto word = [bytes](size_t at) {
    return static_cast<uint16_t>(bytes[at] | bytes[at + 1] << 8);
  };
  const UsbSetup setup{bytes[0], bytes[1], word(2), word(4), word(6)};
  const bool reads = (setup.type & kToHost) != 0;
  UsbBytes out, in;
  if (!reads) out.assign(bytes + kSetup, bytes + size);
  const bool done = (setup.type & kTypeMask) == 0 ? standard(setup, in)
                                                  : device_.control(setup, out, in, now_ns());
  in.resize(std::min(in.size(), static_cast<size_t>(size) - kSetup));
  if (reads) std::copy(in.begin(), in.end(), bytes + kSetup);
  actual = static_cast<int>(reads ? in.size() : out.size());
  return done;
}

void UmockUsb::submit(UMockdevIoctlData* data) {
  usbdevfs_urb& urb = urb_of(data);
  // the buffer is then ours too, and written back when the URB is reaped
  resolved(data, offsetof(usbdevfs_urb, buffer), static_cast<size_t>(urb.buffer_length));
  auto* bytes = static_cast<uint8_t*>(urb.buffer);
  ++account_.submitted;
  if (urb.type == USBDEVFS_URB_TYPE_CONTROL) {
    urb.status = control(bytes, urb.buffer_length, urb.actual_length) ? 0 : -EPIPE;
  } else if ((urb.endpoint & kToHost) != 0) {
    in_flight_.push_back(data);
    return;
  } else {
    device_.take(urb.endpoint, bytes, static_cast<size_t>(urb.buffer_length), now_ns());
    urb.status = 0;
    urb.actual_length = urb.buffer_length;
  }
  done_.push_back(data);
}

void UmockUsb::give_waiting() {
  for (auto it = in_flight_.begin(); it != in_flight_.end();) {
    usbdevfs_urb& urb = urb_of(*it);
    UsbBytes packet;
    const auto most = static_cast<size_t>(urb.buffer_length);
    if (!device_.give(urb.endpoint, most, packet, now_ns())) {
      ++it;
      continue;
    }
    std::memcpy(urb.buffer, packet.data(), packet.size());
    urb.actual_length = static_cast<int>(packet.size());
    urb.status = 0;
    done_.push_back(*it);
    it = in_flight_.erase(it);
  }
}

bool UmockUsb::reap(UMockdevIoctlData* argument) {
  if (!gone_ && done_.empty()) give_waiting();
  if (done_.empty()) return false;
  UMockdevIoctlData* urb = done_.front();
  done_.pop_front();
  UMockdevIoctlData* pointer = resolved(argument, 0, sizeof(gpointer));
  umockdev_ioctl_data_set_ptr(pointer, 0, urb);
  umockdev_ioctl_data_unref(pointer);
  return true;
}

bool UmockUsb::discard(UMockdevIoctlData* argument) {
  gulong address = 0;
  std::memcpy(&address, argument->data, sizeof address);
  const auto it = std::find_if(in_flight_.begin(), in_flight_.end(),
                               [address](auto* urb) { return urb->client_addr == address; });
  if (it == in_flight_.end()) return false;
  ++account_.discarded;
  urb_of(*it).status = -ENOENT;
  done_.push_back(*it);
  in_flight_.erase(it);
  return true;
}

}  // namespace haptic::test
