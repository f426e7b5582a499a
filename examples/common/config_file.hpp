#pragma once

#include <cctype>
#include <cstddef>
#include <ios>
#include <istream>
#include <map>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>
#include <semiexplicit/scene/nearest_names.hpp>

namespace examples {

/// The files of --config: a subset of TOML without sections. Lines `name = value`, where the value is a word or number, a
/// "text" or 'text', or a list [..., ...] of these, which may go over several lines; # begins a comment. What is wrong is
/// refused as "file:line: reason", and so is more than a million bytes.
class ConfigFile : public CLI::Config {
 public:
  explicit ConfigFile(const CLI::App& app) : app_(app) {}

  /// "file:line: " of the option that a message "--name: ..." speaks of, if it was read here.
  std::string where(const std::string& message) const {
    for (const auto& [name, line] : lines_)
      if (message.starts_with("--" + name + ":")) return at(line);
    return "";
  }

  std::vector<CLI::ConfigItem> from_config(std::istream& in) const override {
    std::vector<CLI::ConfigItem> read;
    lines_.clear();
    line_ = 1;
    std::string bytes(1'000'001, '\0');
    in.read(bytes.data(), static_cast<std::streamsize>(bytes.size()));
    bytes.resize(static_cast<std::size_t>(in.gcount()));
    if (bytes.size() > 1'000'000) refuse("the file is longer than 1 MB; give one of name = value lines");
    in_.str(bytes);
    in_.clear();
    line_ = 0;
    while (next_line()) {
      skip_blanks();
      if (done()) continue;
      if (text_[at_] == '[') refuse("sections mean nothing here; give name = value");
      std::string name;
      while (!done() && (std::isalnum(byte()) || text_[at_] == '-' || text_[at_] == '_'))
        name += text_[at_++];
      skip_blanks();
      if (name.empty() || done() || text_[at_] != '=') refuse("this is not name = value");
      ++at_;
      check(name);
      lines_[name] = line_;
      read.push_back({{}, name, values()});
      const std::vector<std::string>& given = read.back().inputs;
      if (app_.get_option("--" + name)->get_expected_max() == 0 &&
          given != std::vector<std::string>{"true"} && given != std::vector<std::string>{"false"})
        refuse("'" + name + "' is true or false");
      skip_blanks();
      if (!done())
        refuse("'" + text_.substr(at_) + "' is left over; a text with blanks, as \"5 km\", needs quotes");
    }
    return read;
  }

  std::string to_config(const CLI::App*, bool, bool, std::string) const override {
    throw std::logic_error("ConfigFile: configurations are read only");
  }

 private:
  std::string at(int line) const {
    const CLI::Option* const option = app_.get_config_ptr();
    const std::string file = option && option->count() > 0 ? option->results().back() : "configuration";
    return file + ":" + std::to_string(line) + ": ";
  }
  [[noreturn]] void refuse(const std::string& reason) const {
    throw CLI::ConfigError(at(line_) + reason, CLI::ExitCodes::ConfigError);
  }

  void check(const std::string& name) const {
    const CLI::Option* const option = app_.get_option_no_throw("--" + name);
    std::vector<std::string> names;
    for (const CLI::Option* known : app_.get_options())
      if (known->get_configurable()) names.push_back(known->get_single_name());
    if (option == nullptr) refuse(semiexplicit::unknown_name("option", name, names));
    if (!option->get_configurable()) refuse("'" + name + "' goes on the command line only");
    if (lines_.count(name) > 0)
      refuse("'" + name + "' has a value already, see line " + std::to_string(lines_.at(name)));
  }

  std::vector<std::string> values() const {
    skip_blanks();
    if (done() || text_[at_] != '[') return {value()};
    ++at_;
    std::vector<std::string> list;
    for (;;) {
      to_next_in_list();
      if (text_[at_] == ']') break;
      list.push_back(value());
      to_next_in_list();
      if (text_[at_] == ']') break;
      if (text_[at_] != ',') refuse("a list is written as [one, two]");
      ++at_;
    }
    ++at_;
    if (list.empty()) refuse("the list is empty; leave the line out");
    return list;
  }

  std::string value() const {
    if (done()) refuse("there is no value");
    const char quote = text_[at_];
    std::string value;
    if (quote == '"' || quote == '\'') {
      for (++at_; at_ < text_.size() && text_[at_] != quote; ++at_) {
        if (text_[at_] == '\\' && quote == '"' && ++at_ < text_.size() && text_[at_] != '"' &&
            text_[at_] != '\\')
          refuse("after \\ comes \" or another \\; in 'text' it is an ordinary character");
        if (at_ < text_.size()) value += text_[at_];
      }
      if (at_ >= text_.size()) refuse("the text has no end; there is a quote missing");
      ++at_;
    } else {
      while (!done() && !std::isspace(byte()) && std::string("[],\"'=").find(text_[at_]) == std::string::npos)
        value += text_[at_++];
    }
    if (value.empty()) refuse("there is no value");
    return value;
  }

  bool next_line() const {
    if (!std::getline(in_, text_)) return false;
    ++line_;
    at_ = 0;
    if (line_ == 1 && text_.starts_with("\xef\xbb\xbf")) at_ = 3;  // the byte order mark of some editors
    if (!text_.empty() && text_.back() == '\r') text_.pop_back();
    for (const char c : text_)
      if (static_cast<unsigned char>(c) < ' ' && c != '\t')
        refuse("there is a control character in the line");
    return true;
  }
  void to_next_in_list() const {
    const int begin = line_;
    skip_blanks();
    while (done()) {
      if (!next_line()) {
        line_ = begin;
        refuse("the list has no end; there is a ] missing");
      }
      skip_blanks();
    }
  }
  unsigned char byte() const { return static_cast<unsigned char>(text_[at_]); }
  bool done() const { return at_ >= text_.size() || text_[at_] == '#'; }
  void skip_blanks() const {
    while (!done() && std::isspace(byte())) ++at_;
  }

  // CLI11 wants a reader that is const; what follows is where it is in the file.
  const CLI::App& app_;
  mutable std::istringstream in_;
  mutable std::map<std::string, int> lines_;
  mutable std::string text_;
  mutable std::size_t at_ = 0;
  mutable int line_ = 0;
};

}  // namespace examples
