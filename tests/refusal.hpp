#pragma once

#include <stdexcept>
#include <string>

/// What action() says when it throws std::invalid_argument.
template <class Action>
std::string refusal(const Action& action) {
  try {
    action();
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "nothing was refused";
}

/// What action() says when it throws std::runtime_error.
template <class Action>
std::string complaint(const Action& action) {
  try {
    action();
  } catch (const std::runtime_error& error) {
    return error.what();
  }
  return "no complaint";
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
