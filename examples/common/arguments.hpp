#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <exception>
#include <filesystem>
#include <iostream>
#include <memory>
#include <stdexcept>
#include <string>
#include <system_error>
#include <vector>

#include <CLI/CLI.hpp>

#include <semiexplicit/scene/nearest_names.hpp>

#include "config_file.hpp"
#include "method.hpp"
#include "units.hpp"

namespace examples {

/// How many steps of dt at most go into `time`; more than a multiple takes one more, and not because of rounding.
inline std::int64_t steps_in(double time, double dt) {
  if (dt > time)
    throw std::invalid_argument("--dt is larger than --time; give a smaller step or a longer time");
  const double count = time / dt, whole = std::round(count);
  if (!(count <= 1e15)) throw std::invalid_argument("--time / --dt is more steps than anybody can wait for");
  return static_cast<std::int64_t>(std::abs(count - whole) <= 1e-9 * count ? whole : std::ceil(count));
}

/// What every program lets its user choose about a run, beside the method.
struct Settings {
  double dt = 0.01;
  double time = 100;
  std::int64_t samples = 2000;
  std::filesystem::path output = "out";
  bool no_plot = false;

  /// Takes dt so much smaller that whole steps end at `time`, and gives their number.
  std::int64_t fit_steps() {
    const std::int64_t count = steps_in(time, dt);
    dt = time / static_cast<double>(count);
    return count;
  }

