#pragma once

#include <stdexcept>
#include <string>

/// Whether action() throws std::invalid_argument with that text in its message.
template <class Action>
bool refuses(const Action& action, const std::string& text) {
  try {
    action();
  } catch (const std::invalid_argument& error) {
    return std::string(error.what()).find(text) != std::string::npos;
  }
  return false;
}
