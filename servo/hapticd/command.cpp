// SPDX-License-Identifier: GPL-3.0-or-later
#include "servo/hapticd/command.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <vector>

#include "proto/config/config_warnings.h"
#include "proto/config/devices.h"
#include "proto/config/hand_config.h"
#include "proto/config/quantity.h"
#include "proto/config/renderer_needs.h"
#include "proto/os/message.h"
#include "proto/wire/renderer.h"

namespace haptic {
namespace {

constexpr double kUnitQuaternion = 1e-3;  // how far a written one may be from length 1

/// The reason why a command is not carried out, in one line.
struct Refusal : MessageError {
  using MessageError::MessageError;
};

/// Throws for what is lacking; an empty text: nothing.
void refuse_if(const std::string& before, const std::string& lack) {
  if (!lack.empty()) throw Refusal(before + lack);
}

/// A quantity, or without dimension a plain number. Throws Refusal, which begins with `before`.
double read_value(const std::string& before, std::string_view text,
                  std::optional<Dimension> dimension, const Range& range) try {
  return dimension ? parse_quantity(text, *dimension, range) : parse_number(text, range);
} catch (const QuantityError& error) {
  throw Refusal(before + error.what());
}

/// A command that changes the desired state: the words after its own, the session, and the state as
/// it is, then as it is asked to be.
struct Request {
  std::string_view words;
  const SessionConfig& config;
  ControlFrame wanted;
  std::string warning = {};  // what to know of the change; empty: nothing
};

/// Removes the first word from `line` and returns it.
std::string_view take_word(std::string_view& line) {
  line.remove_prefix(std::min(line.find_first_not_of(' '), line.size()));
  const std::string_view word = line.substr(0, line.find(' '));
  line.remove_prefix(word.size());
  line.remove_prefix(std::min(line.find_first_not_of(' '), line.size()));
  return word;
}

/// Names the parts that the session lacks for a renderer, given the wanted springs; empty: none.
std::string lack_with(const Request& request, Renderer renderer) {
  const ControlFrame& wanted = request.wanted;
  const Springs springs{wanted.translational_stiffness, wanted.rotational_stiffness};
  const SoftSolver solver =
      soft_solver_of(wanted.solver).value_or(solver_of(request.config.proxy, renderer));
  return lack_of(request.config, renderer, solver, springs, baked_for(request.config));
}

void set_renderer(Request& request) {
  const RendererRow* row = find_renderer(request.words);
  if (row == nullptr) throw Refusal(unknown_renderer(request.words));
  request.wanted.renderer = static_cast<uint32_t>(row->id);
  if (row->moves == Moves::kSoftBody) {
    request.wanted.solver = number_of(solver_of(request.config.proxy, row->id));
  }
  refuse_if("renderer: '" + std::string(request.words) + "' ", lack_with(request, row->id));
}

void set_solver(Request& request) {
  const std::string_view name = request.words;
  const auto known = std::ranges::find(kSoftSolverNames, name);
  if (known == kSoftSolverNames.end()) {
    const std::vector<std::string_view> names(kSoftSolverNames.begin(), kSoftSolverNames.end());
    throw Refusal("there is no solver '" + shown(name) + "'; " + suggestion(name, names));
  }
  const RendererRow& renderer = row_of(static_cast<Renderer>(request.wanted.renderer));
  if (renderer.moves != Moves::kSoftBody) {
    throw Refusal(
        "solver: the present renderer '" + std::string(renderer.name) +
        "' has one of its own; first set renderer voxel, direct6, localized or sensation");
  }
  request.wanted.solver = number_of(static_cast<SoftSolver>(known - kSoftSolverNames.begin()));
  refuse_if("solver: with '" + std::string(name) + "' the renderer ",
            lack_with(request, renderer.id));
}

/// Why the hand of this session cannot be led; empty: it can.
std::string why_not_led(const DeviceConfig& device) {
  const DeviceRow& row = row_of(device.kind);
  if (row.is_recorded) return "the device is a replay: nothing to lead";
  if (!row.can_be_led) return "the device is a real one: nothing to lead, move it by hand";
  if (device.hand.hand_stiffness > 0) return "";
  return "no hand holds the simulated device (hand_stiffness is 0): nothing to lead";
}

void lead(Request& request) {
  const SessionConfig& config = request.config;
  refuse_if("lead: ", why_not_led(config.device));
  std::array<double, 7> numbers{0, 0, 0, 1};
  size_t n = 0;
  for (; !request.words.empty() && n < numbers.size(); ++n) {
    const std::string_view word = take_word(request.words);
    numbers[n] = read_value("lead: ", word, std::nullopt, {-kMostLength, kMostLength});
  }
  const Quat q{numbers[4], numbers[5], numbers[6], numbers[3]};
  if (!request.words.empty() || (n != 3 && n != 7)) {
    throw Refusal(
        "lead: takes X Y Z of the tool in the scene [m], or X Y Z QW QX QY QZ, as 'lead 0 0 0.05'");
  }
  if (std::fabs(dot(q, q) - 1) > kUnitQuaternion) {
    throw Refusal("lead: QW QX QY QZ is no rotation; its length has to be 1");
  }
  // without an orientation, and where the handle cannot turn: the tool as the handle holds it at
  // rest
  const bool turns = n == 7 && config.device.hand.inertia > 0;
  const Quat at_rest = config.map.X_WB.q * config.map.X_HT.q;
  request.wanted.X_WT_intent = {{numbers[0], numbers[1], numbers[2]},
                                turns ? normalized(q) : at_rest};
  request.wanted.leading = 1;
}

void release(Request& request) {
  refuse_if("release: ", why_not_led(request.config.device));
  request.wanted.leading = 0;
}

/// A settable number; `most` is its largest value in SI units.
struct Parameter {
  std::string_view name;
  double ControlFrame::*target;
  double most;
  std::optional<Dimension> dimension;  // none: a plain number
};
constexpr std::array<Parameter, 5> kParameters{
    {{"stiffness", &ControlFrame::translational_stiffness, 1e5, Dimension::kStiffness},
     {"damping", &ControlFrame::translational_damping, 1e3, Dimension::kDamping},
     {"rotational-stiffness", &ControlFrame::rotational_stiffness, 1e3,
      Dimension::kRotationalStiffness},
     {"rotational-damping", &ControlFrame::rotational_damping, 10, Dimension::kRotationalDamping},
     {"time-scale", &ControlFrame::scene_time_scale, 10, std::nullopt}}};

void set(Request& request) {
  const std::string_view key = take_word(request.words);
  if (key == "renderer") return set_renderer(request);
  if (key == "solver") return set_solver(request);
  const auto parameter = std::ranges::find(kParameters, key, &Parameter::name);
  if (parameter == kParameters.end()) {
    std::vector<std::string_view> known{"renderer", "solver"};
    for (const Parameter& each : kParameters) known.push_back(each.name);
    throw Refusal("cannot set '" + shown(key) + "'; " + suggestion(key, known));
  }
  const std::string before = std::string(key) + ": ";
  request.wanted.*parameter->target =
      read_value(before, request.words, parameter->dimension, {0, parameter->most});
  const auto renderer = static_cast<Renderer>(request.wanted.renderer);
  refuse_if(before + "the present renderer ", lack_with(request, renderer));
}

/// The session as it would be.
SessionConfig changed_by(const ControlFrame& wanted, SessionConfig config) {
  config.coupling = {wanted.translational_stiffness, wanted.translational_damping,
                     wanted.rotational_stiffness, wanted.rotational_damping};
  config.renderer = static_cast<Renderer>(wanted.renderer);
  if (const auto solver = soft_solver_of(wanted.solver)) config.proxy.solver = *solver;
  return config;
}

/// set, unless the device could not hold it; with the warnings that are new.
void set_and_check(Request& request) {
  constexpr std::string_view kForce = " --force";
  const bool is_forced = request.words.ends_with(kForce);
  if (is_forced) request.words.remove_suffix(kForce.size());
  const SessionConfig now = changed_by(request.wanted, request.config);
  set(request);
  const SessionConfig changed = changed_by(request.wanted, request.config);
  if (!is_forced) refuse_if("", too_stiff(changed, &now));
  const std::vector<std::string> known = config_warnings(now);
  for (const std::string& line : config_warnings(changed)) {
    if (std::ranges::find(known, line) != known.end()) continue;
    request.warning += (request.warning.empty() ? "" : "; ") + line;
  }
}

template <auto kMember, uint32_t kValue>
void put(Request& request) {
  request.wanted.*kMember = kValue;
}

void clear_fault(Request& request) {
  ++request.wanted.fault_clears;
  request.wanted.fault = 0;
}

std::string answer_status(const SessionStatus& status, const std::string&) {
  return status_json(status);
}

std::string answer_status_text(const SessionStatus& status, const std::string&) {
  return status_text(status);
}

std::string answer_config(const SessionStatus&, const std::string& config_text) {
  return config_text;
}

/// A command is a row.
struct CommandRow {
  std::string_view word;
  std::string_view rest = {};  // exactly what follows; of one that takes words, their description
  bool takes_words = false;
  CommandKind kind = CommandKind::kChange;
  AnswerText* answer = nullptr;        // of a question
  void (*change)(Request&) = nullptr;  // of a change and of kLead; throws Refusal
};
constexpr CommandRow kCommands[] = {
    {.word = "status", .kind = CommandKind::kQuestion, .answer = answer_status},
    {.word = "status",
     .rest = "text",
     .kind = CommandKind::kQuestion,
     .answer = answer_status_text},
    {.word = "config", .kind = CommandKind::kQuestion, .answer = answer_config},
    {.word = "stop", .kind = CommandKind::kStop},
    {.word = "clear-fault", .change = clear_fault},
    {.word = "arm", .change = put<&ControlFrame::armed, 1>},
    {.word = "disarm", .change = put<&ControlFrame::armed, 0>},
    {.word = "pause", .change = put<&ControlFrame::paused, 1>},
    {.word = "resume", .change = put<&ControlFrame::paused, 0>},
    {.word = "lead",
     .rest = "X Y Z",
     .takes_words = true,
     .kind = CommandKind::kLead,
     .change = lead},
    {.word = "release", .kind = CommandKind::kLead, .change = release},
    {.word = "set",
     .rest = "stiffness|damping|rotational-stiffness|rotational-damping|time-scale|renderer|solver "
             "VALUE",
     .takes_words = true,
     .change = set_and_check},
};

/// The row of a word and what follows it. Throws Refusal, which lists all commands.
const CommandRow& find_command(std::string_view word, std::string_view rest) {
  std::string known;
  for (const CommandRow& row : kCommands) {
    if (row.word == word && (row.takes_words || row.rest == rest)) return row;
    known += (known.empty() ? "" : ", ") + std::string(row.word);
    if (!row.rest.empty()) known += " " + std::string(row.rest);
  }
  if (!rest.empty()) throw Refusal("'" + shown(word) + "' takes nothing after it");
  throw Refusal("unknown command '" + shown(word) + "'; known: " + known);
}

}  // namespace

AddressedLine read_address(std::string_view line, const SessionConfig& config) {
  AddressedLine out{line, {}};
  for (uint32_t hand = 0; hand < config.n_hands; ++hand) out.hands.push_back(hand);
  if (take_word(line) != "hand") return out;
  const std::string_view name = take_word(line);
  out.line = line;
  if (name == "all") return out;
  const auto hand = hand_named(config, name);
  if (hand) {
    out.hands = {*hand};
  } else {
    out.problem =
        "the session has no hand '" + shown(name) + "'; it has " + names_of_all_hands(config);
  }
  return out;
}

ControlCommand apply_command(std::string_view line, const SessionConfig& config,
                             ControlFrame& wanted) try {
  const std::string_view word = take_word(line);
  const CommandRow& row = find_command(word, line);
  if (row.change == nullptr) return {.kind = row.kind, .answer = row.answer};
  Request request{line, config, wanted};
  row.change(request);
  ++request.wanted.revision;
  const bool clears_fault = request.wanted.fault_clears != wanted.fault_clears;
  wanted = request.wanted;
  return {.kind = row.kind, .clears_fault = clears_fault, .warning = request.warning};
} catch (const Refusal& refusal) {
  return {.problem = refusal.what()};
}

}  // namespace haptic
