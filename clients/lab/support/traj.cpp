// SPDX-License-Identifier: GPL-3.0-or-later
#include "clients/lab/support/traj.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>

#include "proto/math/units.h"
#include "proto/os/regular_file.h"

namespace haptic {
namespace {

// [bytes]; half an hour at 1 kHz with at most 170 characters per line of seven numbers
constexpr size_t kMostText = size_t{300} << 20;

bool separates(char c) {
  return c == ' ' || c == '\t' || c == ',' || c == '\r';
}

[[noreturn]] void fail(const std::string& origin, size_t line, const std::string& what) {
  throw TrajError(origin + ":" + std::to_string(line) + ": " + what +
                  "; a line is t x y z fx fy fz, or x y z fx fy fz at 1 kHz, in SI units");
}

/// The numbers of one line, at most seven.
size_t read_numbers(std::string_view text, std::array<double, 7>& numbers,
                    const std::string& origin, size_t line) {
  size_t n = 0;
  const char* at = text.data();
  const char* const end = at + text.size();
  while (true) {
    while (at != end && separates(*at)) ++at;
    if (at == end) return n;
    double value = 0;
    const auto [rest, error] = std::from_chars(at, end, value);
    if (error != std::errc{} || (rest != end && !separates(*rest)) || !std::isfinite(value)) {
      fail(origin, line, "not a number");
    }
    if (n == numbers.size()) fail(origin, line, "more than seven numbers");
    numbers[n++] = value;
    at = rest;
  }
}

}  // namespace

std::vector<TrajSample> parse_traj(std::string_view text, const std::string& origin) {
  std::vector<TrajSample> samples;
  size_t columns = 0;
  for (size_t line = 1; !text.empty(); ++line) {
    const size_t end = std::min(text.find('\n'), text.size());
    const std::string_view row = text.substr(0, end);
    text.remove_prefix(std::min(end + 1, text.size()));
    std::array<double, 7> numbers{};
    const size_t n = read_numbers(row.substr(0, row.find('#')), numbers, origin, line);
    if (n == 0) continue;
    if (n < 6) fail(origin, line, "only " + std::to_string(n) + " numbers");
    if (columns != 0 && n != columns) fail(origin, line, "not as many numbers as above");
    columns = n;
    const double* v = numbers.data() + (n - 6);
    const double t = n == 7 ? numbers[0] : kTick * static_cast<double>(samples.size());
    if (!samples.empty() && !(t > samples.back().t)) fail(origin, line, "time does not grow");
    samples.push_back({t, {v[0], v[1], v[2]}, {v[3], v[4], v[5]}});
  }
  if (samples.empty()) fail(origin, 1, "no samples");
  return samples;
}

std::vector<TrajSample> read_traj(const std::string& path) {
  std::string text;
  const std::string problem = read_regular_file(path, kMostText, text);
  if (!problem.empty()) throw TrajError(path + ": " + problem + "; give a file of samples");
  return parse_traj(text, path);
}

std::vector<TrajSample> at_one_kilohertz(const std::vector<TrajSample>& samples) {
  std::vector<TrajSample> out;
  size_t k = 0;
  const auto n = static_cast<size_t>((samples.back().t - samples.front().t) / kTick + 1e-6) + 1;
  for (size_t i = 0; i < n; ++i) {
    const double t = samples.front().t + kTick * static_cast<double>(i);
    while (k + 2 < samples.size() && samples[k + 1].t < t) ++k;
    const TrajSample &a = samples[k], &b = samples[std::min(k + 1, samples.size() - 1)];
    const double share = b.t > a.t ? std::clamp((t - a.t) / (b.t - a.t), 0.0, 1.0) : 0;
    out.push_back(
        {t, a.p_O + share * (b.p_O - a.p_O), a.force_O + share * (b.force_O - a.force_O)});
  }
  return out;
}

}  // namespace haptic
