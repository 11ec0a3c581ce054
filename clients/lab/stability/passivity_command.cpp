// SPDX-License-Identifier: GPL-3.0-or-later
// hapt passivity: the margin of the two-port of device, hold and coupling, over frequency.
#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>

#include "clients/hapt/check_outputs.h"
#include "clients/hapt/commands.h"
#include "clients/lab/stability/axis_options.h"
#include "clients/lab/stability/margin_curve.h"
#include "clients/lab/support/measurement.h"
#include "clients/report/plot_svg.h"

namespace haptic {
namespace {

void draw_passivity(const AxisOptions& options, const std::vector<MarginPoint>& curve) {
  // what decides is near zero; at low frequencies the margin has no bound
  constexpr double kShown = 2;
  Series margin{"margin", {}, {}}, zero{"least that is allowed", {}, {}};
  for (const MarginPoint& point : curve) {
    margin.x.push_back(point.frequency);
    margin.y.push_back(std::min(point.margin, kShown));
    zero.x.push_back(point.frequency);
    zero.y.push_back(0);
  }
  write_svg(options.output, "two-port margin, " + options.config,
            {{"margin, drawn up to 2", "", {margin, zero}}}, {"frequency [Hz]", true});
}

void eval_passivity(const AxisOptions& options, const Rows& all) {
  const ProbeSetting setting = setting_of(options);
  check_outputs({options.output}, {options.config}, options.overwrite);
  const CoupledAxis axis = coupled_axis(setting);
  const AxisUnits units = units_of(options.turning);
  const std::vector<MarginPoint> curve = margin_curve(axis);
  const auto least = std::min_element(
      curve.begin(), curve.end(),
      [](const MarginPoint& a, const MarginPoint& b) { return a.margin < b.margin; });

  Rows rows = all.of(options.turning ? "turning" : "moving");
  rows.add({{"damping of the device", axis.damping, units.damping},
            {"damping of the coupling", axis.coupling_damping, units.damping},
            {"two-port margin", two_port_margin(axis), "", at_least(0)},
            {"where it is least", least->frequency, "Hz"}});
  const double most = passive_stiffness(axis);
  rows.add({{"stiffness, below 2 (b - b_c)/T", axis.stiffness, units.stiffness,
             given(most, axis.stiffness < most || axis.stiffness == 0)},
            {"largest stiffness with a margin", largest_with_margin(axis), units.stiffness}});
  if (!options.output.empty()) draw_passivity(options, curve);
}

Measured prepare_passivity(Command& command) {
  const auto options = std::make_shared<AxisOptions>();
  add_coupling_options(command, *options);
  add_axis_options(command, *options);
  return measured(eval_passivity, options);
}

}  // namespace

void add_passivity_command(Command& app) {
  measure_by(add_elsewhere(app, "passivity"), prepare_passivity,
             "hapt passivity --config bunny.toml --stiffness \"1200 N/m\" -o margin.svg");
}

}  // namespace haptic
