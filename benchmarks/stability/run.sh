#!/usr/bin/env bash
# run.sh [OPTION...]: the hard cases with every method, and the growth of rounding errors over 10^8 steps; tables and figures in
# results/ and README.md of this folder. About half an hour on one core (CORE=2 chooses it). Options go to the program (see
# build/release/benchmarks/bench_stability --help).
set -euo pipefail
# shellcheck source=cmake/stage.sh
source "$(dirname "${BASH_SOURCE[0]}")/../../cmake/stage.sh"

folder=benchmarks/stability

stage "Dependencies"
bash cmake/install-dependencies.sh benchmark

stage "Build (Release)"
cmake --preset release >&2
cmake --build --preset release --parallel "$(nproc)" --target bench_stability >&2

stage "Hard cases and long runs"
# The last of the cores that this process may use: the first often serves interrupts.
cores=$(taskset --cpu-list --pid $$ | sed 's/.*: //')
taskset --cpu-list "${CORE:-${cores##*[,-]}}" build/release/benchmarks/bench_stability --output "$folder/results" "$@"

stage "README"
part=$folder/README.md.part
awk -v folder="$folder/results" '
  /<!-- end/ { skip = 0 }
  !skip { print }
  /<!-- begin / { skip = 1; print ""; file = folder "/" $3; while ((getline line < file) > 0) print line; print "" }
' "$folder/README.md" >"$part"
mv "$part" "$folder/README.md"
