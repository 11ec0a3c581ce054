// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/usb/redirected_device.h"

#include <unistd.h>
#include <usbredirproto.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <stdexcept>
#include <utility>

namespace haptic::test {
namespace {

// USB 2.0, 9.4 to 9.6
constexpr uint8_t kGetStatus = 0, kGetDescriptor = 6, kTypeMask = 0x60, kToHost = 0x80;
constexpr uint8_t kDeviceDescriptor = 1, kConfigurationDescriptor = 2, kStringDescriptor = 3,
                  kInterfaceDescriptor = 4, kEndpointDescriptor = 5, kHidReportDescriptor = 0x22;
constexpr uint8_t kEnglish[] = {4, kStringDescriptor, 0x09, 0x04};
constexpr uint8_t kNoEndpoint = 255;
constexpr uint16_t kControlPacket = 64;

/// Index of an endpoint in the tables of usb-redir: OUT below 16, IN above.
size_t slot_of(uint8_t endpoint) {
  return (endpoint & 15u) + ((endpoint & kToHost) != 0 ? 16u : 0u);
}

UsbBytes string_descriptor(const std::string& text) {
  UsbBytes bytes{static_cast<uint8_t>(2 + 2 * text.size()), kStringDescriptor};
  for (const char c : text) bytes.insert(bytes.end(), {static_cast<uint8_t>(c), 0});
  return bytes;
}

/// Calls visit(descriptor) for each one of a configuration.
template <typename Visit>
void for_each_descriptor(const UsbBytes& configuration, Visit visit) {
  for (size_t at = 0; at + 2 <= configuration.size(); at += configuration[at]) {
    if (configuration[at] < 2 || at + configuration[at] > configuration.size()) {
      throw std::logic_error("an emulated device's configuration is cut off");
    }
    visit(configuration.data() + at);
  }
}

}  // namespace

RedirectedDevice::RedirectedDevice(EmulatedUsb& device, FileDescriptor socket)
    : device_(device), socket_(std::move(socket)), parser_(usbredirparser_create()) {
  parser_->priv = this;
  parser_->log_func = log;
  parser_->read_func = read_socket;
  parser_->write_func = write_socket;
  answer_questions();
  answer_transfers();
  std::array<uint32_t, USB_REDIR_CAPS_SIZE> caps{};
  for (const int cap : {usb_redir_cap_connect_device_version, usb_redir_cap_ep_info_max_packet_size,
                        usb_redir_cap_64bits_ids, usb_redir_cap_32bits_bulk_length}) {
    usbredirparser_caps_set_cap(caps.data(), cap);
  }
  usbredirparser_init(parser_.get(), "hapticd emulated device", caps.data(), caps.size(),
                      usbredirparser_fl_usb_host);
}

int RedirectedDevice::read_socket(void* self, uint8_t* bytes, int size) {
  const ssize_t n = ::read(of(self).socket_.get(), bytes, static_cast<size_t>(size));
  if (n > 0) return static_cast<int>(n);
  return n < 0 && (errno == EAGAIN || errno == EINTR) ? 0 : -1;
}

int RedirectedDevice::write_socket(void* self, uint8_t* bytes, int size) {
  const ssize_t n = ::write(of(self).socket_.get(), bytes, static_cast<size_t>(size));
  if (n >= 0) return static_cast<int>(n);
  return errno == EAGAIN || errno == EINTR ? 0 : -1;
}

void RedirectedDevice::log(void*, int level, const char* text) {
  if (level <= usbredirparser_warning) std::fprintf(stderr, "usb-redir: %s\n", text);
}

/// Set-up of the connection; the device has one configuration, without alternatives.
void RedirectedDevice::answer_questions() {
  parser_->hello_func = [](void* self, usb_redir_hello_header*) {
    if (!of(self).plugged_) of(self).plug();
  };
  parser_->reset_func = [](void*) {};
  parser_->set_configuration_func = [](void* self, uint64_t id,
                                       usb_redir_set_configuration_header* wanted) {
    usb_redir_configuration_status_header status{usb_redir_success, wanted->configuration};
    usbredirparser_send_configuration_status(of(self).parser_.get(), id, &status);
  };
  parser_->get_configuration_func = [](void* self, uint64_t id) {
    usb_redir_configuration_status_header status{usb_redir_success, 1};
    usbredirparser_send_configuration_status(of(self).parser_.get(), id, &status);
  };
  parser_->set_alt_setting_func = [](void* self, uint64_t id,
                                     usb_redir_set_alt_setting_header* wanted) {
    usb_redir_alt_setting_status_header status{usb_redir_success, wanted->interface, wanted->alt};
    usbredirparser_send_alt_setting_status(of(self).parser_.get(), id, &status);
  };
  parser_->get_alt_setting_func = [](void* self, uint64_t id,
                                     usb_redir_get_alt_setting_header* wanted) {
    usb_redir_alt_setting_status_header status{usb_redir_success, wanted->interface, 0};
    usbredirparser_send_alt_setting_status(of(self).parser_.get(), id, &status);
  };
}

void RedirectedDevice::answer_transfers() {
  parser_->start_interrupt_receiving_func = [](void* self, uint64_t id,
                                               usb_redir_start_interrupt_receiving_header* wanted) {
    of(self).pushing_ = wanted->endpoint;
    usb_redir_interrupt_receiving_status_header status{usb_redir_success, wanted->endpoint};
    usbredirparser_send_interrupt_receiving_status(of(self).parser_.get(), id, &status);
  };
  parser_->stop_interrupt_receiving_func = [](void* self, uint64_t id,
                                              usb_redir_stop_interrupt_receiving_header* wanted) {
    of(self).pushing_ = 0;
    usb_redir_interrupt_receiving_status_header status{usb_redir_success, wanted->endpoint};
    usbredirparser_send_interrupt_receiving_status(of(self).parser_.get(), id, &status);
  };
  parser_->cancel_data_packet_func = [](void* self, uint64_t id) { of(self).cancel(id); };
  parser_->control_packet_func = [](void* self, uint64_t id,
                                    usb_redir_control_packet_header* header, uint8_t* data,
                                    int size) {
    of(self).answer_control(id, *header, UsbBytes(data, data + size));
    usbredirparser_free_packet_data(of(self).parser_.get(), data);
  };
  parser_->bulk_packet_func = [](void* self, uint64_t id, usb_redir_bulk_packet_header* header,
                                 uint8_t* data, int size) {
    of(self).answer_bulk(id, *header, data, size);
    usbredirparser_free_packet_data(of(self).parser_.get(), data);
  };
  parser_->interrupt_packet_func = [](void* self, uint64_t id,
                                      usb_redir_interrupt_packet_header* header, uint8_t* data,
                                      int size) {
    of(self).device_.take(header->endpoint, data, static_cast<size_t>(size), of(self).t_ns_);
    header->status = usb_redir_success;
    usbredirparser_send_interrupt_packet(of(self).parser_.get(), id, header, nullptr, 0);
    usbredirparser_free_packet_data(of(self).parser_.get(), data);
  };
}

void RedirectedDevice::plug() {
  const UsbDescriptors& all = device_.descriptors();
  usb_redir_interface_info_header interfaces{};
  usb_redir_ep_info_header endpoints{};
  std::fill(std::begin(endpoints.type), std::end(endpoints.type), kNoEndpoint);
  for (const size_t slot : {0u, 16u}) {
    endpoints.type[slot] = usb_redir_type_control;
    endpoints.max_packet_size[slot] = kControlPacket;
  }
  for_each_descriptor(all.configuration, [&](const uint8_t* d) {
    if (d[1] == kInterfaceDescriptor) {
      const uint32_t i = interfaces.interface_count++;
      interfaces.interface[i] = d[2];
      interfaces.interface_class[i] = d[5];
      interfaces.interface_subclass[i] = d[6];
      interfaces.interface_protocol[i] = d[7];
    } else if (d[1] == kEndpointDescriptor) {
      const size_t slot = slot_of(d[2]);
      endpoints.type[slot] = d[3] & 3u;
      endpoints.interval[slot] = d[6];
      endpoints.max_packet_size[slot] = static_cast<uint16_t>(d[4] | d[5] << 8);
    }
  });
  usb_redir_device_connect_header device{};
  device.speed = usb_redir_speed_full;
  device.vendor_id = all.vendor;
  device.product_id = all.product;
  device.device_version_bcd = static_cast<uint16_t>(all.device[12] | all.device[13] << 8);
  usbredirparser_send_interface_info(parser_.get(), &interfaces);
  usbredirparser_send_ep_info(parser_.get(), &endpoints);
  usbredirparser_send_device_connect(parser_.get(), &device);
  plugged_ = true;
}

bool RedirectedDevice::answer_standard(const UsbSetup& setup, UsbBytes& in) const {
  const UsbDescriptors& all = device_.descriptors();
  const auto number = static_cast<uint8_t>(setup.value & 255u);
  if (setup.request == kGetStatus) in = {0, 0};
  if (setup.request != kGetDescriptor) return true;
  switch (setup.value >> 8) {
    case kDeviceDescriptor:
      in = all.device;
      return true;
    case kConfigurationDescriptor:
      in = all.configuration;
      return true;
    case kHidReportDescriptor:
      in = all.hid_report;
      return !in.empty();
    case kStringDescriptor:
      if (number > all.strings.size()) return false;
      in = number == 0 ? UsbBytes(std::begin(kEnglish), std::end(kEnglish))
                       : string_descriptor(all.strings[number - 1u]);
      return true;
    default:
      return false;
  }
}

void RedirectedDevice::answer_control(uint64_t id, usb_redir_control_packet_header header,
                                      const UsbBytes& out) {
  const UsbSetup setup{header.requesttype, header.request, header.value, header.index,
                       header.length};
  UsbBytes in;
  const bool standard = (setup.type & kTypeMask) == 0;
  const bool done = standard ? answer_standard(setup, in) : device_.control(setup, out, in, t_ns_);
  header.status = done ? usb_redir_success : usb_redir_stall;
  if ((setup.type & kToHost) != 0) {
    in.resize(std::min<size_t>(in.size(), setup.length));
    header.length = static_cast<uint16_t>(in.size());
  }
  usbredirparser_send_control_packet(parser_.get(), id, &header, in.data(),
                                     static_cast<int>(in.size()));
}

void RedirectedDevice::answer_bulk(uint64_t id, usb_redir_bulk_packet_header header,
                                   const uint8_t* data, int size) {
  if ((header.endpoint & kToHost) != 0) {
    waiting_.push_back({id, header});
    return;
  }
  device_.take(header.endpoint, data, static_cast<size_t>(size), t_ns_);
  header.status = usb_redir_success;
  usbredirparser_send_bulk_packet(parser_.get(), id, &header, nullptr, 0);
}

void RedirectedDevice::cancel(uint64_t id) {
  const auto it =
      std::find_if(waiting_.begin(), waiting_.end(), [id](const Waiting& w) { return w.id == id; });
  if (it == waiting_.end()) return;  // it was answered meanwhile
  it->header.status = usb_redir_cancelled;
  it->header.length = it->header.length_high = 0;
  usbredirparser_send_bulk_packet(parser_.get(), id, &it->header, nullptr, 0);
  waiting_.erase(it);
}

void RedirectedDevice::give_waiting() {
  UsbBytes packet;
  while (!waiting_.empty()) {
    Waiting& next = waiting_.front();
    const size_t most = next.header.length | size_t{next.header.length_high} << 16;
    packet.clear();
    if (!device_.give(next.header.endpoint, most, packet, t_ns_)) return;
    next.header.status = usb_redir_success;
    next.header.length = static_cast<uint16_t>(packet.size());
    next.header.length_high = 0;
    usbredirparser_send_bulk_packet(parser_.get(), next.id, &next.header, packet.data(),
                                    static_cast<int>(packet.size()));
    waiting_.pop_front();
  }
}

void RedirectedDevice::push_reports() {
  constexpr size_t kMost = 64;  // of a full-speed interrupt endpoint
  UsbBytes report;
  while (pushing_ != 0) {
    report.clear();
    if (!device_.give(pushing_, kMost, report, t_ns_)) return;
    usb_redir_interrupt_packet_header header{pushing_, usb_redir_success,
                                             static_cast<uint16_t>(report.size())};
    usbredirparser_send_interrupt_packet(parser_.get(), next_report_++, &header, report.data(),
                                         static_cast<int>(report.size()));
  }
}

bool RedirectedDevice::step(int64_t t_ns) {
  t_ns_ = t_ns;
  if (usbredirparser_do_read(parser_.get()) == usbredirparser_read_io_error) return false;
  give_waiting();
  push_reports();
  return usbredirparser_has_data_to_write(parser_.get()) == 0 ||
         usbredirparser_do_write(parser_.get()) == 0;
}

void RedirectedDevice::unplug() {
  waiting_.clear();
  pushing_ = 0;
  plugged_ = false;
  usbredirparser_send_device_disconnect(parser_.get());
  usbredirparser_do_write(parser_.get());
}

}  // namespace haptic::test
