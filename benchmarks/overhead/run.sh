#!/usr/bin/env bash
# The overhead of a step beyond its kicks by hand, with g++ and clang++ and their usual options: bench_overhead, compiled six
# times, each run in nine processes. Where a process has its stack decides over a third of the time of the smallest steps, so
# one process says little: printed are the median of the processes and, in brackets, the least and the largest.
# Usage: bash benchmarks/overhead/run.sh [rounds]; pins itself to the last core.
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
    for _ in {1..9}; do taskset -c $core "$build/overhead" "${1:-50}"; done | awk '
      function median(list, n, i, j, v) {
        n = split(list, x, " ")
        for (i = 2; i <= n; ++i) { v = x[i] + 0; for (j = i - 1; j > 0 && x[j] + 0 > v; --j) x[j + 1] = x[j]; x[j + 1] = v }
        return sprintf("%.3f (%.3f to %.3f)", x[int((n + 1) / 2)], x[1], x[n])
      }
      / ns a kick /  { if (!head++) print "yoshida6, 1 evaluation      ns a kick (least, largest)    plain / by hand              compensated / by hand" }
      /per degree/   { if (scale[$1 $2]++ == 0) tail = tail $0 "\n" }
      /^.*\(.* to .*\).*\(.* to .*\)$/ {
        name = substr($0, 1, 26); split(substr($0, 27), field, " ")
        if (!(name in kick)) order[++rows] = name
        kick[name] = kick[name] " " field[1]; plain[name] = plain[name] " " field[2]; sum[name] = sum[name] " " field[6]
      }
      END {
        for (i = 1; i <= rows; ++i)
          printf "%-26s  %-28s  %-26s  %s\n", order[i], median(kick[order[i]]), median(plain[order[i]]), median(sum[order[i]])
        printf "\n%s", tail
      }'
    echo
  done
done
