// SPDX-License-Identifier: GPL-3.0-or-later
// hapt bode: the impedance that the servo renders against the one that the session asks for.
#include <cmath>
#include <cstdio>
#include <memory>
#include <numbers>

#include "clients/hapt/check_outputs.h"
#include "clients/hapt/commands.h"
#include "clients/lab/stability/axis_options.h"
#include "clients/lab/stability/bode.h"
#include "clients/lab/support/measurement.h"
#include "clients/report/plot_svg.h"
#include "proto/os/text.h"

namespace haptic {
namespace {

struct BodeOptions {
  AxisOptions axis;
  uint32_t delay = 0;
  int periods = 4;
};

double degrees(const std::complex<double>& z) {
  return 180 / std::numbers::pi * std::arg(z);
}
double decibels(const std::complex<double>& z) {
  return 20 * std::log10(std::abs(z));
}

/// The phase of a ratio that falls from zero on, without jumps.
std::vector<double> unwrapped(const Bode& bode) {
  std::vector<double> out;
  for (const BodePoint& point : bode.points) {
    double phase = degrees(point.ratio());
    while (!out.empty() && phase > out.back() + 180) phase -= 360;
    while (!out.empty() && phase < out.back() - 180) phase += 360;
    out.push_back(phase);
  }
  return out;
}

/// Up to where the error stays below that; the highest frequency, if it does throughout.
template <class Error>
double good_up_to(const Bode& bode, const Error& error, double most) {
  double last = 0;
  for (size_t i = 0; i < bode.points.size(); ++i) {
    if (!(error(i) <= most)) break;
    last = bode.points[i].frequency;
  }
  return last;
}

std::string at(double frequency) {
  return formatted(" at %.4g Hz", frequency);
}

void add_rows(const Bode& bode, bool turning, Rows rows) {
  const AxisUnits units = units_of(turning);
  const std::vector<double> phases = unwrapped(bode);
  for (size_t i = 0; i < bode.points.size(); ++i) {
    const BodePoint& point = bode.points[i];
    rows.add_beside("impedance" + at(point.frequency), std::abs(point.rendered), units.damping,
                    "what is intended", std::abs(point.intended));
    rows.add("phase beside it" + at(point.frequency), phases[i], "deg");
  }
  const auto gain_error = [&](size_t i) { return std::fabs(decibels(bode.points[i].ratio())); };
  const auto phase_error = [&](size_t i) { return std::fabs(phases[i]); };
  rows.add({{"within 3 dB up to", good_up_to(bode, gain_error, 3), "Hz"},
            {"within 45 deg up to", good_up_to(bode, phase_error, 45), "Hz"},
            {"distortion", bode.distortion}});
}

void draw_bode(const AxisOptions& options, const Bode& bode) {
  const std::vector<double> phases = unwrapped(bode);
  Series gain{"rendered", {}, {}}, gain_meant{"intended", {}, {}}, phase = gain,
                                                                   phase_meant = gain_meant;
  for (size_t i = 0; i < bode.points.size(); ++i) {
    const BodePoint& point = bode.points[i];
    for (Series* series : {&gain, &gain_meant, &phase, &phase_meant}) {
      series->x.push_back(point.frequency);
    }
    gain.y.push_back(decibels(point.rendered));
    gain_meant.y.push_back(decibels(point.intended));
    phase_meant.y.push_back(degrees(point.intended));
    phase.y.push_back(phase_meant.y.back() + phases[i]);
  }
  const std::string unit = units_of(options.turning).damping;
  write_svg(options.output, "rendered impedance, " + options.config,
            {{"impedance", "dB of 1 " + unit, {gain, gain_meant}},
             {"phase", "deg", {phase, phase_meant}}},
            {"frequency [Hz]", true});
}

void eval_bode(const BodeOptions& options, const Rows& all) {
  ProbeSetting setting = setting_of(options.axis);
  setting.delay = options.delay;
  if (!(setting.stiffness > 0)) {
    throw UsageError("the coupling has no stiffness along this axis; give --stiffness");
  }
  check_outputs({options.axis.output}, {options.axis.config}, options.axis.overwrite);
  const ProbeScene scene(options.axis.turning);
  const Bode bode = measure_bode(scene, setting, options.periods);
  if (!options.axis.output.empty()) draw_bode(options.axis, bode);
  add_rows(bode, options.axis.turning, all.of(options.axis.turning ? "turning" : "moving"));
}

Measured prepare_bode(Command& command) {
  const auto options = std::make_shared<BodeOptions>();
  add_counts(command,
             {{"--delay", &options->delay, "ticks by which each force comes late", 0, 400},
              {"--periods", &options->periods, "averaged; a period is a thousand ticks", 1, 1000}});
  add_coupling_options(command, options->axis);
  add_axis_options(command, options->axis);
  return measured(eval_bode, options);
}

}  // namespace

void add_bode_command(Command& app) {
  measure_by(add_elsewhere(app, "bode"), prepare_bode,
             "hapt bode --config plane.toml --delay 1 -o bode.svg");
}

}  // namespace haptic
