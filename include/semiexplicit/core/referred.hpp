#pragma once

#include <concepts>
#include <functional>
#include <type_traits>

namespace semiexplicit::detail {

/// The type of an observer; of std::ref() of it the observer's.
template <class O>
using Referred = std::remove_cvref_t<std::unwrap_reference_t<std::remove_cvref_t<O>>>;
/// And itself.
template <class O>
auto& referred(O& observer) {
  if constexpr (std::same_as<Referred<O>, std::remove_cvref_t<O>>)
    return observer;
  else
    return observer.get();
}

}  // namespace semiexplicit::detail
