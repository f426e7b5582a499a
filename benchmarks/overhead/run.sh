#!/usr/bin/env bash
# The overhead of a step beyond its kicks by hand, with g++ and clang++ and their usual options: bench_overhead, compiled six
# times. Usage: bash benchmarks/overhead/run.sh [rounds]; pins itself to the last core.
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
build=$(mktemp -d)
trap 'rm -rf "$build"' EXIT
eigen=$(pkg-config --variable=includedir eigen3 2>/dev/null || true)
[ -n "$eigen" ] && [ -d "$eigen" ] || eigen=/usr/include/eigen3
core=$(($(nproc) - 1))
for compiler in g++ clang++; do
  command -v $compiler >/dev/null || { echo "$compiler is not installed, and left out"; continue; }
  for options in "-O2" "-O3" "-O3 -march=native"; do
    echo "== $compiler $options"
    # shellcheck disable=SC2086
    $compiler -std=c++20 $options -DNDEBUG -I"$root/include" -isystem "$eigen" -isystem "$eigen/eigen3" \
      "$root/benchmarks/overhead/overhead.cpp" -o "$build/overhead"
    taskset -c $core "$build/overhead" "${1:-200}"
    echo
  done
done
