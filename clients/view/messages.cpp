// SPDX-License-Identifier: GPL-3.0-or-later
#include "clients/view/messages.h"

#include "proto/os/json.h"
#include "proto/os/message.h"
#include "proto/os/version.h"

namespace haptic {
namespace {

/// "what (remedy)" taken apart.
Json fault_json(const std::string& words) {
  const size_t open = words.rfind(" (");
  if (open == words.npos || !words.ends_with(')')) return {{"text", words}, {"remedy", ""}};
  return {{"text", words.substr(0, open)},
          {"remedy", words.substr(open + 2, words.size() - open - 3)}};
}

/// Reads one entry of `giving`; false: it is none.
bool read_giver(const Json& one, SessionWords::Giver& giver) {
  if (!one.is_object()) return false;
  const auto name = one.find("name"), text = one.find("text"), state = one.find("state");
  if (name == one.end() || !name->is_string() || text == one.end() || !text->is_string()) {
    return false;
  }
  giver.name = one_line(name->get<std::string>());
  giver.text = one_line(text->get<std::string>());
  giver.is_well = state != one.end() && state->is_array() && state->empty();
  return true;
}

}  // namespace

std::string hello_message(const std::string& source, const std::string& session, double missed,
                          const std::vector<std::string>& columns) {
  Json hello{{"type", "hello"},
             {"version", version()},
             {"source", source},
             {"session", session},
             {"columns", columns.empty() ? std::vector<std::string>{session} : columns},
             {"control", false}};
  if (missed >= 0) hello["missed"] = missed;
  return json_compact(hello);
}

std::string gone_message(const std::string& text) {
  return json_compact({{"type", "gone"}, {"text", one_line(text)}});
}

std::string control_message(bool allowed, const std::string& reason) {
  return json_compact({{"type", "control"}, {"allowed", allowed}, {"reason", reason}});
}

std::string answer_message(const std::string& id, bool ok, const std::string& text) {
  return json_compact({{"type", "answer"},
                       {"id", Json::parse(id, nullptr, false)},
                       {"ok", ok},
                       {"text", one_line(text)}});
}

SessionWords parse_status(std::string_view json) {
  SessionWords words;
  const Json status = Json::parse(json, nullptr, false);
  if (!status.is_object()) return words;
  const auto clients = status.find("clients"), gone = status.find("out_of_reach"),
             reach = status.find("reach");
  if (clients != status.end() && clients->is_number_integer()) words.clients = clients->get<int>();
  if (gone != status.end() && gone->is_number_unsigned()) words.gone.bodies = gone->get<uint32_t>();
  if (reach != status.end() && reach->is_number()) words.gone.reach = reach->get<double>();
  const auto giving = status.find("giving");
  const bool has_list = giving != status.end() && giving->is_array();
  for (const Json& one : has_list ? *giving : Json::array()) {
    SessionWords::Giver giver;
    if (read_giver(one, giver)) words.giving.push_back(std::move(giver));
  }
  const auto reasons = status.find("closed_by");
  if (reasons == status.end() || !reasons->is_array()) return words;
  for (const Json& reason : *reasons) {
    if (reason.is_string()) words.closed_by.push_back(one_line(reason.get<std::string>()));
  }
  return words;
}

std::string status_message(const View& view, const SessionWords& words, size_t viewers,
                           uint64_t missed) {
  Json processes = Json::array(), faults = Json::array(), warnings = Json::array();
  Json giving = Json::array();
  for (const SessionWords::Giver& giver : words.giving) {
    giving.push_back({{"name", giver.name}, {"text", giver.text}, {"well", giver.is_well}});
  }
  for (const ProcessView& process : view.processes) {
    if (process.generation == 0) continue;
    processes.push_back({{"name", process.name},
                         {"pid", process.pid},
                         {"generation", process.generation},
                         {"runs", process.runs},
                         {"age", process.age},
                         {"rate", process.rate}});
  }
  for (const std::string& reason : words.closed_by) faults.push_back(fault_json(reason));
  if (words.gone.bodies > 0) {
    warnings.push_back({{"text", out_of_reach_text(words.gone)}, {"remedy", kMendOutOfReach}});
  }
  return json_compact({{"type", "status"},
                       {"processes", processes},
                       {"clients", words.clients},
                       {"viewers", viewers},
                       {"missed", missed},
                       {"giving", giving},
                       {"faults", faults},
                       {"warnings", warnings}});
}

}  // namespace haptic
