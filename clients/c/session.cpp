// SPDX-License-Identifier: Apache-2.0
// C: a session, its messages, and what it is told.
#include <cmath>
#include <filesystem>
#include <optional>

#include "clients/c/calls.h"
#include "proto/ipc/control_socket.h"
#include "proto/ipc/sessions.h"
#include "proto/os/realtime.h"
#include "proto/wire/wire.h"

using namespace haptic;

namespace {

/// Sends a line and keeps the answer in the session.
hapticd_result say(hapticd_session* session, const std::string& line) {
  if (std::any_of(line.begin(), line.end(),
                  [](char c) { return (c >= 0 && c < ' ') || c == '\x7f'; })) {
    throw BadArgument("'" + shown(line) + "' is no line: it holds a control character");
  }
  if (line.empty() || line.size() > kLongestCommand) {
    throw BadArgument("a line has 1 to " + std::to_string(kLongestCommand) + " bytes");
  }
  const std::string answer = say_to_session(session->name, line);
  if (const std::optional<std::string> why = refusal_in(answer)) {
    if (answer.starts_with(kMistakeAnswer)) throw BadArgument(*why);
    throw Failure(HAPTICD_REFUSED, *why);
  }
  session->answer = answer.substr(0, answer.find_last_not_of('\n') + 1);
  return HAPTICD_OK;
}

hapticd_result say_word(hapticd_session* session, const char* word) {
  return with(session, [&] { return say(session, word); });
}

}  // namespace

const char* hapticd_message() {
  return last_message();
}

const char* hapticd_session_message(const hapticd_session* session) {
  return session != nullptr ? session->message.data() : last_message();
}

uint32_t hapticd_wire_version() {
  return kAbiMajor;
}

void hapticd_sleep(double seconds) {
  // not a number is no time
  const double most = std::fmin(std::fmax(seconds, 0), 1e9);
  sleep_until(now_ns() + static_cast<int64_t>(most * 1e9));
}

hapticd_result hapticd_attach(const char* name, hapticd_session** session) {
  return attempt(nullptr, [&] {
    check_given(session);
    *session = nullptr;
    // the name alone: another session may be the only one later
    const std::string place = find_session(name != nullptr ? name : "");
    *session = new hapticd_session(std::filesystem::path(place).stem().string());
    return HAPTICD_OK;
  });
}

void hapticd_detach(hapticd_session* session) {
  close_handle(session);
}

const char* hapticd_name(const hapticd_session* session) {
  return session != nullptr ? session->name.c_str() : "";
}

hapticd_result hapticd_say(hapticd_session* session, const char* line, const char** answer) {
  if (answer != nullptr) *answer = "";
  return with(session, [&] {
    check_given(line);
    say(session, line);
    if (answer != nullptr) *answer = session->answer.c_str();
    return HAPTICD_OK;
  });
}

hapticd_result hapticd_set(hapticd_session* session, const char* key, const char* value) {
  return with(session, [&] {
    check_given(key, value);
    return say(session, std::string("set ") + key + " " + value);
  });
}

hapticd_result hapticd_arm(hapticd_session* session) {
  return say_word(session, "arm");
}

hapticd_result hapticd_disarm(hapticd_session* session) {
  return say_word(session, "disarm");
}

hapticd_result hapticd_pause(hapticd_session* session) {
  return say_word(session, "pause");
}

hapticd_result hapticd_resume(hapticd_session* session) {
  return say_word(session, "resume");
}

hapticd_result hapticd_status(hapticd_session* session, const char** json) {
  return with(session, [&] {
    check_given(json);
    return hapticd_say(session, "status", json);
  });
}
