// SPDX-License-Identifier: Apache-2.0
#include "proto/command_line.h"

#include <CLI/CLI.hpp>
#include <iostream>
#include <utility>

namespace haptic {
namespace {

/// What was typed wrongly, in one line.
std::string explain(const CLI::App& app, const std::string& program, const std::string& what) {
  const std::vector<CLI::App*> named = app.get_subcommands();
  const std::vector<std::string> strays = app.remaining();
  const bool no_command = app.get_require_subcommand_min() > 0 && named.empty() && !strays.empty();
  const std::string of = named.empty() ? "" : named.front()->get_name() + " ";
  return program + ": " + (no_command ? "no command '" + strays.front() + "'" : what) + "; see " +
         program + " " + of + "--help";
}

}  // namespace

Option& Option::required() {
  option_->required();
  return *this;
}

Option& Option::expected(int words) {
  option_->expected(words);
  return *this;
}

Option& Option::range(int low, int high) {
  option_->check(CLI::Range(low, high));
  return *this;
}

Option& Option::range(double low, double high) {
  option_->check(CLI::Range(low, high));
  return *this;
}

Option& Option::range(uint64_t low, uint64_t high) {
  option_->check(CLI::Range(low, high));
  return *this;
}

Option& Option::positive() {
  option_->check(CLI::PositiveNumber);
  return *this;
}

Option& Option::one_of(const std::vector<std::string>& words) {
  option_->check(CLI::IsMember(words));
  return *this;
}

Option& Option::check(const Check& check, const std::string& kind) {
  option_->check(check, kind);
  return *this;
}

Option& Option::show_default() {
  option_->capture_default_str();
  return *this;
}

Option& Option::show_default(const std::string& text) {
  option_->default_str(text);
  return *this;
}

Option& Option::needs(const std::string& option) {
  option_->needs(option);
  return *this;
}

Option& Option::excludes(const std::string& option) {
  option_->excludes(option);
  return *this;
}

Command Command::subcommand(const std::string& name, const std::string& help) {
  return Command(app_->add_subcommand(name, help));
}

bool Command::has_subcommand(const std::string& name) const {
  const auto is_named = [&](const CLI::App* command) { return command->check_name(name); };
  return !std::as_const(*app_).get_subcommands(is_named).empty();
}

void Command::require_subcommand() {
  app_->require_subcommand(1);
}

void Command::footer(const std::string& text) {
  app_->footer(text);
}

void Command::action(const std::function<void()>& action) {
  app_->callback(action);
}

Option Command::flag(const std::string& name, bool& value, const std::string& help) {
  return Option(app_->add_flag(name, value, help));
}

bool Command::was_given(const std::string& option) const {
  return app_->count(option) > 0;
}

Option Command::add_choice(const std::string& name, const std::function<void(int)>& set,
                           const std::map<std::string, int>& words, const std::string& help) {
  CLI::Option* option = app_->add_option_function<int>(name, set, help);
  option->type_name("ENUM")->transform(CLI::CheckedTransformer(words));
  return Option(option);
}

CommandLine::CommandLine(const std::string& description)
    : CommandLine(std::make_unique<CLI::App>(description)) {}

CommandLine::CommandLine(std::unique_ptr<CLI::App> owned)
    : Command(owned.get()), owned_(std::move(owned)) {}

CommandLine::~CommandLine() = default;

void CommandLine::version(const std::string& text) {
  owned_->set_version_flag("--version", text);
}

std::optional<int> CommandLine::read(int argc, char** argv, const std::string& program,
                                     int usage_code) {
  try {
    owned_->parse(argc, argv);
    return std::nullopt;
  } catch (const ExitCode& end) {
    return end.code;
  } catch (const CLI::ParseError& error) {
    // a help text is no mistake
    if (error.get_exit_code() == 0) return owned_->exit(error);
    std::cerr << explain(*owned_, program, error.what()) << '\n';
  } catch (const UsageError& error) {
    std::cerr << explain(*owned_, program, error.what()) << '\n';
  }
  return usage_code;
}

std::optional<int> CommandLine::read(int argc, char** argv) {
  try {
    owned_->parse(argc, argv);
    return std::nullopt;
  } catch (const CLI::ParseError& error) {
    return owned_->exit(error);
  }
}

template <typename T>
Option Command::option(const std::string& name, T& value, const std::string& help) {
  return Option(app_->add_option(name, value, help));
}

template Option Command::option(const std::string&, double&, const std::string&);
template Option Command::option(const std::string&, int&, const std::string&);
template Option Command::option(const std::string&, std::string&, const std::string&);
template Option Command::option(const std::string&, uint32_t&, const std::string&);
template Option Command::option(const std::string&, uint64_t&, const std::string&);
template Option Command::option(const std::string&, std::optional<uint64_t>&, const std::string&);
template Option Command::option(const std::string&, std::vector<double>&, const std::string&);
template Option Command::option(const std::string&, std::vector<std::string>&, const std::string&);
template Option Command::option(const std::string&, std::vector<uint32_t>&, const std::string&);

}  // namespace haptic
