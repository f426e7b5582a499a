#pragma once

#include <algorithm>
#include <cmath>
#include <concepts>
#include <cstdint>
#include <exception>
#include <filesystem>
#include <iostream>
#include <iterator>
#include <memory>
#include <new>
#include <set>
#include <sstream>
#include <stdexcept>
#include <string>
#include <system_error>
#include <vector>

#include <CLI/CLI.hpp>

#include <semiexplicit/scene/nearest_names.hpp>

#include "output.hpp"
#include "units.hpp"

namespace examples {

using namespace semiexplicit;

/// How many steps of dt at most go into `time`; more than a multiple takes one more, and not because of
/// rounding.
inline std::int64_t steps_in(double time, double dt) {
  if (dt > time)
    throw std::invalid_argument(
        "--dt is larger than --time, be it given or the program's own; give a longer time, or a smaller "
        "step");
  const double count = time / dt, whole = std::round(count);
  if (!(count <= 1e15)) throw std::invalid_argument("--time / --dt is more steps than anybody can wait for");
  return static_cast<std::int64_t>(std::abs(count - whole) <= 1e-9 * count ? whole : std::ceil(count));
}

/// What is wrong with a name that leads round in a circle, which std::filesystem throws for; else nothing.
inline std::string complaint_of_link(const std::filesystem::path& name) {
  std::error_code failure;
  [[maybe_unused]] const auto there = std::filesystem::status(name, failure);
  return failure == std::errc::too_many_symbolic_link_levels
             ? name.string() + ": the link leads nowhere; mend it"
             : "";
}

/// Makes a folder that an option asks for. Throws std::invalid_argument where that fails.
inline void make_folder(const std::filesystem::path& folder, const std::string& option) {
  if (const std::string complaint = complaint_of_link(folder); !complaint.empty())
    throw std::invalid_argument(option + ": " + complaint);
  std::error_code failure, none;
  std::filesystem::create_directories(folder, failure);
  if (failure || !std::filesystem::is_directory(folder, none))
    throw std::invalid_argument(option + ": the folder '" + folder.string() + "' cannot be made" +
                                (failure ? ": " + failure.message() : "; something else has that name"));
}

/// What every program lets its user choose about a run, beside the method.
struct Settings {
  double dt = 0.01;
  double time = 100;
  std::int64_t samples = 2000;
  std::filesystem::path output = "out";
  std::vector<std::filesystem::path> inputs{};  ///< files that the user gave
  bool no_plot = false;

  /// Takes dt so much smaller that whole steps end at `time`, and gives their number.
  std::int64_t fit_steps() {
    const std::int64_t count = steps_in(time, dt);
    dt = time / static_cast<double>(count);
    return count;
  }