  void make_output_folder() const {
    std::error_code failure;
    std::filesystem::create_directories(output, failure);
    if (failure || !std::filesystem::is_directory(output))
      throw std::invalid_argument("--output: the folder " + output.string() + " cannot be made" +
                                  (failure ? ": " + failure.message() : "; something else has that name"));
  }
};

/// Accepts finite numbers above zero; a NaN fails every comparison and so this one.
inline CLI::Validator positive() {
  return {[](std::string& text) {
            double value = 0;
            const bool fine = CLI::detail::lexical_cast(text, value) && value > 0 && std::isfinite(value);
            return fine ? std::string() : "'" + text + "' is not a positive number";
          },
          "", "positive"};
}

inline CLI::Validator finite() {
  return {[](std::string& text) {
            double value = 0;
            const bool fine = CLI::detail::lexical_cast(text, value) && std::isfinite(value);
            return fine ? std::string() : "'" + text + "' is not a finite number";
          },
          "", "finite"};
}

inline CLI::Validator whole_number(std::int64_t least, std::int64_t most) {
  const std::string range = std::to_string(least) + " to " + std::to_string(most);
  return {[=](std::string& text) {
            std::int64_t value = 0;
            const bool fine = CLI::detail::lexical_cast(text, value) && least <= value && value <= most;
            return fine ? std::string() : "'" + text + "' is not a whole number from " + range;
          },
          "", "whole number"};
}

inline std::string joined(const std::vector<std::string>& words) {
  std::string text;
  for (const std::string& word : words) text += (text.empty() ? "" : ", ") + word;
  return text;
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

/// What becomes of the results.
inline void add_output(CLI::App& app, Settings& settings) {
  const auto add = [&](const char* name, auto& value, const char* about) {
    return app.add_option(name, value, about)->capture_default_str();
  };
  add("--samples", settings.samples, "rows of the CSV file at most")
      ->check(whole_number(1, 1'000'000'000))
      ->type_name("N");
  add("--output", settings.output, "folder for the CSV files and the picture")->type_name("DIR");
  app.add_flag("--no-plot", settings.no_plot, "leave the picture out");
}

inline void add_settings(CLI::App& app, Settings& settings) {
  const auto add = [&](const char* name, auto& value, const char* about) {
    return app.add_option(name, value, about)->check(positive())->type_name("X")->capture_default_str();
  };
  add("--dt", settings.dt, "step size; made a little smaller where the time is no multiple");
  add("--time", settings.time, "time to integrate to");
  add_output(app, settings);
}

inline void add_method(CLI::App& app, Method& method,
                       const std::vector<std::string>& methods = Method::names()) {
  const auto choice = [&](const char* name, auto& value, const std::vector<std::string>& words,
                          const std::string& about) {
    app.add_option(name, value, about + ": " + joined(words))
        ->check(one_of(words))
        ->type_name("NAME")
        ->capture_default_str();
  };
  choice("--method", method.name, methods, "the integrator");
  app.add_option("--scheme", method.scheme, "its coefficients (not of gauss), by a name from the list below")
      ->check(one_of(schemes::names()))
      ->type_name("NAME")
      ->default_str("low_defect6_s13; tao: yoshida6");
  choice("--solver", method.solver, {"newton", "broyden"}, "of the semiexplicit projection");
  choice("--rule", method.rule, {"product", "paper"}, "when the solver may stop");
  app.add_option("--tolerance", method.tolerance,
                 "of that rule: drift in a step relative to the state, or size of the next correction")
      ->check(positive())
      ->type_name("X")
      ->default_str("product: 1e-16, paper: 1e-13");
  app.add_option("--omega", method.omega, "coupling of the copies in tao")
      ->check(finite())
      ->type_name("X")
      ->capture_default_str();
  app.add_option("--stages", method.stages, "of gauss, 1 to 8")
      ->check(whole_number(1, 8))
      ->type_name("N")
      ->capture_default_str();
  app.footer("Schemes: " + joined(schemes::names()) + ".");
}

/// An option that none of the methods that run listens to is a misunderstanding, and refused.
inline void refuse_idle_options(const CLI::App& app, const std::vector<std::string>& methods) {
  struct Listeners {
    const char* option;
    std::vector<std::string> methods;
  };
  const std::vector<Listeners> all{{"--scheme", {"semiexplicit", "midpoint", "pihajoki", "tao", "splitting"}},
                                   {"--solver", {"semiexplicit"}},
                                   {"--rule", {"semiexplicit"}},
                                   {"--tolerance", {"semiexplicit"}},
                                   {"--omega", {"tao"}},
                                   {"--stages", {"gauss"}}};
  for (const auto& [option, listeners] : all) {
    const bool heard = std::find_first_of(methods.begin(), methods.end(), listeners.begin(),
                                          listeners.end()) != methods.end();
    if (app.count(option) > 0 && !heard)
      throw std::invalid_argument(std::string(option) + " means nothing to " + joined(methods) +
                                  "; it is for " + joined(listeners));
  }
}

/// The same for options that do not go with another one.
inline void refuse_options(const CLI::App& app, const std::string& with,
                           const std::vector<std::string>& idle) {
  for (const std::string& option : idle)
    if (app.count(option) > 0)
      throw std::invalid_argument(option + " means nothing to " + with + "; leave it out");
}

/// Accepts no devices, pipes and folders, which have no end or cannot be read; what is not there is refused elsewhere.
inline CLI::Validator regular_file() {
  return {[](std::string& text) {
            std::error_code failure;
            const std::filesystem::file_status there = std::filesystem::status(text, failure);
            const bool other = std::filesystem::exists(there) && !std::filesystem::is_regular_file(there);
            return other ? "'" + text + "' is not a regular file" : std::string();
          },
          "", "regular file"};
}

/// Adds --config, a file of such options.
inline void add_config(CLI::App& app) {
  app.set_config("--config", "", "file of such options, as name = value lines")
      ->check(regular_file())
      ->type_name("FILE");
  app.allow_config_extras(false);
  app.config_formatter(std::make_shared<ConfigFile>(app));
}

/// Where in the configuration file the option stands that a message "--name: ..." speaks of; "" for the command line.
inline std::string place_of(const CLI::App& app, const std::string& message, int argc,
                            const char* const* argv) {
  const auto file = std::dynamic_pointer_cast<ConfigFile>(app.get_config_formatter());
  const std::string option = message.substr(0, message.find(':'));
  for (int i = 1; i < argc; ++i) {
    const std::string argument = argv[i];
    if (argument == option || argument.starts_with(option + "=")) return "";
  }
  return file ? file->where(message) : "";
}

/// What to say of arguments that belong to no option: the nearest one, or that the shell has taken a number and its unit apart.
inline std::string about_extras(const CLI::App& app, const std::vector<std::string>& extras) {
  for (const std::string& extra : extras) {
    if (!extra.starts_with("-")) continue;
    const std::string name = extra.substr(0, extra.find('='));
    std::vector<std::string> names;
    for (const CLI::Option* known : app.get_options()) names.push_back("--" + known->get_single_name());
    return "there is no option " + name + "; did you mean " + nearest_names(name, names, 1).front() + "?";
  }
  try {
    read_unit(extras.front());
    return "'" + extras.front() + "' stands alone; a number and its unit need quotes, as \"5 " +
           extras.front() + "\"";
  } catch (const std::invalid_argument&) {
    return "'" + extras.front() + "' belongs to no option";
  }
}

/// Parses the arguments and runs `body`, which gives the exit code. Bad arguments (std::invalid_argument, too) end in
/// one line and exit code 2, other failures in one line and exit code 1.
template <class Body>
int run_program(CLI::App& app, int argc, char** argv, const Body& body) {
  const std::string name = std::filesystem::path(argv[0]).filename().string();
  const auto complain = [&](const std::string& what, const char* more, int code) {
    std::cerr << name << ": " << what << more << '\n';
    return code;
  };
  const std::string hint = " (see " + name + " --help)";
  try {
    app.parse(argc, argv);
    return body();
  } catch (const CLI::Success& help) {
    return app.exit(help);
  } catch (const CLI::ConfigError& error) {
    return complain(error.what(), "", 2);
  } catch (const CLI::ExtrasError& error) {
    const std::vector<std::string> extras = app.remaining();
    return complain(extras.empty() ? error.what() : about_extras(app, extras), hint.c_str(), 2);
  } catch (const CLI::ParseError& error) {
    return complain(place_of(app, error.what(), argc, argv) + error.what(), hint.c_str(), 2);
  } catch (const std::invalid_argument& error) {
    return complain(place_of(app, error.what(), argc, argv) + error.what(), "", 2);
  } catch (const std::exception& error) {
    return complain(error.what(), "", 1);
  }
}

}  // namespace examples
