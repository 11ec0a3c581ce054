// SPDX-License-Identifier: GPL-3.0-or-later
#include <catch2/catch.hpp>
#include <string>

#include "proto/config/config.h"
#include "tests/support/config_text.h"

namespace haptic {
namespace {

using test::error_of;
using test::kScene;

const std::string kClient =
    "[[client]]\n"               // 11
    "name = \"robot\"\n"         // 12
    "may = [\"move block\"]\n";  // 13

std::string client(const std::string& lines) {
  return kScene + "[[client]]\nname = \"robot\"\n" + lines;
}

}  // namespace

TEST_CASE("config: a client and what it may", "[config][client]") {
  const SessionConfig config = parse_config(
      kScene + kClient + "user = \"guest\"\nmax_force = \"3 N\"\nmax_power = \"100 mW\"\n",
      "x.toml");
  REQUIRE(config.n_clients == 1);
  const ClientConfig& robot = config.clients[0];
  CHECK(view(robot.name) == "robot");
  CHECK(view(robot.user) == "guest");
  REQUIRE(robot.n_moves == 1);
  CHECK(robot.moves[0] == 0);
  CHECK(robot.max_force == 3);
  CHECK(robot.max_power == Approx(0.1));
  CHECK(is_moved_by_client(config, 0));
  CHECK(config.sim_rate == 1000);  // what can be pushed moves at the rate of the hand
  const ClientConfig usual = parse_config(kScene + kClient, "x.toml").clients[0];
  CHECK(usual.max_force == 2);
  CHECK(usual.max_power == 0.2);
  CHECK(usual.may == 0);
  const ClientConfig all =
      parse_config(client("may = [\"draw\", \"push\", \"move block\", \"touch\"]\n"), "x.toml")
          .clients[0];
  CHECK(all.may == (kMayPush | kMayTouch | kMayDraw));
  CHECK(all.n_moves == 1);
}

TEST_CASE("config: mistakes in a client name their place and how to mend them",
          "[config][client]") {
  CHECK(error_of(client("")) ==
        "x.toml:11:1: [[client]] has no 'may'; add for example may = [\"move cup\", \"push\"]");
  CHECK(
      error_of(client("may = \"move block\"\n")) ==
      "x.toml:13:7: 'may' must be a list of 1 to 19 texts; write for example may = [\"move cup\", "
      "\"push\"]");
  CHECK(error_of(client("may = [7]\n")) ==
        "x.toml:13:8: 'may' holds a number where a text is to be; write for example may = "
        "[\"move cup\", \"push\"]");
  CHECK(error_of(client("may = [\"move blok\"]\n")) ==
        "x.toml:13:7: 'may' names 'blok', which is no [[object]]; did you mean 'block'?");
  CHECK(error_of(client("may = [\"steal block\"]\n")) ==
        "x.toml:13:7: 'may' has the right 'steal block'; write \"move OBJECT\", \"push\", "
        "\"touch\" or \"draw\"");
  CHECK(error_of(client("may = [\"move block\", \"move block\"]\n")) ==
        "x.toml:13:7: 'may' lets two clients move 'block', or one twice; name it once");
  CHECK(error_of(kScene + kClient + "[[client]]\nname = \"other\"\nmay = [\"move block\"]\n") ==
        "x.toml:16:7: 'may' lets two clients move 'block', or one twice; name it once");
  CHECK(error_of(kScene + kClient + "[[client]]\nname = \"robot\"\nmay = [\"move block\"]\n") ==
        "x.toml:15:8: 'name' is used twice ('robot'); give each [[client]] its own name");
  CHECK(error_of(kScene + "[object.body]\nmass = \"1 kg\"\n" + kClient) ==
        "x.toml:15:7: 'may' lets a client move 'block', which has a mass, so sim moves it; remove "
        "its [object.body]");
  CHECK(error_of(kScene + "[object.motion]\nkind = \"spin\"\nfrequency = \"1 Hz\"\n" + kClient) ==
        "x.toml:16:7: 'may' lets a client move 'block', which follows a script; remove its "
        "[object.motion]");
}

}  // namespace haptic
