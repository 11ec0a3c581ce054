// SPDX-License-Identifier: GPL-3.0-or-later
#include "clients/report/session_plot.h"

#include "clients/report/plot_svg.h"

namespace haptic {
namespace {

template <typename Get>
Series series(const std::string& name, const SessionData& data, const std::vector<double>& t,
              Get get) {
  Series out{name, t, {}};
  out.y.reserve(data.frames.size());
  for (const ServoFrame& f : data.frames) out.y.push_back(get(f));
  return out;
}

}  // namespace

void plot_session(const std::string& path, const std::string& title, const SessionData& data) {
  std::vector<double> t;
  t.reserve(data.frames.size());
  std::optional<int64_t> begin_ns;
  for (const ServoFrame& f : data.frames) {
    if (!begin_ns) begin_ns = f.t_ns;
    t.push_back(static_cast<double>(f.t_ns - *begin_ns) * 1e-9);
  }
  const std::vector<Panel> panels{
      {"force at the device",
       "N",
       {series("|F|", data, t, [](const ServoFrame& f) { return norm(f.F_device_B.f); })}},
      {"depth of the hand",
       "mm",
       {series("depth", data, t, [](const ServoFrame& f) { return 1e3 * f.depth; })}},
      {"wake lateness", "µs", {series("late", data, t, [](const ServoFrame& f) {
         return 1e-3 * static_cast<double>(f.wake_late_ns);
       })}}};
  write_svg(path, title, panels);
}

}  // namespace haptic
