#pragma once

#include <algorithm>
#include <cmath>
#include <concepts>
#include <functional>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include <semiexplicit/core/hamiltonian_door.hpp>
#include <semiexplicit/core/reference_size.hpp>

namespace semiexplicit {

/// An observer that follows any number of named functions of (q, p) and keeps how far each one strayed from
/// its first value: relative to that value, or absolute where it is zero up to the rounding of its terms
/// (Row::relative tells). Of an ExtendedPoint it takes q and p. A NaN counts as the worst.
///
///     Invariants invariants(H);                                 // H.energy, under the name "energy"
///     invariants.add("mass", [](auto q, auto p) { return q.squaredNorm() + p.squaredNorm(); });
///     integrate(stepper, z, {.dt = 0.01, .steps = 1000}, invariants);
///     invariants["mass"].worst;
template <class Scalar, int Dof>
class Invariants {
 public:
  static constexpr const char* name = "Invariants";
  using Function = std::function<Scalar(const In<Scalar, Dof>&, const In<Scalar, Dof>&)>;

  /// What is known of one function.
  struct Row {
    std::string name;
    Function value;
    Scalar initial = Scalar(0);
    Scalar unit = Scalar(1);        ///< what errors are divided by: |initial|, or 1
    bool relative = false;          ///< whether that is |initial|
    Scalar worst = Scalar(0);       ///< largest error so far
    Scalar worst_time = Scalar(0);  ///< when it was first seen
    Scalar final = Scalar(0);       ///< error at the last call
    bool started = false;           ///< whether it has its first value
  };

  Invariants() = default;
  /// Follows the energy of H, of which it keeps a copy.
  template <class H>
  explicit Invariants(const H& hamiltonian) {
    if constexpr (detail::has_energy<H>())
      add("energy", [hamiltonian](const auto& q, const auto& p) {
        detail::require_same_dof("Invariants", q.size(), "Hamiltonian", dof_of(hamiltonian));
        return hamiltonian.energy(q, p);
      });
  }

  /// One more function, by a name of its own, else std::invalid_argument is thrown.
  template <std::convertible_to<Function> F>
  Invariants& add(std::string called, F value) {
    using Column = In<Scalar, Dof>;
    using Value = std::remove_cvref_t<std::invoke_result_t<F&, const Column&, const Column&>>;
    static_assert(
        !detail::is_narrower<Value, Scalar>,
        "this function tells no more than true and false, whole numbers, or ones of fewer digits than "
        "Scalar, which hides how far it strayed: let it return a Scalar");
    for (const Row& row : rows_)
      if (row.name == called)
        throw std::invalid_argument("Invariants: there is a function named '" + called +
                                    "' already; give this one a name of its own");
    rows_.push_back({.name = std::move(called), .value = std::move(value)});
    return *this;
  }

  template <detail::HasHalves State>
  void operator()(const Scalar& t, const State& state) {
    static_assert(detail::is_state_of<State, Dof>());
    using std::abs;
    if constexpr (Dof != Eigen::Dynamic)
      detail::require_same_dof("Invariants", state.q().size(), "functions' columns", Dof);
    for (Row& row : rows_) {
      const Scalar now = row.value(state.q(), state.p());
      if (!row.started) begin(row, now, state);
      row.final = abs(now - row.initial) / row.unit;
      if (!(row.final <= row.worst) &&
          row.worst == row.worst) {  // also true for a first NaN, which then stays
        row.worst = row.final;
        row.worst_time = t;
      }
    }
  }

  /// Forgets what it saw: the next call's values are the first ones again. Without it a second run counts as
  /// going on.
  void reset() {
    for (Row& row : rows_) row = {.name = std::move(row.name), .value = std::move(row.value)};
  }

  /// Whether it has no first values yet: a run that goes on would take its errors from there.
  bool fresh() const {
    return std::any_of(rows_.begin(), rows_.end(), [](const Row& row) { return !row.started; });
  }

  /// The functions by their names and values; see Describable.
  template <class List>
  void describe(List& list) const {
    for (const Row& row : rows_) list.function(row.name, row.value);
  }
  /// First values and errors so far, in the order of the rows; see CheckpointMemory.
  template <class Visitor>
  void visit_memory(Visitor&& visit) {
    for (Row& row : rows_) {
      for (Scalar* number : {&row.initial, &row.unit, &row.worst, &row.worst_time, &row.final})
        visit(*number);
      visit(row.relative);
      visit(row.started);
    }
  }

  const std::vector<Row>& rows() const { return rows_; }
  /// The row of that name; throws std::out_of_range where there is none.
  const Row& operator[](const std::string& called) const {
    for (const Row& row : rows_)
      if (row.name == called) return row;
    throw std::out_of_range("Invariants: no function named '" + called + "'");
  }

 private:
  template <class State>
  static void begin(Row& row, const Scalar& now, const State& state) {
    const auto reference =
        detail::reference_size(row.value, now, PhasePoint<Scalar, Dof>(state.q(), state.p()));
    row.initial = now;
    row.unit = reference.size;
    row.relative = reference.relative;
    row.started = true;
  }

  std::vector<Row> rows_;
};

template <class H>
Invariants(const H&)
    -> Invariants<typename detail::HamiltonianDoor<H>::Scalar, detail::HamiltonianDoor<H>::Dof>;

}  // namespace semiexplicit
