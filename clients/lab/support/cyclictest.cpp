// SPDX-License-Identifier: GPL-3.0-or-later
#include "clients/lab/support/cyclictest.h"

#include <cstdio>
#include <sstream>

namespace haptic {
namespace {

constexpr int64_t kHistogramEndNs = 1'000'000;  // upper end of the histogram
constexpr int64_t k100us = 100'000;

}  // namespace

CyclictestRun parse_cyclictest(std::istream& output) {
  CyclictestRun run;
  for (std::string line; std::getline(output, line);) {
    long long value = 0, count = 0;
    if (std::sscanf(line.c_str(), "# Histogram Overflows: %lld", &count) == 1) {
      run.over_1ms += static_cast<uint64_t>(count);
      run.over_100us += static_cast<uint64_t>(count);
      for (long long i = 0; i < count; ++i) run.late.add(kHistogramEndNs + 1);
    } else if (!line.empty() && line[0] != '#' &&
               std::sscanf(line.c_str(), "%lld %lld", &value, &count) == 2) {
      for (long long i = 0; i < count; ++i) run.late.add(value);
      if (value > k100us) run.over_100us += static_cast<uint64_t>(count);
    }
  }
  if (run.late.count() == 0) {
    run.problem =
        "cyclictest gives no figures; install it with `./run bench` (Debian rt-tests) and run as "
        "root";
  }
  return run;
}

CyclictestRun run_cyclictest(int seconds, int core) {
  const std::string command =
      "cyclictest -q -m -N -p 80 -t 1 -i 1000 --default-system -h 1000000 "
      "-a " +
      std::to_string(core) + " -D " + std::to_string(seconds) + " 2>/dev/null";
  FILE* pipe = popen(command.c_str(), "r");
  if (pipe == nullptr) {
    CyclictestRun none;
    none.problem = "cyclictest cannot be started: no process or memory left";
    return none;
  }
  std::string text;
  char buffer[65'536];
  while (const size_t n = std::fread(buffer, 1, sizeof buffer, pipe)) text.append(buffer, n);
  pclose(pipe);
  std::istringstream output(text);
  return parse_cyclictest(output);
}

}  // namespace haptic
