// SPDX-License-Identifier: GPL-3.0-or-later
// hapt zwidth: the largest stable stiffness over the damping of the coupling.
#include <algorithm>
#include <memory>

#include "clients/hapt/check_outputs.h"
#include "clients/hapt/commands.h"
#include "clients/lab/stability/axis_options.h"
#include "clients/lab/stability/zwidth.h"
#include "clients/lab/support/measurement.h"
#include "clients/report/plot_svg.h"
#include "device-io/hand/impedance.h"
#include "proto/os/progress.h"

namespace haptic {
namespace {

struct ZwidthOptions {
  AxisOptions axis;
  std::vector<std::string> hands, dampings;
  std::vector<uint32_t> delays{0};
  bool is_controlled = false;
};

/// A hand at the device; without a name that of the session.
struct Holder {
  std::string name;
  const HandImpedance* impedance = nullptr;
};

std::vector<Holder> holders_of(const ZwidthOptions& options) {
  std::vector<Holder> out;
  for (const std::string& name : options.hands) {
    if (name == "all") {
      for (const HandImpedance& hand : kHandImpedances) {
        out.push_back({std::string(hand.name), &hand});
      }
    } else {
      out.push_back({name, find_hand(name)});
    }
  }
  if (out.empty()) out.push_back({"of the session", nullptr});
  return out;
}

/// As typed, else multiples of what the device has itself.
std::vector<double> dampings_of(const ZwidthOptions& options, const ProbeSetting& setting) {
  std::vector<double> out;
  for (const std::string& text : options.dampings) {
    out.push_back(damping_of(text, options.axis.turning));
  }
  if (!out.empty()) {
    std::sort(out.begin(), out.end());
    return out;
  }
  for (const double times : {0.0, 0.5, 1.0, 2.0, 5.0, 10.0, 20.0}) {
    out.push_back(times * coupled_axis(setting).damping);
  }
  out.erase(std::unique(out.begin(), out.end()), out.end());
  return out;
}

std::string name_of(const Holder& holder, uint32_t delay) {
  return "hand " + holder.name + ", delay " + std::to_string(delay) +
         (delay == 1 ? " tick" : " ticks");
}

/// One curve: a hand and a delay.
Series curve(const ProbeScene& scene, ProbeSetting setting, const std::vector<double>& dampings,
             const std::string& name, Rows& rows, Progress& progress) {
  Series out{name, {}, {}};
  const AxisUnits units = units_of(setting.turning);
  const auto at = [&](double damping) { return " at " + readable(damping, units.damping); };
  for (const double damping : dampings) {
    setting.damping = damping;
    const LargestStiffness found = largest_stiffness(scene, setting);
    const std::string what = found.is_at_the_end ? "stable up to at least" : "largest stiffness";
    const double rule = gil_limit(setting);
    // without any damping there is nothing to compare with
    rule > 0 ? rows.add_beside(what + at(damping), found.stiffness, units.stiffness,
                               "(b+B)/(T/2+d)", rule)
             : rows.add(what + at(damping), found.stiffness, units.stiffness);
    out.x.push_back(damping);
    out.y.push_back(found.stiffness);
    progress.step();
  }
  if (setting.delay == 0) {
    rows.add("passive below" + at(0), abbott_okamura_limit(setting), units.stiffness);
  }
  return out;
}

void eval_zwidth(const ZwidthOptions& options, const Rows& all) {
  const AxisOptions& axis = options.axis;
  ProbeSetting setting = setting_of(axis);
  setting.is_controlled = options.is_controlled;
  const std::vector<double> dampings = dampings_of(options, setting);
  const std::vector<Holder> holders = holders_of(options);
  check_outputs({axis.output}, {axis.config}, axis.overwrite);
  const ProbeScene scene(axis.turning);
  const AxisUnits units = units_of(axis.turning);

  std::vector<Panel> panels;
  Progress progress("stiffness by bisection",
                    static_cast<double>(holders.size() * dampings.size() * options.delays.size()));
  for (const uint32_t delay : options.delays) {
    setting.delay = delay;
    Panel panel{"delay " + std::to_string(delay), units.stiffness, {}};
    for (const Holder& holder : holders) {
      ProbeSetting held = setting;
      if (holder.impedance != nullptr) put_into_hand(*holder.impedance, held.hand);
      Rows rows = all.of(name_of(holder, delay));
      panel.series.push_back(curve(scene, held, dampings, holder.name, rows, progress));
    }
    panels.push_back(panel);
  }
  if (!axis.output.empty()) {
    write_svg(axis.output, "largest stable stiffness, " + axis.config, panels,
              {"damping of the coupling [" + std::string(units.damping) + "]"});
  }
}

Measured prepare_zwidth(Command& command) {
  const auto options = std::make_shared<ZwidthOptions>();
  std::vector<std::string> names{"all"};
  for (const HandImpedance& hand : kHandImpedances) names.emplace_back(hand.name);
  command.option("--hand NAME", options->hands, "who holds the device; else the session's hand")
      .one_of(names);
  command
      .option("--delay", options->delays,
              "ticks by which each force comes late; several may be given")
      .range(0, 1000)
      .show_default("0");
  command.option("--damping VALUE", options->dampings,
                 "of the coupling, as \"2 N·s/m\", with --turning \"0.01 N·m·s/rad\"; several may "
                 "be given; else multiples of the device's own");
  command.flag("--with-controller", options->is_controlled,
               "with the passivity controller, else the coupling alone");
  add_axis_options(command, options->axis);
  return measured(eval_zwidth, options);
}

}  // namespace

void add_zwidth_command(Command& app) {
  measure_by(add_elsewhere(app, "zwidth"), prepare_zwidth,
             "hapt zwidth --config plane.toml --hand none typical --delay 0 1 -o zwidth.svg");
}

}  // namespace haptic
