#pragma once

#include <concepts>
#include <type_traits>

namespace semiexplicit::detail {

/// A function that lives elsewhere, of which only the signature shows: what takes one is compiled once,
/// whatever function it is handed. Must not outlive the function.
template <class Signature>
class FunctionRef;
template <class Result, class... Arguments>
class FunctionRef<Result(Arguments...)> {
 public:
  template <class F>
  requires(!std::same_as<F, FunctionRef>) FunctionRef(const F& f)
      : function_(&f), call_([](const void* function, Arguments... arguments) -> Result {
          return (*static_cast<const F*>(function))(arguments...);
        }) {}

  Result operator()(Arguments... arguments) const { return call_(function_, arguments...); }

 private:
  const void* function_;
  Result (*call_)(const void*, Arguments...);
};

}  // namespace semiexplicit::detail
