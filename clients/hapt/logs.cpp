// SPDX-License-Identifier: GPL-3.0-or-later
// hapt info, diff, clearance, recover: what is in a recording, how two differ, how near its tool
// came to the objects, and one that lacks its end.
#include <cstdio>
#include <iostream>
#include <string>

#include "clients/hapt/check_outputs.h"
#include "clients/hapt/commands.h"
#include "clients/hapt/options.h"
#include "clients/log/recover.h"
#include "clients/report/clearance.h"
#include "clients/report/clearance_print.h"
#include "clients/report/log_diff.h"
#include "clients/report/log_info.h"
#include "proto/config/config.h"
#include "proto/os/json.h"
#include "proto/os/message.h"
#include "proto/os/progress.h"
#include "proto/os/session_file.h"

namespace haptic {
namespace {

struct LogOptions {
  std::string log, other, output, column;
  bool json = false, overwrite = false, exact = false;
};

void run_info(const LogOptions& options) {
  Progress progress("reading", 1);
  const LogInfo info = read_log_info(options.log, [&](double share) { progress.at(share); });
  options.json ? print_info_json(std::cout, info) : print_info(std::cout, info);
}

void print_diff(const LogDiff& diff) {
  std::printf(
      "%llu ticks in both, %llu differ; %llu only in A, %llu only in B\n",
      static_cast<unsigned long long>(diff.common), static_cast<unsigned long long>(diff.different),
      static_cast<unsigned long long>(diff.only_a), static_cast<unsigned long long>(diff.only_b));
  if (diff.is_equal()) return;
  std::printf("first at tick %llu: %s, %.17g and %.17g\n",
              static_cast<unsigned long long>(diff.first_tick), diff.first_field.c_str(),
              diff.first_a, diff.first_b);
  std::printf("root mean square of the difference: force at the device %.3g N, proxy %.3g m\n",
              diff.rms_force, diff.rms_proxy);
}

void print_diff_json(const LogDiff& diff) {
  Json all{{"equal", diff.is_equal()},
           {"common", diff.common},
           {"different", diff.different},
           {"only_a", diff.only_a},
           {"only_b", diff.only_b}};
  if (!diff.is_equal()) {
    all["first_tick"] = diff.first_tick;
    all["first_field"] = diff.first_field;
  }
  all["rms_force_n"] = diff.rms_force;
  all["rms_proxy_m"] = diff.rms_proxy;
  std::cout << json_line(all) << '\n';
}

void run_diff(const LogOptions& options) {
  const LogDiff diff = diff_logs(options.log, options.other, options.column, options.exact);
  options.json ? print_diff_json(diff) : print_diff(diff);
  std::fflush(stdout);
  std::cout.flush();
  if (!diff.is_equal()) throw ExitCode{1};
}

void run_recover(const LogOptions& options) {
  check_outputs({options.output}, {options.log}, options.overwrite);
  const Recovered got = recover_log(options.log, options.output);
  for (const std::string& line : got.damaged) std::cerr << one_line(line) << "; left out\n";
  std::cout << shown(options.log) << ": "
            << (got.had_end ? "has its end" : "has no end: its recorder was killed") << '\n'
            << "  " << got.chunks << " whole chunks copied";
  if (got.attachments > 0) std::cout << ", " << got.attachments << " meshes";
  if (got.rescued > 0) std::cout << ", " << got.rescued << " messages of the chunk that is cut";
  std::cout << '\n';
  for (const auto& [topic, count] : got.messages) {
    std::cout << "  " << shown(topic) << ": " << count << '\n';
  }
  std::cout << "  lost: ";
  if (got.lost_bytes > 0 && got.rescued > 0) {
    std::cout << "what else was in the last " << got.lost_bytes << " bytes, and ";
  } else if (got.lost_bytes > 0) {
    std::cout << got.lost_bytes << " bytes that cannot be read, and ";
  }
  std::cout << (got.had_end ? "nothing at the end\n"
                            : "what the recorder had not written yet, a quarter of a second at "
                              "most\n")
            << "written to " << shown(options.output) << '\n';
}

struct ClearanceCommand {
  std::string log, config, svg;
  double at_least = 0;  // [m]
  ClearanceOptions options;
  bool json = false, overwrite = false;
};

void run_clearance(const ClearanceCommand& command) {
  check_outputs({command.svg}, {command.log}, command.overwrite);
  const SessionConfig config = command.config.empty()
                                   ? carried_session(command.log)
                                   : load_config(find_session_file(command.config));
  const BakedSession baked = bake_surfaces(config);
  ClearanceOptions options = command.options;
  Clearance clearance;
  {
    Progress progress("measuring", 1);
    options.told = [&](double share) { progress.at(share); };
    clearance = measure_clearance(command.log, config, baked, options);
  }
  command.json ? print_clearance_json(std::cout, command.log, config, clearance)
               : print_clearance(std::cout, command.log, config, clearance);
  std::cout.flush();
  if (!command.svg.empty()) plot_clearance(command.svg, command.log, config, clearance);
  const double least = clearance.tightest[clearance.nearest()].distance;
  if (!(least < command.at_least)) return;
  std::cerr << "FAILED: the tool came nearer than --at-least allows\n";
  throw ExitCode{kExitFailed};
}

}  // namespace

void add_info_command(Command& app) {
  add_command<LogOptions>(
      app, "info", "Say what is in a recording", run_info,
      [](Command& command, LogOptions& options) {
        command.option("LOG", options.log, "file of 'hapt record' (.mcap)").required();
        add_json(command, options.json);
        command.example("hapt info out.mcap");
      });
}

void add_diff_command(Command& app) {
  add_command<LogOptions>(
      app, "diff", "Compare the servo frames of two recordings, tick by tick", run_diff,
      [](Command& command, LogOptions& options) {
        command.option("A", options.log, "a recording (.mcap)").required();
        command.option("B", options.other, "another").required();
        command.option("--column NAME", options.column, "which run of a comparison")
            .show_default("the first");
        command.flag("--exact", options.exact, "instants, lateness and computing times too");
        add_json(command, options.json);
        command.example("hapt diff before.mcap after.mcap");
      });
}

void add_clearance_command(Command& app) {
  add_command<ClearanceCommand>(
      app, "clearance", "Smallest distance of the tool to each object over a recording, and where",
      run_clearance, [](Command& clearance, ClearanceCommand& command) {
        clearance.option("LOG", command.log, "file of 'hapt record' or 'hapt demo' (.mcap)")
            .required();
        clearance.option("--object NAME", command.options.object, "this object alone");
        clearance
            .quantity("--every", command.options.every, Dimension::kTime, kPositive,
                      "time between two poses that are measured, as 10ms", "s")
            .show_default("every recorded pose");
        clearance
            .quantity("--at-least", command.at_least, Dimension::kLength, kPositive,
                      "exit code 1 where the tool came nearer, as \"1 mm\"; a number alone: metres",
                      "m")
            .show_default("none");
        add_config(clearance, command.config).show_default("the one inside the recording");
        add_drawing(clearance, "--svg FILE.svg", command.svg,
                    "draw the distances over time into this file");
        add_overwrite(clearance, command.overwrite);
        add_json(clearance, command.json);
        clearance.example("hapt clearance frame.mcap --svg frame.svg");
      });
}

void add_recover_command(Command& app) {
  add_command<LogOptions>(
      app, "recover", "Copy what can be read of a recording that was cut or damaged", run_recover,
      [](Command& command, LogOptions& options) {
        command.option("LOG", options.log, "file of 'hapt record' (.mcap)").required();
        command.option("-o,--output FILE.mcap", options.output, "file to write").required();
        add_overwrite(command, options.overwrite);
        command.example("hapt recover cut.mcap -o whole.mcap");
      });
}

}  // namespace haptic
