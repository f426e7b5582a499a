#!/usr/bin/env bash
# run.sh [OPTION...] [PROBLEM...]: what accuracy costs, two hours and more for all problems; tables, figures and the summary in
# README.md of this folder. Of problems that are not named the tables stay as they are. Installs what is missing, builds what is
# needed and runs on one core (CORE=2 chooses it). With --short: a test that everything runs, its results in a temporary folder.
# Other options go to the program (see build/release/benchmarks/bench_work_precision --help).
set -euo pipefail
# shellcheck source=cmake/stage.sh
source "$(dirname "${BASH_SOURCE[0]}")/../../cmake/stage.sh"

folder=benchmarks/work_precision
is_short=false
for option in "$@"; do
  if [ "$option" = --short ]; then is_short=true; fi
done

stage "Dependencies"
bash cmake/install-dependencies.sh benchmark

stage "Build (Release)"
cmake --preset release >&2
cmake --build --preset release --parallel "$(nproc)" --target bench_work_precision >&2

stage "Energy error against time"
# The last of the cores that this process may use: the first often serves interrupts.
cores=$(taskset --cpu-list --pid $$ | sed 's/.*: //')
pinned=(taskset --cpu-list "${CORE:-${cores##*[,-]}}")
if $is_short; then
  output=$(mktemp -d)
  "${pinned[@]}" build/release/benchmarks/bench_work_precision --output "$output" "$@"
  exit
fi
"${pinned[@]}" build/release/benchmarks/bench_work_precision --output "$folder" "$@"

stage "README"
part=$folder/README.md.part
awk -v summary="$folder/tables/summary.md" '
  /<!-- results: end/ { skip = 0 }
  !skip { print }
  /<!-- results: begin/ { skip = 1; print ""; while ((getline line < summary) > 0) print line; print "" }
' "$folder/README.md" >"$part"
mv "$part" "$folder/README.md"
