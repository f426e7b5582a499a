#!/usr/bin/env bash
# compile_time.sh [COMPILER...]
#
# What the headers cost a compiler: prints seconds (user, the best of three) and MB (the most resident) of -std=c++20 -O2 for
# small programs, and the seconds beyond those of <Eigen/Dense> alone. Without arguments by g++ and clang++. EIGEN=folder says
# where Eigen is (default /usr/include/eigen3), REPEAT=n how often each is compiled, FLAGS what else is given.
set -euo pipefail
cd "$(dirname "$0")/.."
compilers=("$@")
[ $# -gt 0 ] || compilers=(g++ clang++)
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT

echo '#include <Eigen/Dense>' >"$folder/eigen.cpp"
echo '#include <semiexplicit/semiexplicit.hpp>' >"$folder/umbrella.cpp"
for header in include/semiexplicit/*.hpp; do
  echo "#include <semiexplicit/${header##*/}>"
done >"$folder/all_groups.cpp"
for name in eigen umbrella all_groups; do echo 'int main() {}' >>"$folder/$name.cpp"; done
cp examples/quickstart.cpp "$folder/quickstart.cpp"
cat >"$folder/adviser.cpp" <<'PROGRAM'
#include <iostream>

#include <semiexplicit/accuracy.hpp>

using namespace semiexplicit;

struct Product {  // H = (q² + 1)(p² + 1)/2
  using Scalar = double;
  static constexpr int Dof = 1;
  double energy(In<double, 1> q, In<double, 1> p) const { return (q[0] * q[0] + 1) * (p[0] * p[0] + 1) / 2; }
  void gradient(In<double, 1> q, In<double, 1> p, Out<double, 1> dHdq, Out<double, 1> dHdp) const {
    dHdq[0] = q[0] * (p[0] * p[0] + 1);
    dHdp[0] = p[0] * (q[0] * q[0] + 1);
  }
};

int main() {
  PhasePoint<double, 1> z(-3, 0);
  const CostOfAccuracy cost = cost_of_accuracy(Product{}, z, 1000);
  if (const auto advice = cost.cheapest(1e-8)) {
    run(Product{}, z, 1000, advice->setting);
    std::cout << advice->setting.name() << ' ' << z.q()[0] << ' ' << z.p()[0] << '\n';
  }
}
PROGRAM

printf '%-12s %-14s %8s %8s %6s\n' compiler program seconds 'beyond' MB
for compiler in "${compilers[@]}"; do
  alone=
  for name in eigen umbrella all_groups quickstart adviser; do
    for ((i = 0; i < ${REPEAT:-3}; ++i)); do
      /usr/bin/time -f '%U %M' -a -o "$folder/$compiler.$name" "$compiler" -std=c++20 -O2 ${FLAGS:-} -Iinclude \
        -isystem "${EIGEN:-/usr/include/eigen3}" -c "$folder/$name.cpp" -o "$folder/$name.o"
    done
    read -r seconds kilobytes < <(sort -n "$folder/$compiler.$name" | head -n 1)
    alone=${alone:-$seconds}
    printf '%-12s %-14s %8.2f %8s %6d\n' "$compiler" "$name" "$seconds" "$(echo "$seconds - $alone" | bc)" $((kilobytes / 1024))
  done
done
