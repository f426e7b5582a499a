#!/usr/bin/env bash
# weak_scaling.sh PROGRAM [ROUNDS [SITES [STEPS]]]: nls_mpi on 1, 2, ... processes of this machine, up to its hardware threads and then
# twice as many, with so many sites each. The numbers of processes take turns in every round; the best of each counts.
set -euo pipefail
program=$(realpath "$1") rounds=${2:-5} sites=${3:-200000} steps=${4:-40}
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
export OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1
export OMPI_MCA_rmaps_base_oversubscribe=1 OMPI_MCA_hwloc_base_binding_policy=none OMPI_MCA_mpi_yield_when_idle=1
counts="$(seq "$(nproc)") $((2 * $(nproc)))"
for _ in $(seq "$rounds"); do
  for n in $counts; do
    mpirun -n "$n" "$program" --sites $((n * sites)) --dt 0.05 --time "$(awk "BEGIN { print $steps * 0.05 }")" >"$folder/said"
    sed -nE 's/.* s, ([0-9.e+]+) site-steps a second, ([0-9.e+]+) .*/\1 \2/p' "$folder/said" >>"$folder/$n"
  done
done
# best COLUMN FILE
best() { cut -d' ' -f"$1" "$2" | sort -g | tail -1; }
echo "| processes | sites | site-steps a second | efficiency | a second of a processor | efficiency |"
echo "|---|---|---|---|---|---|"
for n in $counts; do
  echo "$n $((n * sites)) $(best 1 "$folder/$n") $(best 2 "$folder/$n")"
done | awk 'NR == 1 { wall = $3; own = $4 }
  { printf "| %d | %d | %.2e | %.0f %% | %.2e | %.0f %% |\n", $1, $2, $3, 100 * $3 / ($1 * wall), $4, 100 * $4 / own }'
