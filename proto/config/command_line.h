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

/// A front to CLI11, whose header takes seconds to compile: command_line.cpp alone includes it.
namespace haptic {

/// Thrown by an action where the exit code is all there is to say.
struct ExitCode {
  int code;
};

/// Thrown by an action that finds that what was typed is wrong.
struct UsageError : MessageError {
  using MessageError::MessageError;
};

/// What may be typed for one option; a handle. Other options are named as they are typed.
class Option {
 public:
  /// What is wrong with a word, in one line; empty: nothing.
  using Check = std::function<std::string(const std::string&)>;

  explicit Option(CLI::Option* option) : option_(option) {}
  Option& required();
  /// How many words follow it.
  Option& expected(int words);
  Option& range(int low, int high);
  Option& range(uint64_t low, uint64_t high);
  Option& one_of(const std::vector<std::string>& words);
  /// The kind is what the help text calls such a word.
  Option& check(const Check& check, const std::string& kind = "");
  /// The help text shows the value that the variable has now.
  Option& show_default();
  /// The help text shows this as the default.
  Option& show_default(const std::string& text);
  Option& needs(const std::string& option);
  Option& excludes(const std::string& option);

 private:
  CLI::Option* option_;
};

/// A command with its options and commands below it; a handle.
class Command {
 public:
  Command subcommand(const std::string& name, const std::string& help);
  bool has_subcommand(const std::string& name) const;
  /// Exactly one of the commands below it must be named.
  void require_subcommand();
  /// Below the help text.
  void footer(const std::string& text);
  /// What runs once all words are read. What it throws, whoever reads the words gets.
  void action(const std::function<void()>& action);

  /// The variable must outlive the reading. A name with neither "-" nor "--" is a word by its
  /// place. T: one of the types at the end of command_line.cpp.
  template <typename T>
  Option option(const std::string& name, T& value, const std::string& help);
  Option flag(const std::string& name, bool& value, const std::string& help);

  /// A quantity, as "80 mm"; a bare number is meant in `bare_unit`, of which the help text is to
  /// speak. `value` is in SI units. What is wrong is told as parse_quantity() does.
  Option quantity(const std::string& name, double& value, Dimension dimension, const Range& range,
                  const std::string& help, const std::string& bare_unit = "");
  /// Several of a kind.
  Option quantities(const std::string& name, std::vector<double>& values, Dimension dimension,
                    const Range& range, const std::string& help, const std::string& bare_unit = "");
  /// A number without unit; several.
  Option number(const std::string& name, double& value, const Range& range,
                const std::string& help);
  Option numbers(const std::string& name, std::vector<double>& values, const Range& range,
                 const std::string& help);

  /// One of several words, each of which stands for a value.
  template <typename Enum>
  Option choice(const std::string& name, Enum& value, const std::map<std::string, Enum>& words,
                const std::string& help) {
    std::map<std::string, int> numbers;
    for (const auto& [word, meaning] : words) numbers[word] = static_cast<int>(meaning);
    return add_choice(
        name, [&value](int n) { value = static_cast<Enum>(n); }, numbers, help);
  }

  /// Whether that option was typed; to be asked in an action.
  bool was_given(const std::string& option) const;

 protected:
  explicit Command(CLI::App* app) : app_(app) {}
  CLI::App* app() const { return app_; }

 private:
  Option add_choice(const std::string& name, const std::function<void(int)>& set,
                    const std::map<std::string, int>& words, const std::string& help);

  CLI::App* app_;
};

/// All that may be typed after the name of a program.
class CommandLine : public Command {
 public:
  explicit CommandLine(const std::string& description);
  ~CommandLine();
  CommandLine(const CommandLine&) = delete;
  CommandLine& operator=(const CommandLine&) = delete;

  /// `--version` prints it.
  void version(const std::string& text);

  /// Reads the words and runs the action of the command that they name. Returns the exit code where
  /// the program is to end: 0 after a help text, that of an ExitCode, and `usage_code` where
  /// something was typed wrongly, after one line "program: what; see program --help".
  std::optional<int> read(int argc, char** argv, const std::string& program, int usage_code);

 private:
  explicit CommandLine(std::unique_ptr<CLI::App> owned);

  std::unique_ptr<CLI::App> owned_;
};

}  // namespace haptic
