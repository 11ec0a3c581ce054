// SPDX-License-Identifier: Apache-2.0
#include "proto/config/command_line.h"

#include <CLI/CLI.hpp>
#include <cctype>
#include <iostream>
#include <utility>

#include "proto/os/message.h"

namespace haptic {
namespace {

/// The mistake in one line.
std::string explain(const CLI::App& app, const std::string& program, const std::string& what) {
  const std::vector<CLI::App*> named = app.get_subcommands();
  const std::vector<std::string> strays = app.remaining();
  const bool no_command = app.get_require_subcommand_min() > 0 && named.empty() && !strays.empty();
  const std::string of = named.empty() ? "" : named.front()->get_name() + " ";
  return program + ": " + (no_command ? "no command '" + shown(strays.front()) + "'" : what) +
         "; see " + program + " " + of + "--help";
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

Option& Option::range(uint64_t low, uint64_t high) {
  option_->check(CLI::Range(low, high));
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

namespace {

using Parse = std::function<double(const std::string&)>;

/// The message of the exception it throws, if any.
Option::Check problem_of(const Parse& parse) {
  return [parse](const std::string& text) -> std::string {
    try {
      parse(text);
      return "";
    } catch (const QuantityError& error) {
      return error.what();
    }
  };
}

CLI::Option* add_value(CLI::App* app, const std::string& name, double& value, const Parse& parse,
                       const std::string& help) {
  const auto set = [&value, parse](const std::string& text) { value = parse(text); };
  return app->add_option_function<std::string>(name, set, help)->check(problem_of(parse));
}

CLI::Option* add_values(CLI::App* app, const std::string& name, std::vector<double>& values,
                        const Parse& parse, const std::string& help) {
  using Texts = std::vector<std::string>;
  const auto set = [&values, parse](const Texts& texts) {
    values.clear();
    for (const std::string& text : texts) values.push_back(parse(text));
  };
  return app->add_option_function<Texts>(name, set, help)->check(problem_of(parse));
}

Parse parse_of(Dimension dimension, const Range& range, const std::string& bare_unit) {
  return [=](const std::string& text) { return parse_quantity(text, dimension, range, bare_unit); };
}

Parse parse_of(const Range& range) {
  return [=](const std::string& text) { return parse_number(text, range); };
}

/// Placeholder in the help text: "LENGTH".
std::string kind_of(Dimension dimension) {
  std::string kind(name_of(dimension));
  for (char& c : kind) c = static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
  return kind;
}

constexpr const char* kNumber = "NUMBER";

}  // namespace

Option Command::quantity(const std::string& name, double& value, Dimension dimension,
                         const Range& range, const std::string& help,
                         const std::string& bare_unit) {
  CLI::Option* option = add_value(app_, name, value, parse_of(dimension, range, bare_unit), help);
  option->default_function([&value, dimension] { return quantity_text(value, dimension); });
  return Option(option->type_name(kind_of(dimension)));
}

Option Command::quantities(const std::string& name, std::vector<double>& values,
                           Dimension dimension, const Range& range, const std::string& help,
                           const std::string& bare_unit) {
  CLI::Option* option = add_values(app_, name, values, parse_of(dimension, range, bare_unit), help);
  option->default_function([&values, dimension] {
    std::string text;
    for (const double value : values) {
      text += (text.empty() ? "" : ", ") + quantity_text(value, dimension);
    }
    return text;
  });
  return Option(option->type_name(kind_of(dimension)));
}

Option Command::number(const std::string& name, double& value, const Range& range,
                       const std::string& help) {
  CLI::Option* option = add_value(app_, name, value, parse_of(range), help);
  option->default_function([&value] { return number_text(value); });
  return Option(option->type_name(kNumber));
}

Option Command::numbers(const std::string& name, std::vector<double>& values, const Range& range,
                        const std::string& help) {
  return Option(add_values(app_, name, values, parse_of(range), help)->type_name(kNumber));
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
    // a request for help is no mistake
    if (error.get_exit_code() == 0) return owned_->exit(error);
    std::cerr << one_line(explain(*owned_, program, error.what())) << '\n';
  } catch (const UsageError& error) {
    std::cerr << one_line(explain(*owned_, program, error.what())) << '\n';
  }
  return usage_code;
}

template <typename T>
Option Command::option(const std::string& name, T& value, const std::string& help) {
  return Option(app_->add_option(name, value, help));
}

template Option Command::option(const std::string&, int&, const std::string&);
template Option Command::option(const std::string&, std::string&, const std::string&);
template Option Command::option(const std::string&, uint32_t&, const std::string&);
template Option Command::option(const std::string&, uint64_t&, const std::string&);
template Option Command::option(const std::string&, std::optional<uint64_t>&, const std::string&);
template Option Command::option(const std::string&, std::vector<std::string>&, const std::string&);
template Option Command::option(const std::string&, std::vector<uint32_t>&, const std::string&);

}  // namespace haptic
