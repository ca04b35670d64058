// SPDX-License-Identifier: Apache-2.0
#include "call_texts.hpp"

#include <algorithm>
#include <utility>
#include <vector>

#include "base/nearest_text.hpp"
#include "console.hpp"

namespace gnosphere::cli {
namespace {

class HelpFormatter : public CLI::Formatter {
 public:
  HelpFormatter() {
    column_width(kNames);
    // CLI11 from 2.5 on would wrap the wrapped lines again.
    [](auto& self) {
      if constexpr (requires { self.enable_footer_formatting(false); }) {
        self.enable_footer_formatting(false);
        self.enable_description_formatting(false);
      }
    }(*this);
  }
  /// The versions of CLI11 differ in the number of empty lines between the parts of the help.
  std::string make_help(const CLI::App* app, std::string name, CLI::AppFormatMode mode) const override {
    std::string text = Formatter::make_help(app, std::move(name), mode);
    for (size_t at; (at = text.find("\n\n\n")) != text.npos;) text.erase(at, 1);
    return text;
  }
  std::string make_option(const CLI::Option* option, bool positional) const override {
    std::string name = "  " + make_option_name(option, positional) + make_option_opts(option);
    name.resize(name.find_last_not_of(' ') + 1);
    const std::string description = option->get_description();
    if (description.empty()) return name + "\n";
    if (name.size() < kNames)
      name.resize(kNames, ' ');
    else
      name += "\n" + std::string(kNames, ' ');
    return name + wrapped(description, columns_, kNames) + "\n";
  }
  std::string make_subcommand(const CLI::App* command) const override {
    size_t width = 0;
    for (const CLI::App* other : command->get_parent()->get_subcommands(nullptr))
      width = std::max(width, 2 + other->get_name().size() + 4);
    std::string name = "  " + command->get_name();
    name.resize(width, ' ');
    return name + wrapped(command->get_description(), columns_, width) + "\n";
  }
  /// The example is a command to copy, so it stays one line.
  std::string make_footer(const CLI::App* app) const override {
    const std::string footer = app->get_footer();
    const size_t example = std::min(footer.find("Example: "), footer.size());
    return wrapped(footer.substr(0, example), columns_) + footer.substr(example) + "\n";
  }

 private:
  static constexpr size_t kNames = 26;  ///< columns of the names of options
  size_t columns_ = textColumns();
};

/// Says which word of a call is none of the command's, or that there is no such command.
std::string unknownWord(const CLI::App& app, const std::vector<CLI::App*>& chosen, const char* subcommand) {
  std::vector<std::string> words = app.remaining(true);  // behind --, those of a command are the program's
  std::erase(words, "--");
  const auto dashed = [](const std::string& word) {  // as options are, but not numbers below 0
    return word.size() > 1 && word[0] == '-' && word.find_first_of("0123456789") != 1;
  };
  const auto found = std::find_if(words.begin(), words.end(), dashed);
  const std::string word = found != words.end() ? *found : words.at(0);
  std::vector<std::string> names;
  if (dashed(word)) {
    for (const CLI::Option* option : (chosen.empty() ? &app : chosen[0])->get_options())
      if (!option->get_lnames().empty()) names.push_back("--" + option->get_lnames()[0]);
    return "there is no option '" + word + "'; " + nearestText(word, std::move(names));
  }
  if (!chosen.empty()) {
    const auto hasValue = [](const CLI::Option* option) {
      return option->nonpositional() && option->count() > 0 && option->get_expected_max() > 0;
    };
    return "there is no place for '" + word + "'" +
           (std::ranges::any_of(chosen[0]->get_options(), hasValue) ? "; commas join the values of one option, as 1,2,3"
                                                                    : "");
  }
  for (const CLI::App* command : app.get_subcommands(nullptr)) names.push_back(command->get_name());
  return "there is no " + std::string(subcommand) + " '" + word + "'; " + nearestText(word, std::move(names));
}

/// Says which option has a text in place of a number.
std::string noNumber(const CLI::ConversionError& error, const std::vector<CLI::App*>& chosen) {
  for (const CLI::App* command : chosen)
    for (const CLI::Option* option : command->get_options()) {
      const std::string name = option->get_name(), type = option->get_type_name();
      if (option->results().empty() ||
          error.what() != std::string(CLI::ConversionError(name, option->results()).what()))
        continue;
      const char* const wanted = type.starts_with("FLOAT")                             ? "a number"
                                 : type.starts_with("INT") || type.starts_with("UINT") ? "a whole number"
                                                                                       : "a value of its kind";
      return name + " must be " + wanted + ", is '" + option->results().back() + "'";
    }
  return error.what();
}

}  // namespace

std::shared_ptr<CLI::FormatterBase> helpFormatter() {
  return std::make_shared<HelpFormatter>();
}

std::string wrongCall(const CLI::App& app, const CLI::ParseError& error, const char* subcommand) {
  const std::vector<CLI::App*> chosen = app.get_subcommands();
  std::string problem = error.what();
  if (dynamic_cast<const CLI::ExtrasError*>(&error)) problem = unknownWord(app, chosen, subcommand);
  if (const auto* unconverted = dynamic_cast<const CLI::ConversionError*>(&error))
    problem = noNumber(*unconverted, chosen);
  return problem + " (see " + app.get_name() + " " + (chosen.empty() ? "" : chosen[0]->get_name() + " ") + "--help)";
}

}  // namespace gnosphere::cli