  void make_output_folder() const { make_folder(output, "--output"); }
};

/// Accepts numbers that holds(), which a NaN has to fail.
template <class Number, class Holds>
CLI::Validator number(const std::string& words, const Holds& holds) {
  return {[=](std::string& text) {
            if constexpr (std::integral<Number>) {  // CLI11 takes 010 for octal and 0x10 for hexadecimal
              const std::size_t digits = std::min(text.find_first_not_of("+-"), text.size());
              if (digits + 1 < text.size() && text[digits] == '0')
                return "'" + text + "' begins with 0; leave that out";
            }
            Number value{};
            const bool fine = CLI::detail::lexical_cast(text, value) && holds(value);
            return fine ? std::string() : "'" + text + "' is not " + words;
          },
          "", words};
}
inline CLI::Validator positive() {
  return number<double>("a positive number", [](double x) { return x > 0 && std::isfinite(x); });
}
inline CLI::Validator whole_number(std::int64_t least, std::int64_t most) {
  return number<std::int64_t>("a whole number from " + std::to_string(least) + " to " + std::to_string(most),
                              [=](std::int64_t n) { return least <= n && n <= most; });
}

/// Accepts one of `words`; otherwise names the nearest and all of them.
inline CLI::Validator one_of(const std::vector<std::string>& words) {
  return {[=](std::string& text) {
            if (std::find(words.begin(), words.end(), text) != words.end()) return std::string();
            return "there is no '" + text + "'; did you mean " + nearest_names(text, words, 1).front() +
                   "? Known: " + joined(words);
          },
          "", "known name"};
}

/// An option whose help shows the value that is there.
template <class T>
CLI::Option* add_value(CLI::App& app, const std::string& name, T& value, const std::string& about,
                       const CLI::Validator& check, const std::string& type = "X") {
  return app.add_option(name, value, about)->check(check)->type_name(type)->capture_default_str();
}

/// What becomes of the results; without rows, of which there is a choice in some programs only.
inline void add_output(CLI::App& app, Settings& settings, bool rows = true) {
  if (rows)
    add_value(app, "--samples", settings.samples, "rows of the CSV file at most",
              whole_number(1, 1'000'000'000), "N");
  // gnuplot takes <name for a command, ~ for the home folder, and $name for data of its own.
  const auto plain = [](std::string folder) {
    return folder.find_first_of("<~$") == 0 ? "./" + folder : folder;
  };
  add_value(app, "--output", settings.output, "folder for the data and the picture", CLI::Validator(), "DIR")
      ->transform(plain);
  app.add_flag("--no-plot", settings.no_plot, "leave the picture out");
  app.parse_complete_callback([&app, &settings] {
    for (const CLI::Option* file : {app.get_config_ptr(), app.get_option_no_throw("--input")})
      if (file != nullptr && file->count() > 0) settings.inputs.push_back(file->as<std::string>());
  });
}

/// Whether the user gave an option; not, where the program has none of that name.
inline bool is_given(const CLI::App& app, const std::string& option) {
  const CLI::Option* const known = app.get_option_no_throw(option);
  return known != nullptr && known->count() > 0;
}

/// Options that do not go with another one are a misunderstanding, and refused.
inline void refuse_options(const CLI::App& app, const std::string& with,
                           const std::vector<std::string>& idle) {
  for (const std::string& option : idle)
    if (app.count(option) > 0)
      throw std::invalid_argument(option + " means nothing to " + with + "; leave it out");
}

inline std::vector<std::string> option_names(const CLI::App& app) {
  std::vector<std::string> names;
  for (const CLI::Option* known : app.get_options()) names.push_back(known->get_single_name());
  return names;
}

/// CLI11's reader of files in TOML or INI; an unknown name is refused with the nearest ones, and so is what
/// CLI11 would read as something else or skip.
class ConfigFile : public CLI::ConfigTOML {
 public:
  explicit ConfigFile(const CLI::App& app) : app_(app) {}

  std::vector<CLI::ConfigItem> from_config(std::istream& in) const override {
    if (in.peek() == 0xEF) in.ignore(3);  // the mark that some editors put before UTF-8
    const std::string text{std::istreambuf_iterator<char>(in), {}};
    check_lines(text);
    std::istringstream lines(text);
    std::vector<CLI::ConfigItem> read = CLI::ConfigTOML::from_config(lines);
    for (const auto& [parents, name, values] : read)
      if (!parents.empty())
        refuse("[" + parents.front() + "]: sections mean nothing here");
      else if (app_.get_option_no_throw("--" + name) == nullptr)
        refuse(unknown_name("option", name, option_names(app_)));
      else if (std::count(values.begin(), values.end(), "") > 0)
        refuse("'" + name + "' has no value");
      else if (values.size() > 1 && app_.get_option("--" + name)->get_items_expected_max() == 1)
        refuse("'" + name + "' has more than one value; one with a blank needs quotes, as time = \"1 day\"");
    std::erase_if(read, [this](const CLI::ConfigItem& item) { return is_flag_left_out(item); });
    return read;
  }

 private:
  /// Every line is to be empty, a comment, a [section] or name = value, with all quotes and brackets closed,
  /// and no name there twice: CLI11 would take two lines one behind the other for one list.
  static void check_lines(const std::string& text) {
    std::istringstream lines(text);
    std::string name;
    std::set<std::string> names;
    bool in_array = false;
    for (std::string line; std::getline(lines, line);) {
      const std::size_t begin = line.find_first_not_of(" \t\r");
      if (begin == std::string::npos || line[begin] == '#' || line[begin] == ';') continue;
      std::size_t at = begin;
      if (!in_array) {
        if (line[begin] == '[') continue;
        at = line.find('=');
        name = CLI::detail::trim_copy(line.substr(begin, at == std::string::npos ? at : at - begin));
        if (at++ == std::string::npos) refuse("'" + name + "' has no value; write name = value");
        if (name.empty()) refuse("a line begins with =; write name = value");
        if (!names.insert(name).second) refuse("'" + name + "' is there twice");
      }
      char quote = 0;
      for (; at < line.size() && (quote != 0 || line[at] != '#'); ++at) {
        const char c = line[at];
        if (quote != 0 && c == '#')
          refuse("'" + name + "' has a # within quotes, which would begin a comment; give it as an argument");
        if (quote != 0 ? c == quote : c == '"' || c == '\'')
          quote = quote == 0 ? c : '\0';
        else if (quote == 0 && in_array && c == '=')
          refuse("'" + name + "' has a [ without its ]");
        else if (quote == 0 && (c == '[' || c == ']'))
          in_array = c == '[';
      }
      if (quote != 0) refuse("'" + name + "' has a quote that is not closed");
      if (in_array && line.find_last_of('[') == line.substr(0, at).find_last_not_of(" \t\r"))
        refuse("'" + name + "' has nothing behind its [; write the first entry on the same line");
    }
    if (in_array) refuse("'" + name + "' has a [ without its ]");
  }
  /// CLI11 counts `name = false`, off, no or 0 as given: what the flag excludes would be refused.
  bool is_flag_left_out(const CLI::ConfigItem& item) const {
    if (app_.get_option("--" + item.name)->get_expected_max() != 0 || item.inputs.size() != 1) return false;
    try {
      return CLI::detail::to_flag_value(item.inputs.front()) < 0;
    } catch (const std::logic_error&) {  // no such word, or no number; CLI11 says so
      return false;
    }
  }
  [[noreturn]] static void refuse(const std::string& why) {
    throw CLI::ConfigError(why, CLI::ExitCodes::ConfigError);
  }

  const CLI::App& app_;
};

/// Adds --config, a file of such options: a regular one of at most 100 kB, for others may have no end.
inline void add_config(CLI::App& app) {
  const auto short_file = [](const std::string& text) -> std::string {
    if (text.empty()) return "'' is no file";
    std::error_code failure;
    const std::filesystem::file_status there = std::filesystem::status(text, failure);
    if (!std::filesystem::exists(there)) return "";  // which is refused elsewhere
    if (!std::filesystem::is_regular_file(there)) return "'" + text + "' is not a regular file";
    return std::filesystem::file_size(text, failure) > 100'000 ? "'" + text + "' is longer than 100 kB" : "";
  };
  app.set_config("--config", "", "file of such options in TOML, as name = value lines")
      ->check(CLI::Validator(short_file, "", "short file"))
      ->type_name("FILE");
  app.allow_config_extras(false);
  app.config_formatter(std::make_shared<ConfigFile>(app));
}

/// What to say of arguments that belong to no option: the nearest one, or that the shell has taken a number
/// and its unit apart.
inline std::string about_extras(const CLI::App& app, const std::vector<std::string>& extras) {
  for (const std::string& extra : extras) {
    if (!extra.starts_with("-")) continue;
    const std::string name = extra.substr(0, extra.find('='));
    const std::string known = name.substr(std::min(name.find_first_not_of('-'), name.size()));
    return "there is no option " + name + "; did you mean --" +
           nearest_names(known, option_names(app), 1).front() + "?";
  }
  try {
    read_unit(extras.front());
    return "'" + extras.front() + "' stands alone; a number and its unit need quotes, as \"5 " +
           extras.front() + "\"";
  } catch (const std::invalid_argument&) {
    return "'" + extras.front() + "' belongs to no option";
  }
}

/// What to say of a failure.
inline std::string reason(const std::exception& error) {
  if (dynamic_cast<const std::bad_alloc*>(&error) != nullptr)
    return "there is not memory enough for so much; ask for less";
  return error.what();
}

/// Parses the arguments and runs `body`, which gives the exit code. Bad arguments (std::invalid_argument,
/// too) end in one line and exit code 2, other failures, a full standard output too, in one line and exit
/// code 1.
template <class Body>
int run_program(CLI::App& app, int argc, char** argv, const Body& body) {
  const std::string name = std::filesystem::path(argv[0]).filename().string();
  const std::string hint = " (see " + name + " --help)";
  const auto complain = [&](const std::string& what, int code) {
    std::cerr << name << ": " << what << '\n';
    return code;
  };
  const auto parse_and_run = [&] {
    try {
      app.parse(argc, argv);
    } catch (const CLI::Success& help) {
      return app.exit(help);
    }
    return body();
  };
  try {
    const int code = parse_and_run();
    std::cout.flush();
    if (std::cout.bad()) return complain("the standard output could not be written, its text is lost", 1);
    return code;
  } catch (const CLI::ConfigError& error) {
    return complain("--config: " + std::string(error.what()), 2);
  } catch (const CLI::ExtrasError& error) {
    const std::vector<std::string> extras = app.remaining();
    return complain((extras.empty() ? error.what() : about_extras(app, extras)) + hint, 2);
  } catch (const CLI::ParseError& error) {
    return complain(error.what() + hint, 2);
  } catch (const std::invalid_argument& error) {
    return complain(error.what(), 2);
  } catch (const std::exception& error) {
    return complain(reason(error), 1);
  }
}

}  // namespace examples
