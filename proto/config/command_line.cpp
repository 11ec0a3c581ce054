// SPDX-License-Identifier: Apache-2.0
#include "proto/config/command_line.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cctype>
#include <iostream>
#include <limits>
#include <type_traits>
#include <utility>

#include "proto/os/help_text.h"
#include "proto/os/message.h"
#include "proto/os/text.h"
#include "proto/os/version.h"

namespace haptic {
namespace {

constexpr const char* kExitCodes =
    "\n\nExit codes: 0 fine; 1 something failed or a goal was missed; 2 the command line, the "
    "session "
    "file or a file that one of them names is wrong.";

/// The command in which the words ended.
const CLI::App& last_command(const CLI::App& app) {
  const std::vector<CLI::App*> named = app.get_subcommands();
  return named.empty() ? app : last_command(*named.front());
}

/// "hapt bench jitter".
std::string full_name(const CLI::App& app) {
  const CLI::App* parent = app.get_parent();
  return (parent == nullptr ? "" : full_name(*parent) + " ") + app.get_name();
}

/// The text behind an option's help: its default, and what it goes with.
std::string conditions(const CLI::Option& option) {
  const auto names = [](const std::set<CLI::Option*>& others) {
    return joined(others, [](const CLI::Option* other) { return other->get_name(); });
  };
  std::vector<std::string> parts;
  if (option.get_required() && option.nonpositional()) parts.emplace_back("required");
  if (!option.get_needs().empty()) parts.push_back("with " + names(option.get_needs()));
  if (!option.get_excludes().empty()) parts.push_back("without " + names(option.get_excludes()));
  if (!option.get_default_str().empty()) parts.push_back("default: " + option.get_default_str());
  std::string text;
  for (const std::string& part : parts) text += (text.empty() ? " (" : "; ") + part;
  return text.empty() ? "" : text + ")";
}

HelpPage::Row row_of(const CLI::Option& option) {
  const bool repeats = option.get_items_expected_max() >= CLI::detail::expected_max_vector_size;
  std::string name = option.get_name(false, true);
  if (const size_t comma = name.find(','); comma != std::string::npos) name.insert(comma + 1, " ");
  if (option.nonpositional() && option.get_type_size() != 0) name += " " + option.get_type_name();
  return {name + (repeats ? "..." : ""), option.get_description() + conditions(option)};
}

HelpPage page_of(const CLI::App& app) {
  HelpPage page{app.get_description(),
                full_name(app),
                {{"Arguments", {}}, {"Commands", {}}, {"Options", {}}},
                app.get_footer()};
  if (app.get_parent() == nullptr) page.footer += kExitCodes;
  const auto all = [](const CLI::App*) { return true; };
  for (const CLI::App* command : app.get_subcommands(all)) {
    page.groups[1].rows.push_back({command->get_name(), command->get_description()});
  }
  const bool needs_command = app.get_require_subcommand_min() > 0;
  if (!page.groups[1].rows.empty()) page.usage += needs_command ? " COMMAND" : " [COMMAND]";
  page.usage += " [OPTION...]";
  for (const CLI::Option* option : app.get_options()) {
    const bool is_argument = !option->nonpositional();
    page.groups[is_argument ? 0 : 2].rows.push_back(row_of(*option));
    const std::string& name = option->get_name();
    if (is_argument) page.usage += option->get_required() ? " " + name : " [" + name + "]";
  }
  return page;
}

bool is_option(const std::string& word) {
  return word.size() > 1 && word.front() == '-';
}

std::vector<std::string_view> option_names(const CLI::App& app) {
  std::vector<std::string_view> names;
  for (const CLI::Option* option : app.get_options()) {
    for (const std::string& name : option->get_lnames()) names.push_back(name);
  }
  return names;
}

/// The first option that a command does not know, among the words it could not use; empty: none.
std::string unknown_option(const CLI::App& app) {
  for (std::string word : app.remaining()) {
    if (!is_option(word)) continue;
    word = word.substr(0, word.find('='));
    const std::string said = "there is no option '" + shown(word) + "'";
    const std::string bare = word.substr(std::min(word.find_first_not_of('-'), word.size()));
    const std::string_view nearest = nearest_word(bare, option_names(app));
    return nearest.empty() ? said : said + "; did you mean '--" + std::string(nearest) + "'?";
  }
  return "";
}

std::string unknown_command(const CLI::App& app, const std::string& word) {
  std::vector<std::string_view> names;
  const auto all = [](const CLI::App*) { return true; };
  for (const CLI::App* command : app.get_subcommands(all)) names.push_back(command->get_name());
  const std::string_view nearest = nearest_word(word, names);
  const std::string said = "there is no command '" + shown(word) + "'";
  return nearest.empty() ? said : said + "; did you mean '" + std::string(nearest) + "'?";
}

/// The mistake as a sentence. A word that is not known comes first: what CLI11 found wrong is often
/// its consequence, as the value of an unknown option is taken for an argument.
std::string sentence(const CLI::App& app, const CLI::ParseError& error) {
  const CLI::App& command = last_command(app);
  for (const CLI::App* at = &command; at != nullptr; at = at->get_parent()) {
    if (std::string unknown = unknown_option(*at); !unknown.empty()) return unknown;
  }
  const std::vector<std::string> strays = command.remaining();
  const auto all = [](const CLI::App*) { return true; };
  if (!strays.empty() && !command.get_subcommands(all).empty()) {
    return unknown_command(command, strays.front());
  }
  if (command.get_require_subcommand_min() > 0) return "a command is missing";
  const std::string what = error.what();
  if (dynamic_cast<const CLI::ExtrasError*>(&error) != nullptr && !strays.empty()) {
    return "'" + shown(strays.front()) + "' is one word too many";
  }
  if (dynamic_cast<const CLI::RequiredError*>(&error) != nullptr) {
    return what.substr(0, what.find(' ')) + " is missing";
  }
  if (dynamic_cast<const CLI::ArgumentMismatch*>(&error) != nullptr) {
    return what.substr(0, what.find(':')) + " needs a value";
  }
  if (dynamic_cast<const CLI::ExcludesError*>(&error) != nullptr) return what + "; leave one out";
  if (dynamic_cast<const CLI::RequiresError*>(&error) != nullptr) return what + "; add it";
  return what;
}

/// The mistake in one line.
void print_mistake(const CLI::App& app, const std::string& what) {
  const std::string where = "see " + full_name(last_command(app)) + " --help";
  const std::string end = what.ends_with('?') ? "" : "; " + where;
  std::cerr << one_line(app.get_name() + ": " + what + end) << '\n';
}

/// `help COMMAND` means `COMMAND --help`. In the order that CLI11 wants: the last word first.
std::vector<std::string> reversed_words(const CLI::App& app, int argc, char** argv) {
  std::vector<std::string> words(argv + std::min(argc, 1), argv + argc);
  if (app.get_require_subcommand_min() > 0 && !words.empty() && words.front() == "help") {
    words.erase(words.begin());
    words.emplace_back("--help");
  }
  std::reverse(words.begin(), words.end());
  return words;
}

/// Problem of a whole number; empty: none.
template <typename Integer>
std::string problem_of_integer(const std::string& text, Integer low, Integer high) {
  const std::optional<Integer> value = number_from<Integer>(text);
  if (value && *value >= low && *value <= high) return "";
  using Limits = std::numeric_limits<Integer>;
  const std::string bounds = low == Limits::min() && high == Limits::max()
                                 ? (low < 0 ? "" : ", 0 or more")
                                 : " from " + std::to_string(low) + " to " + std::to_string(high);
  return "is '" + shown(text) + "'; write a whole number" + bounds;
}

template <typename Integer>
Option::Check integer_check() {
  using Limits = std::numeric_limits<Integer>;
  return [](const std::string& text) {
    return problem_of_integer<Integer>(text, Limits::min(), Limits::max());
  };
}

/// The type that one word of an option becomes.
template <typename T>
struct ItemOf {
  using type = T;
};
template <typename T>
struct ItemOf<std::optional<T>> : ItemOf<T> {};
template <typename T>
struct ItemOf<std::vector<T>> : ItemOf<T> {};

/// "-o,--output FILE" in its two parts.
struct NameParts {
  std::string name, placeholder;
};

NameParts split_name(const std::string& name, const std::string& usual = "NAME") {
  const size_t space = name.find(' ');
  if (space == std::string::npos) return {name, usual};
  return {name.substr(0, space), name.substr(space + 1)};
}

}  // namespace

int report_failure(const std::string& program, const std::exception& error) {
  std::cerr << one_line(program + ": " + error.what()) << '\n';
  return dynamic_cast<const InputError*>(&error) != nullptr ? kExitUsage : kExitFailed;
}

Option& Option::required() {
  option_->required();
  return *this;
}

Option& Option::expected(int words) {
  option_->expected(words);
  return *this;
}

Option& Option::range(int64_t low, int64_t high) {
  return check([=](const std::string& text) { return problem_of_integer(text, low, high); });
}

Option& Option::one_of(const std::vector<std::string>& words) {
  return check([words](const std::string& text) -> std::string {
    if (std::find(words.begin(), words.end(), text) != words.end()) return "";
    return "is '" + shown(text) + "'; " + suggestion(text, {words.begin(), words.end()});
  });
}

Option& Option::check(const Check& check) {
  option_->check(check, "");
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
  CLI::App* command = app_->add_subcommand(name, help);
  command->footer("");  // it begins with that of its parent
  return Command(command);
}

bool Command::has_subcommand(const std::string& name) const {
  const auto is_named = [&](const CLI::App* command) { return command->check_name(name); };
  return !std::as_const(*app_).get_subcommands(is_named).empty();
}

void Command::require_subcommand() {
  app_->require_subcommand(1);
}

void Command::footer(const std::string& text) {
  const std::string before = app_->get_footer();
  app_->footer(before + (before.empty() ? "" : "\n\n") + text);
}

void Command::example(const std::string& line) {
  footer("Example:\n  " + line);
}

void Command::exclude_subcommands() {
  for (CLI::App* command : app_->get_subcommands([](const CLI::App*) { return true; })) {
    for (CLI::Option* option : app_->get_options()) command->excludes(option);
  }
}

void Command::action(const std::function<void()>& action) {
  app_->callback([app = app_, action] {
    if (app->get_subcommands().empty()) action();
  });
}

Option Command::flag(const std::string& name, bool& value, const std::string& help) {
  return Option(app_->add_flag(name, value, help));
}

bool Command::was_given(const std::string& option) const {
  return app_->count(option) > 0;
}

Option Command::add_choice(const std::string& name,
                           const std::function<void(const std::string&)>& set,
                           const std::vector<std::string>& words, const std::string& help) {
  const NameParts parts = split_name(name);
  CLI::Option* option =
      app_->add_option_function<std::string>(parts.name, set, help + ": " + joined(words));
  return Option(option->type_name(parts.placeholder)).one_of(words);
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

/// Adds an option of a number, of one that may be left out, or of a list of them.
template <typename Value>
CLI::Option* add_value(CLI::App* app, const NameParts& name, Value& value, const Parse& parse,
                       const std::string& help, const std::function<std::string(double)>& text_of) {
  constexpr bool kIsList = std::is_same_v<Value, std::vector<double>>;
  using Texts = std::conditional_t<kIsList, std::vector<std::string>, std::string>;
  const auto set = [&value, parse](const Texts& texts) {
    if constexpr (kIsList) {
      value.clear();
      for (const std::string& text : texts) value.push_back(parse(text));
    } else {
      value = parse(texts);
    }
  };
  CLI::Option* option = app->add_option_function<Texts>(name.name, set, help);
  option->check(problem_of(parse), "")->type_name(name.placeholder);
  return option->default_function([&value, text_of]() -> std::string {
    if constexpr (kIsList) return joined(value, text_of);
    if constexpr (std::is_same_v<Value, double>) return text_of(value);
    return "";
  });
}

/// Placeholder in the help text: "LENGTH".
std::string kind_of(Dimension dimension) {
  std::string kind(name_of(dimension));
  for (char& c : kind) c = static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
  return kind;
}

}  // namespace

template <typename Value>
Option Command::quantity(const std::string& name, Value& value, Dimension dimension,
                         const Range& range, const std::string& help,
                         const std::string& bare_unit) {
  const auto parse = [=](const std::string& text) {
    return parse_quantity(text, dimension, range, bare_unit);
  };
  return Option(add_value(app_, split_name(name, kind_of(dimension)), value, parse, help,
                          [=](double one) { return quantity_text(one, dimension); }));
}

template <typename Value>
Option Command::number(const std::string& name, Value& value, const Range& range,
                       const std::string& help) {
  const auto parse = [=](const std::string& text) { return parse_number(text, range); };
  return Option(add_value(app_, split_name(name, "NUMBER"), value, parse, help, number_text));
}

template Option Command::quantity(const std::string&, double&, Dimension, const Range&,
                                  const std::string&, const std::string&);
template Option Command::quantity(const std::string&, std::optional<double>&, Dimension,
                                  const Range&, const std::string&, const std::string&);
template Option Command::quantity(const std::string&, std::vector<double>&, Dimension, const Range&,
                                  const std::string&, const std::string&);
template Option Command::number(const std::string&, double&, const Range&, const std::string&);
template Option Command::number(const std::string&, std::optional<double>&, const Range&,
                                const std::string&);
template Option Command::number(const std::string&, std::vector<double>&, const Range&,
                                const std::string&);

CommandLine::CommandLine(const std::string& program, const std::string& description)
    : CommandLine(std::make_unique<CLI::App>(description, program)) {
  owned_->set_help_flag("-h,--help", "this text");
  owned_->set_version_flag("-V,--version", program + " " + version(), "release and commit");
}

CommandLine::CommandLine(std::unique_ptr<CLI::App> owned)
    : Command(owned.get()), owned_(std::move(owned)) {}

CommandLine::~CommandLine() = default;

std::optional<int> CommandLine::read(int argc, char** argv) {
  try {
    std::vector<std::string> words = reversed_words(*owned_, argc, argv);
    owned_->parse(words);
    return std::nullopt;
  } catch (const ExitCode& end) {
    return end.code;
  } catch (const CLI::CallForHelp& asked) {
    const CLI::App& command = last_command(*owned_);
    if (command.get_require_subcommand_min() == 0 || command.remaining().empty()) {
      std::cout << help_text(page_of(command));
      return 0;
    }
    print_mistake(*owned_, sentence(*owned_, asked));
  } catch (const CLI::CallForVersion& asked) {
    std::cout << asked.what() << '\n';
    return 0;
  } catch (const CLI::ParseError& error) {
    print_mistake(*owned_, sentence(*owned_, error));
  } catch (const UsageError& error) {
    print_mistake(*owned_, error.what());
  }
  return kExitUsage;
}

template <typename T>
Option Command::option(const std::string& name, T& value, const std::string& help) {
  using Item = typename ItemOf<T>::type;
  constexpr bool kIsWhole = std::is_integral_v<Item>;
  const NameParts parts = split_name(name, kIsWhole ? "N" : "NAME");
  Option option(app_->add_option(parts.name, value, help)->type_name(parts.placeholder));
  if constexpr (kIsWhole) option.check(integer_check<Item>());
  return option;
}

template Option Command::option(const std::string&, int&, const std::string&);
template Option Command::option(const std::string&, std::string&, const std::string&);
template Option Command::option(const std::string&, uint32_t&, const std::string&);
template Option Command::option(const std::string&, uint64_t&, const std::string&);
template Option Command::option(const std::string&, std::optional<uint64_t>&, const std::string&);
template Option Command::option(const std::string&, std::vector<std::string>&, const std::string&);
template Option Command::option(const std::string&, std::vector<uint32_t>&, const std::string&);

}  // namespace haptic
