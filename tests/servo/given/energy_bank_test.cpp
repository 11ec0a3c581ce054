// SPDX-License-Identifier: GPL-3.0-or-later
#include "servo/given/energy_bank.h"

#include <catch2/catch.hpp>
#include <numeric>
#include <random>
#include <vector>

using haptic::EnergyBank;

namespace {

constexpr double kMostPower = 0.2, kStep = 1e-3;  // [W], [s]

/// Energy that is given in each tick where somebody wants to give `wanted` [W] and is let through
/// by the bank's share.
template <typename Wanted>
std::vector<double> given_by(const Wanted& wanted, int n_ticks) {
  EnergyBank bank;
  std::vector<double> given;
  for (int n = 0; n < n_ticks; ++n) {
    given.push_back(bank.share(kMostPower) * wanted(n, bank) * kStep);
    bank.note(given.back(), kStep, kMostPower);
  }
  return given;
}

double most_in_a_second(const std::vector<double>& given) {
  double sum = 0, most = 0;
  for (size_t n = 0; n < given.size(); ++n) {
    sum += given[n] - (n >= 1000 ? given[n - 1000] : 0);
    most = std::max(most, sum);
  }
  return most;
}

}  // namespace

TEST_CASE("energy bank: no second has more than max_power, whatever is wanted") {
  std::mt19937 random(3);
  std::normal_distribution<double> normal;
  // also one that takes as much as it can first, to give it back in the worst second
  const auto greedy = [](int n, const EnergyBank&) { return n % 3000 < 1500 ? -2.0 : 4.0; };
  const auto steady = [](int, const EnergyBank&) { return 4.0; };
  const auto noise = [&](int, const EnergyBank&) { return 4 * normal(random); };
  const auto watching = [](int, const EnergyBank& bank) {
    return bank.share(kMostPower) > 0.99 ? 1.0 : -0.1;
  };
  constexpr double kTick = 20e-3;  // that one tick may be beyond [J]
  for (const double most :
       {most_in_a_second(given_by(greedy, 20'000)), most_in_a_second(given_by(steady, 20'000)),
        most_in_a_second(given_by(noise, 200'000)), most_in_a_second(given_by(watching, 20'000))}) {
    CHECK(most <= 0.95 * kMostPower + kTick);
  }
  // what is wanted for ever is given at 0.4 P
  const std::vector<double> all = given_by(steady, 20'000);
  CHECK(std::accumulate(all.begin() + 10'000, all.end(), 0.0) ==
        Approx(0.4 * kMostPower * 10).epsilon(0.01));
}

TEST_CASE("energy bank: a spring that is pressed and let go is felt in full") {
  // 20 mJ in and out, ten times a second
  const auto spring = [](int n, const EnergyBank&) { return n % 100 < 50 ? -0.4 : 0.4; };
  EnergyBank bank;
  for (int n = 0; n < 5000; ++n) {
    CHECK(bank.share(kMostPower) == 1);
    bank.note(spring(n, bank) * kStep, kStep, kMostPower);
  }
  CHECK(EnergyBank{}.share(0) == 0);
}
