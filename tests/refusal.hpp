#pragma once

#include <stdexcept>
#include <string>

/// What complaint() and refusal() return when nothing is thrown.
inline const std::string accepted = "nothing was refused";

/// What action() says when it throws an Error; accepted when it throws none.
template <class Error = std::runtime_error, class Action>
std::string complaint(const Action& action) {
  try {
    action();
  } catch (const Error& error) {
    return error.what();
  }
  return accepted;
}

/// What action() says when it throws std::invalid_argument.
template <class Action>
std::string refusal(const Action& action) {
  return complaint<std::invalid_argument>(action);
}

/// Whether a message contains that text.
inline bool says(const std::string& message, const std::string& text) {
  return message.find(text) != std::string::npos;
}

/// Whether action() throws std::invalid_argument with that text in its message.
template <class Action>
bool refuses(const Action& action, const std::string& text) {
  return says(refusal(action), text);
}
