#pragma once

#include <concepts>
#include <memory>
#include <stdexcept>
#include <string>
#include <tuple>
#include <type_traits>
#include <utility>
#include <vector>

#include <semiexplicit/core/parameters.hpp>
#include <semiexplicit/core/vector.hpp>
#include <semiexplicit/derivatives/dual.hpp>
#include <semiexplicit/systems/detail/field_door.hpp>

namespace semiexplicit::effects::charges {

/// A magnetic field from its vector potential alone, by automatic differentiation: potential(x), or
/// potential(t, x) for one that depends on the time, gives the three components of A for numbers of any type.
///
///     const FieldFrom wave([=](const auto& t, const auto& x) {
///       using std::cos;
///       return std::array{0 * t, a0 * cos(k * x[2] - omega * t), 0 * t};
///     });
///
/// One that depends on the time also makes an electric field, -∂A/∂t; it is for RelativisticCharge.
template <class Potential>
class FieldFrom {
  template <class Scalar>
  using Dual = semiexplicit::detail::Dual<Scalar, 4>;  // by x, y, z, t
  template <class Scalar>
  struct Place {
    Dual<Scalar> of[3];
    explicit Place(const auto& x) {
      for (int i = 0; i < 3; ++i) {
        of[i] = Dual<Scalar>(x[i]);
        of[i].derivative[i] = Scalar(1);
      }
    }
    const Dual<Scalar>& operator[](int i) const { return of[i]; }
  };
  template <class X>
  using ScalarOf = std::decay_t<decltype(std::declval<const X&>()[0])>;
  static constexpr bool driven = std::invocable<const Potential&, const Dual<double>&, const Place<double>&>;

  static_assert(
      !semiexplicit::detail::takes_time_last<driven, Potential, const Place<double>&, const double&>(),
      "the potential of this FieldFrom takes a number behind the place, which would always be its "
      "default: the time comes first, (t, x)");

 public:
  explicit FieldFrom(Potential potential) : potential_(std::move(potential)) {}

  /// a += A.
  void add_potential(const auto& x, auto& a) const requires(!driven) { add(potential_(x), a); }
  void add_potential(const auto& t, const auto& x, auto& a) const requires driven {
    add(potential_(t, x), a);
  }
  /// out += factor ∂(v·A)/∂x, at fixed v.
  template <class X>
  void add_gradient(const X& x, const auto& v, const auto& factor, auto& out) const requires(!driven) {
    gradient<ScalarOf<X>>(potential_(Place<ScalarOf<X>>(x)), v, factor, out);
  }
  template <class X>
  void add_gradient(const auto& t, const X& x, const auto& v, const auto& factor,
                    auto& out) const requires driven {
    using Scalar = ScalarOf<X>;
    gradient<Scalar>(potential_(Dual<Scalar>(t), Place<Scalar>(x)), v, factor, out);
  }
  /// a += ∂A/∂t.
  template <class X>
  void add_time_derivative(const auto& t, const X& x, auto& a) const requires driven {
    using Scalar = ScalarOf<X>;
    Dual<Scalar> time(t);
    time.derivative[3] = Scalar(1);
    const auto potential = potential_(time, Place<Scalar>(x));
    for (int i = 0; i < 3; ++i) a[i] += Dual<Scalar>(at(potential, i)).derivative[3];
  }

 private:
  template <class List>
  static const auto& at(const List& list, int i) {
    if constexpr (requires { std::tuple_size<List>::value; }) {
      static_assert(std::tuple_size_v<List> == 3, "the potential of this FieldFrom has not three components");
    } else if constexpr (requires { requires List::SizeAtCompileTime != Eigen::Dynamic; }) {
      static_assert(List::SizeAtCompileTime == 3, "the potential of this FieldFrom has not three components");
    } else if constexpr (requires { list.size(); }) {
      if (list.size() != 3)
        throw std::invalid_argument("FieldFrom: the potential has " + std::to_string(list.size()) +
                                    " components; return the three of A");
    }
    return list[static_cast<std::size_t>(i)];
  }
  static void add(const auto& potential, auto& a) {
    for (int i = 0; i < 3; ++i) a[i] += at(potential, i);
  }
  template <class Scalar>
  static void gradient(const auto& potential, const auto& v, const auto& factor, auto& out) {
    for (int i = 0; i < 3; ++i)
      for (int k = 0; k < 3; ++k) out[k] += factor * v[i] * Dual<Scalar>(at(potential, i)).derivative[k];
  }

  Potential potential_;
};

/// Magnetic fields chosen at run time, as one: A is the sum of theirs, in double. A field costs a virtual
/// call. Copies share the fields.
class FieldSum {
 public:
  FieldSum() = default;

  // Moving copies: no sum loses its fields.
  FieldSum(const FieldSum&) = default;
  FieldSum& operator=(const FieldSum&) = default;

  /// One more, of this library or with add_potential(x, a) and add_gradient(x, v, factor, out) of its own.
  template <class Field>
  FieldSum& add(Field field) {
    static_assert(detail::field_adds<Field, double>());
    fields_.push_back(std::make_shared<Model<Field>>(std::move(field)));
    return *this;
  }
  bool empty() const { return fields_.empty(); }

  void add_potential(const auto& x, auto& a) const {
    const Vector<double, 3> at(x[0], x[1], x[2]);
    Vector<double, 3> sum(0, 0, 0);
    for (const auto& field : fields_) field->add_potential(at, sum);
    for (int i = 0; i < 3; ++i) a[i] += sum[i];
  }
  void add_gradient(const auto& x, const auto& v, double factor, auto& out) const {
    const Vector<double, 3> at(x[0], x[1], x[2]), velocity(v[0], v[1], v[2]);
    Vector<double, 3> sum(0, 0, 0);
    for (const auto& field : fields_) field->add_gradient(at, velocity, factor, sum);
    for (int i = 0; i < 3; ++i) out[i] += sum[i];
  }
  /// See BendField.
  void require_line(const auto& curvature) const {
    for (const auto& field : fields_) field->require_line(static_cast<double>(curvature));
  }
  Vector<double, 3> potential(const auto& x) const {
    Vector<double, 3> a(0, 0, 0);
    add_potential(x, a);
    return a;
  }

 private:
  struct Interface {
    virtual ~Interface() = default;
    virtual void add_potential(const Vector<double, 3>& x, Vector<double, 3>& a) const = 0;
    virtual void add_gradient(const Vector<double, 3>& x, const Vector<double, 3>& v, double factor,
                              Vector<double, 3>& out) const = 0;
    virtual void require_line(double curvature) const = 0;
  };
  template <class Field>
  struct Model final : Interface {
    explicit Model(Field wrapped) : field(std::move(wrapped)) {}
    void add_potential(const Vector<double, 3>& x, Vector<double, 3>& a) const override {
      field.add_potential(x, a);
    }
    void add_gradient(const Vector<double, 3>& x, const Vector<double, 3>& v, double factor,
                      Vector<double, 3>& out) const override {
      field.add_gradient(x, v, factor, out);
    }
    void require_line(double curvature) const override { detail::require_line(std::tie(field), curvature); }
    Field field;
  };

  std::vector<std::shared_ptr<const Interface>> fields_{};
};

}  // namespace semiexplicit::effects::charges
