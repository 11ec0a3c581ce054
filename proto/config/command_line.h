// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "proto/config/quantity.h"

namespace CLI {  // NOLINT(readability-identifier-naming): of the library
class App;
class Option;
}  // namespace CLI

/// A front to CLI11, whose header takes seconds to compile: only command_line.cpp includes it.
namespace haptic {

/// Thrown by an action to end the program with this code, without a message.
struct ExitCode {
  int code;
};

/// Thrown by an action that finds a mistake in the command line.
struct UsageError : InputError {
  using InputError::InputError;
};

/// Exit codes of every program that people start, beside 0: something failed, or a goal was missed;
/// the command line, the session file or a file that one of them names is wrong.
inline constexpr int kExitFailed = 1, kExitUsage = 2;

/// Prints "program: what" on standard error, one line, and returns the exit code.
int report_failure(const std::string& program, const std::exception& error);

/// Handle of one option. Other options are named as typed.
class Option {
 public:
  /// Problem of a word, in one line; empty: none.
  using Check = std::function<std::string(const std::string&)>;

  explicit Option(CLI::Option* option) : option_(option) {}
  Option& required();
  /// Number of words after the option.
  Option& expected(int words);
  /// Refuses a whole number outside of these bounds.
  Option& range(int64_t low, int64_t high);
  /// The help text explains the words.
  Option& one_of(const std::vector<std::string>& words);
  Option& check(const Check& check);
  /// Shows the variable's present value as default in the help text.
  Option& show_default();
  /// Shows this text as default in the help text.
  Option& show_default(const std::string& text);
  Option& needs(const std::string& option);
  Option& excludes(const std::string& option);

 private:
  CLI::Option* option_;
};

/// Handle of a command with its options and subcommands.
class Command {
 public:
  Command subcommand(const std::string& name, const std::string& help);
  bool has_subcommand(const std::string& name) const;
  /// Requires exactly one subcommand.
  void require_subcommand();
  /// Refuses options of this command in front of a subcommand; call it when it has all of both.
  void exclude_subcommands();
  /// A paragraph below the help text.
  void footer(const std::string& text);
  /// A command line below the help text, shown as it is.
  void example(const std::string& line);
  /// Runs once all words are parsed, unless they name a subcommand. Its exceptions reach the caller
  /// of read().
  void action(const std::function<void()>& action);

  /// Names are written as in a manual: "-o,--output FILE" is an option with the placeholder of its
  /// value, "MESH" an argument. The variable must outlive the parsing. T: one of the types at the
  /// end of command_line.cpp.
  template <typename T>
  Option option(const std::string& name, T& value, const std::string& help);
  Option flag(const std::string& name, bool& value, const std::string& help);

  /// A quantity such as "80 mm"; a number without unit is taken in `bare_unit`, if there is one.
  /// `value` is in SI units. Problems are reported as by parse_quantity(). Value: double; an
  /// optional one, which stays empty where the option is not typed; a vector, of several words.
  template <typename Value>
  Option quantity(const std::string& name, Value& value, Dimension dimension, const Range& range,
                  const std::string& help, const std::string& bare_unit = "");
  /// A number without unit; Value as above.
  template <typename Value>
  Option number(const std::string& name, Value& value, const Range& range, const std::string& help);

  /// One of several words, each mapped to a value. The help text lists them.
  template <typename Enum>
  Option choice(const std::string& name, Enum& value, const std::map<std::string, Enum>& words,
                const std::string& help) {
    std::vector<std::string> names;
    for (const auto& [word, meaning] : words) names.push_back(word);
    return add_choice(
        name, [&value, words](const std::string& word) { value = words.at(word); }, names, help);
  }

  /// True if that option was typed; valid in an action.
  bool was_given(const std::string& option) const;

 protected:
  explicit Command(CLI::App* app) : app_(app) {}
  CLI::App* app() const { return app_; }

 private:
  Option add_choice(const std::string& name, const std::function<void(const std::string&)>& set,
                    const std::vector<std::string>& words, const std::string& help);

  CLI::App* app_;
};

/// The command line of a program. Knows --help and --version by itself and, if it has commands,
/// `help` and `help COMMAND`.
class CommandLine : public Command {
 public:
  CommandLine(const std::string& program, const std::string& description);
  ~CommandLine();
  CommandLine(const CommandLine&) = delete;
  CommandLine& operator=(const CommandLine&) = delete;

  /// Parses the words and runs the action of the named command. Returns an exit code if the program
  /// is to end: 0 after a help text, that of an ExitCode, or kExitUsage after a mistake and one
  /// line "program: what".
  std::optional<int> read(int argc, char** argv);

 private:
  explicit CommandLine(std::unique_ptr<CLI::App> owned);

  std::unique_ptr<CLI::App> owned_;
};

}  // namespace haptic
