// SPDX-License-Identifier: GPL-3.0-or-later
// What a client draws reaches a page of `hapt view`, read here by its bytes alone.
#include <cstring>
#include <memory>

#include "clients/library/drawer.h"
#include "clients/library/giver.h"
#include "tests/view/viewed_session.h"

namespace haptic {
namespace {

using namespace test;
using Json = nlohmann::json;

template <typename T>
T number_at(const std::string& bytes, size_t at) {
  T value{};
  REQUIRE(at + sizeof value <= bytes.size());
  std::memcpy(&value, bytes.data() + at, sizeof value);
  return value;
}

/// A session whose clients 'first' and 'second' may draw, and a bridge.
struct DrawnView {
  Viewed session{
      "\n[[client]]\nname = \"first\"\nmay = [\"draw\"]\n"
      "\n[[client]]\nname = \"second\"\nmay = [\"draw\"]\n"};
  BridgeProcess bridge{session.folder.path()};
  Page page{bridge};
  Json said;

  Reply get(const std::string& path) const { return test::get(bridge.port, path); }
  /// The drawing of a client that the page was told of last; null: none.
  Json drawing_of(int client) const {
    for (const Json& one : said["drawings"]) {
      if (one.at("client") == client) return one;
    }
    return nullptr;
  }
  /// Whether the page is told in time that a client shows so many points; −1: nothing.
  bool is_told(int client, int n_points) {
    for (int message = 0; message < 20; ++message) {
      const Json drawing = said.is_null() ? Json() : drawing_of(client);
      if (!said.is_null() && (drawing.is_null() ? -1 : drawing["points"].get<int>()) == n_points) {
        return true;
      }
      const std::string text = page.text_of("drawings");
      if (text.empty()) return false;
      said = Json::parse(text);
    }
    return false;
  }
};

struct ViewedPainter {
  Client client{"viewed"};
  Giver giver;
  Drawer drawer;
  explicit ViewedPainter(const std::string& name)
      : giver(client, "viewed", name), drawer(giver.seat()) {}
};

}  // namespace

TEST_CASE("view: what clients draw comes to the page, and goes with them") {
  DrawnView view;
  REQUIRE(view.page.status == 101);
  CHECK(view.get("/drawn/0.bin").status == 404);
  auto first = std::make_unique<ViewedPainter>("first");
  ViewedPainter second("second");
  std::vector<DrawnPoint> points(3000);
  for (DrawnPoint& point : points) point.radius = 1e-3;
  points[2999] = {{0.5, -0.25, 2}, 0.125, 0x102030, 0};
  const std::vector<DrawnLine> lines{{{1, 2, 3}, {4, 5, 6}, 0x405060, 0}};
  REQUIRE(first->drawer.draw(points, lines));
  REQUIRE(view.is_told(0, 3000));
  CHECK(view.drawing_of(0)["lines"] == 1);
  CHECK(view.drawing_of(0)["path"] == "/drawn/0.bin");
  const std::string bytes = view.get("/drawn/0.bin").body;
  REQUIRE(bytes.size() == 16 + 3000 * (16 + 4) + 24 + 8);
  CHECK(bytes.starts_with("HAPTDRW1"));
  CHECK(number_at<uint32_t>(bytes, 8) == 3000);
  CHECK(number_at<uint32_t>(bytes, 12) == 1);
  const std::vector<float> place{0.5f, -0.25f, 2, 0.125f};
  for (size_t i = 0; i < 4; ++i) CHECK(number_at<float>(bytes, 16 + 16 * 2999 + 4 * i) == place[i]);
  for (size_t i = 0; i < 6; ++i) {
    CHECK(number_at<float>(bytes, 16 + 16 * 3000 + 4 * i) == static_cast<float>(i + 1));
  }
  CHECK(bytes.substr(16 + 16 * 3000 + 24 + 4 * 2999, 12) ==
        std::string("\x10\x20\x30\xff\x40\x50\x60\xff\x40\x50\x60\xff"));
  // another client beside it, and a new drawing of the first
  REQUIRE(second.drawer.draw(std::span(points).first(7)));
  CHECK(view.is_told(1, 7));
  const Json before = view.drawing_of(0)["number"];
  CHECK(eventually([&] { return first->drawer.draw(std::span(points).first(2)); }));
  CHECK(view.is_told(0, 2));
  CHECK(view.drawing_of(0)["number"] != before);
  CHECK(view.get("/drawn/1.bin").body.size() == 16 + 7 * 20);
  // a page that is opened later is told of both
  Page late(view.bridge);
  CHECK(Json::parse(late.text_of("drawings"))["drawings"].size() == 2);
  first.reset();
  CHECK(view.is_told(0, -1));
  CHECK(view.get("/drawn/0.bin").status == 404);
  CHECK(view.drawing_of(1)["points"] == 7);
  // and hapticd with all of them
  view.session.hapticd.reset();
  CHECK(view.is_told(1, -1));
}

TEST_CASE("view: names of drawings that are none are not found") {
  const DrawnView view;
  for (const char* path : {"/drawn/8.bin", "/drawn/-1.bin", "/drawn/4294967296.bin", "/drawn/0",
                           "/drawn/tool.bin", "/drawn/.bin", "/drawn/0.bin/"}) {
    CHECK(view.get(path).status == 404);
  }
}

}  // namespace haptic
