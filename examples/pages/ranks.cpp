// One trajectory in blocks, by ranks that are threads here and would be processes elsewhere: the Hamiltonian
// of a block asks its neighbours for what its gradient reads, and says how a sum becomes one over all blocks.
#include <barrier>
#include <cstddef>
#include <iostream>
#include <thread>
#include <vector>

#include <semiexplicit/semiexplicit.hpp>

using namespace semiexplicit;
constexpr int Dynamic = Eigen::Dynamic;

class Team {  // what MPI would do
 public:
  explicit Team(std::size_t ranks) : barrier_(static_cast<std::ptrdiff_t>(ranks)), told_(ranks) {}
  /// What the ranks tell, in their order.
  template <class Use>
  auto tell(std::size_t rank, double x, const Use& use) {
    told_[rank] = x;
    barrier_.arrive_and_wait();
    const auto result = use(told_);
    barrier_.arrive_and_wait();  // before anybody tells something else
    return result;
  }

 private:
  std::barrier<> barrier_;
  std::vector<double> told_;
};

struct Block {  // of Σ (qᵢ² + 1)(pᵢ² + 1)/2 + Σ (qᵢ - qᵢ₊₁)²/2
  using Scalar = double;
  static constexpr int Dof = Dynamic;
  Eigen::Index n;
  Team* team;
  std::size_t rank;

  Eigen::Index dof() const { return n; }
  double sum_over_ranks(const double& x) const {  // makes it one of several
    return team->tell(rank, x, [](const std::vector<double>& all) {
      double sum = 0;
      for (const double one : all) sum += one;
      return sum;
    });
  }
  void gradient(In<double, Dynamic> q, In<double, Dynamic> p, Out<double, Dynamic> dHdq,
                Out<double, Dynamic> dHdp) const {
    for (Eigen::Index i = 0; i < n; ++i) {
      dHdq[i] = q[i] * (p[i] * p[i] + 1);
      if (i > 0) dHdq[i] += q[i] - q[i - 1];
      if (i + 1 < n) dHdq[i] += q[i] - q[i + 1];
      dHdp[i] = p[i] * (q[i] * q[i] + 1);
    }
    // The site of the left neighbour's end, and of the right one's; at an end of the chain there is none.
    dHdq[0] += q[0] - team->tell(rank, q[n - 1], [&](const std::vector<double>& ends) {
      return rank > 0 ? ends[rank - 1] : q[0];
    });
    dHdq[n - 1] += q[n - 1] - team->tell(rank, q[0], [&](const std::vector<double>& ends) {
      return rank + 1 < ends.size() ? ends[rank + 1] : q[n - 1];
    });
  }
};

/// A chain of twelve sites in so many blocks; what the first rank reports, and the whole state.
struct Result {
  IntegrationReport run;
  Vector<double, Dynamic> q = Vector<double, Dynamic>::Zero(12);
};
Result run(std::size_t ranks) {
  Team team(ranks);
  Result result;
  std::vector<std::thread> threads;
  for (std::size_t rank = 0; rank < ranks; ++rank)
    threads.emplace_back([&, rank] {
      const Eigen::Index n = 12 / static_cast<Eigen::Index>(ranks),
                         begin = n * static_cast<Eigen::Index>(rank);
      PhasePoint<double, Dynamic> z(n);
      for (Eigen::Index i = 0; i < n; ++i) {
        z.q()[i] = 1 / static_cast<double>(1 + begin + i);
        z.p()[i] = 0.1 * static_cast<double>(begin + i);
      }
      Semiexplicit stepper(Block{n, &team, rank}, schemes::low_defect6_s13<double>());
      const IntegrationReport report = integrate(stepper, z, {.dt = 0.1, .steps = 100});
      result.q.segment(begin, n) = z.q();
      if (rank == 0) result.run = report;
    });
  for (std::thread& thread : threads) thread.join();
  return result;
}

int main() {
  const Result one = run(1), three = run(3);
  const double apart = (one.q - three.q).norm() / one.q.norm();
  std::cout << "evaluations: " << one.run.evaluations << " by one rank, " << three.run.evaluations
            << " by three\n"
            << (apart < 1e-11 ? "the same state but for rounding\n" : "the state differs\n");
  return one.run.evaluations == three.run.evaluations && apart < 1e-11 ? 0 : 1;
}
