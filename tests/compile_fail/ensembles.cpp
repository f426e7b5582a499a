// case no_mistake: compiles
// case outputs_by_value: takes dHdq or dHdp by value, so what it writes is lost: take both as Out<Scalar, Dof>
// case without_dof: does not say how many degrees of freedom it has: write `static constexpr int Dof = 2;` in it
// case swapped: takes the time as a whole number, or one of fewer digits than double, or the member as no whole one: of members write
// case any_swapped: takes the time as a whole number, or one of fewer digits than double, or the member as no whole one: of members write
// case long_swapped: takes the time as a whole number, or one of fewer digits than double, or the member as no whole one: of members write
// case whole_time: takes the time as a whole number, or one of fewer digits than double, or the member as no whole one: of members write
// case float_time: takes the time as a whole number, or one of fewer digits than double, or the member as no whole one: of members write
// case float_time_of_whole: takes the time as a whole number, or one of fewer digits than double, or the member as no whole one: of members write
// case of_both: can be called of members and of the whole, and one of both would never be: give two observers
// case one_by_value: takes dHdq or dHdp by value, so what it writes is lost: take both as Out<Scalar, Dof>
// case each_forgotten: for one of integrate()'s a member give each(observers)
// case each_of_invariants_forgotten: for one of integrate()'s a member give each(observers)
// case each_of_csv_forgotten: for one of integrate()'s a member give each(observers)
// case each_of_every_forgotten: for one of integrate()'s a member give each(observers)
// case each_of_books_forgotten: for one of integrate()'s a member give each(observers)
#include <semiexplicit/ensemble.hpp>
#include <semiexplicit/scene.hpp>
#include <semiexplicit/schemes/named.hpp>
#include <semiexplicit/semiexplicit.hpp>

using namespace semiexplicit;

template <class S>
struct Pendulum {
  using Scalar = S;
  static constexpr int Dof = 1;
  S k;
#ifdef outputs_by_value
  void gradient(In<S, 1> q, In<S, 1> p, Vector<S, 1> dHdq, Vector<S, 1> dHdp) const {
#elif defined(one_by_value)
  void gradient(const auto& q, const auto& p, auto& dHdq, Vector<S, 1> dHdp) const {
#else
  void gradient(In<S, 1> q, In<S, 1> p, Out<S, 1> dHdq, Out<S, 1> dHdp) const {
#endif
    dHdq[0] = k * q[0];
    dHdp[0] = p[0];
  }
};

struct OfBoth {
  void operator()(Eigen::Index, double, const auto&) const {}
  void operator()(double, const EnsembleReport&) const {}
};
struct WithoutDof {
  using Scalar = double;
  void gradient(const auto& q, const auto& p, auto& dHdq, auto& dHdp) const { dHdq = q, dHdp = p; }
};

int main() {
  const std::vector<PhasePoint<double, 1>> starts(2, PhasePoint<double, 1>(1, 0));
#ifdef without_dof
  Ensemble all(WithoutDof{}, starts, schemes::strang());
#endif
  Ensemble ensemble([]<class S>(const S* k) { return Pendulum<S>{k[0]}; }, Eigen::MatrixXd::Ones(1, 2),
                    starts, schemes::strang());
#if defined(swapped)
  ensemble.run({.dt = 0.1, .steps = 1}, [](double, Eigen::Index, const PhasePoint<double, 1>&) {});
#elif defined(any_swapped)
  ensemble.run({.dt = 0.1, .steps = 1}, [](double, int, const auto&) {});
#elif defined(long_swapped)
  ensemble.run({.dt = 0.1, .steps = 1}, [](double, int, const auto&, const auto&) {});
#elif defined(whole_time)
  ensemble.run({.dt = 0.1, .steps = 1}, [](int, const EnsembleReport&) {});
#elif defined(float_time)
  ensemble.run({.dt = 0.1, .steps = 1}, [](int, float, const auto&) {});
#elif defined(float_time_of_whole)
  ensemble.run({.dt = 0.1, .steps = 1}, [](float, const EnsembleReport&) {});
#elif defined(of_both)
  ensemble.run({.dt = 0.1, .steps = 1}, OfBoth{});
#elif defined(each_forgotten)
  Record<double, 1> record;
  ensemble.run({.dt = 0.1, .steps = 1}, record);
#elif defined(each_of_invariants_forgotten)
  Invariants<double, 1> invariants;
  ensemble.run({.dt = 0.1, .steps = 1}, invariants);
#elif defined(each_of_csv_forgotten)
  ensemble.run({.dt = 0.1, .steps = 1}, CsvTrajectory("file", 1));
#elif defined(each_of_every_forgotten)
  Record<double, 1> record;
  ensemble.run({.dt = 0.1, .steps = 1}, every(2, record));
#elif defined(each_of_books_forgotten)
  Books<double, 1> books{RuntimeScene<double, 1>(std::vector<AnyEffect<double, 1>>{})};
  ensemble.run({.dt = 0.1, .steps = 1}, books);
#else
  std::vector<Record<double, 1>> records(2);
  std::vector sparse(2, every(2, Record<double, 1>()));
  ensemble.run({.dt = 0.1, .steps = 1}, each(records), each(sparse), Progress(0.1));
  ensemble.run(
      {.dt = 0.1, .steps = 1}, [](Eigen::Index, double, const PhasePoint<double, 1>&) {},
      [](auto, auto, const auto&) {}, [](double, const EnsembleReport&) {}, [](int, double, const auto&) {},
      [](std::size_t, const double&, auto, const auto&) {},
      [](auto, auto t, const auto&, const IntegrationReport&) { return t + 1 > 0; });
#endif
}
