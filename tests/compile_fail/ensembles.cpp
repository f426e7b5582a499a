// case no_mistake: compiles
// case outputs_by_value: takes dHdq or dHdp by value, so what it writes is lost: take both as Out<Scalar, Dof>
// case without_dof: does not say how many degrees of freedom it has: write `static constexpr int Dof = 2;` in it
// case one_by_value: takes dHdq or dHdp by value, so what it writes is lost: take both as Out<Scalar, Dof>
#include <semiexplicit/ensemble.hpp>
#include <semiexplicit/schemes/named.hpp>

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
}
