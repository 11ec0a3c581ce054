// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <catch2/catch.hpp>
#include <fstream>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "proto/config/config.h"
#include "tests/process/watcher.h"
#include "tests/support/data.h"
#include "tests/support/temporary_folder.h"
#include "tests/view/layout_reader.h"
#include "tests/view/socket_client.h"

/// A running session, a bridge to it and its pages.
namespace haptic::test {

inline constexpr const char* kPage = "hapticd.view.v1";

/// The session file of a block, without real-time priority, and with more at its end.
inline std::string write_session(const std::string& folder, const std::string& more) {
  std::string text = read_config_text(from_source("configs/plane.toml"));
  const std::string name = "name = \"plane\"";
  text.replace(text.find(name), name.size(), name + "\nrealtime = false");
  const std::string path = folder + "/plane.toml";
  std::ofstream(path) << text << more;
  return path;
}

/// A bridge to that session.
struct BridgeProcess : ProgramProcess {
  explicit BridgeProcess(const std::string& folder, std::vector<std::string> more = {})
      : ProgramProcess("haptic-view", arguments(std::move(more)), folder) {
    REQUIRE(eventually([&] { return said("/#token=") && said("\n"); }));
    const std::string url = log();
    const size_t at = url.find("http://127.0.0.1:");
    port = static_cast<uint16_t>(std::atoi(url.c_str() + at + 17));
    const size_t fragment = url.find("#token=") + 7;
    token = url.substr(fragment, url.find('\n', fragment) - fragment);
    host = "127.0.0.1:" + std::to_string(port);
  }
  static std::vector<std::string> arguments(std::vector<std::string> more) {
    more.insert(more.begin(), {"view", "viewed", "--port", "0", "--no-open"});
    return more;
  }

  uint16_t port = 0;
  std::string token, host;
};

struct Viewed {
  TemporaryRuntimeFolder folder;
  std::string file;
  std::unique_ptr<HapticdProcess> hapticd = start();
  Watcher watcher{"viewed"};

  explicit Viewed(const std::string& more = "") : file(write_session(folder.path(), more)) {
    REQUIRE(watcher.wait_for_all());
  }
  std::unique_ptr<HapticdProcess> start() const {
    return std::make_unique<HapticdProcess>(std::vector<std::string>{file, "--session", "viewed"},
                                            folder.path());
  }
};

/// A page that watches.
struct Page : SocketClient {
  explicit Page(const BridgeProcess& bridge) : SocketClient(bridge.port) {
    status = upgrade("/view", bridge.host, "http://" + bridge.host, kPage);
  }
  int status = 0;

  void show(const Message& frame) {
    const auto sequence = static_cast<int64_t>(LayoutReader::numbers(frame.bytes)[0]);
    tell("{\"type\":\"shown\",\"sequence\":" + std::to_string(sequence) + "}");
  }

  /// The next text of that type; the frames before it are shown.
  std::string text_of(const std::string& type, double patience = 10) {
    for (;;) {
      const Message m = message(patience);
      if (m.opcode == kBinary) show(m);
      if (m.opcode != kText && m.opcode != kBinary) return "";
      if (m.bytes.find("\"type\":\"" + type + "\"") != std::string::npos) return m.bytes;
    }
  }

  /// The next frame; it is said to be shown.
  std::vector<double> frame() {
    for (;;) {
      const Message m = message();
      if (m.opcode == kText) continue;
      if (m.opcode != kBinary) return {};
      show(m);
      return LayoutReader::numbers(m.bytes);
    }
  }
  nlohmann::json answer_to(int id, const std::string& line) {
    tell(nlohmann::json{{"type", "command"}, {"id", id}, {"line", line}}.dump());
    const std::string text = text_of("answer", 20);
    return text.empty() ? nlohmann::json::object() : nlohmann::json::parse(text);
  }
};

}  // namespace haptic::test
