#pragma once

#include <algorithm>
#include <cctype>
#include <cstddef>
#include <numeric>
#include <string>
#include <vector>

namespace semiexplicit {

namespace detail {

/// How many letters must be changed, put in or left out to make one word of the other (Levenshtein's
/// distance).
inline std::size_t edit_distance(const std::string& a, const std::string& b) {
  std::vector<std::size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (std::size_t i = 0; i < a.size(); ++i) {
    std::size_t diagonal = row[0];
    row[0] = i + 1;
    for (std::size_t j = 0; j < b.size(); ++j) {
      const auto low = [](char c) { return std::tolower(static_cast<unsigned char>(c)); };
      const std::size_t replaced = diagonal + (low(a[i]) == low(b[j]) ? 0 : 1);
      diagonal = row[j + 1];
      row[j + 1] = std::min({replaced, row[j] + 1, diagonal + 1});
    }
  }
  return row.back();
}

}  // namespace detail

/// The valid names that are most like `word`, nearest first, at most `count`: what the user may have meant.
inline std::vector<std::string> nearest_names(const std::string& word, std::vector<std::string> valid,
                                              std::size_t count = 3) {
  std::stable_sort(valid.begin(), valid.end(), [&](const std::string& a, const std::string& b) {
    return detail::edit_distance(word, a) < detail::edit_distance(word, b);
  });
  valid.resize(std::min(count, valid.size()));
  return valid;
}

/// "no <kind> is called 'coriolos'; the nearest names are coriolis, kinetic", for one clear line to a user.
inline std::string unknown_name(const std::string& kind, const std::string& word,
                                const std::vector<std::string>& valid) {
  std::string text = "no " + kind + " is called '" + word + "'; the nearest names are ";
  const std::vector<std::string> nearest = nearest_names(word, valid);
  if (nearest.empty()) return "no " + kind + " is called '" + word + "'; there is none at all";
  for (std::size_t i = 0; i < nearest.size(); ++i) text += (i > 0 ? ", " : "") + nearest[i];
  return text;
}

}  // namespace semiexplicit
