#!/usr/bin/env bash
# weak_scaling.sh PROGRAM [ROUNDS [MEMBERS]]: ensemble_mpi on 1, 2, ... processes of this machine, up to its hardware threads, with
# so many members each. The numbers of processes take turns in every round. Prints member-steps a second by the clock on the wall, and a
# second of processor time, which the processes have to share with all else that runs here, with their efficiencies.
set -euo pipefail
program=$(realpath "$1") rounds=${2:-5} members=${3:-4096}
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
export OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1
export OMPI_MCA_rmaps_base_oversubscribe=1 OMPI_MCA_hwloc_base_binding_policy=none
for _ in $(seq "$rounds"); do
  for n in $(seq "$(nproc)"); do
    mpirun -n "$n" "$program" --members $((n * members)) --time 100 --no-plot --output "$folder/out" >"$folder/said"
    sed -nE 's/.* s, ([0-9.e+]+) member-steps a second, ([0-9.e+]+) .*/\1 \2/p' "$folder/said" >>"$folder/$n"
  done
done
# quantiles COLUMN FILE: 1st quartile, median, 3rd quartile.
quantiles() {
  cut -d' ' -f"$1" "$2" | sort -g |
    awk '{ x[NR] = $1 } END { for (q = 1; q <= 3; ++q) printf "%.2e ", x[1 + int(q / 4 * (NR - 1) + 0.5)] }'
}
echo "processes  member-steps a second: 1st quartile, median, 3rd    efficiency    a second of a processor: the same    efficiency"
for n in $(seq "$(nproc)"); do
  echo "$n $(quantiles 1 "$folder/$n") $(quantiles 2 "$folder/$n")"
done | awk 'NR == 1 { wall = $3; own = $6 }
  { printf "%9d  %s %s %s %35.0f %%    %s %s %s %18.0f %%\n", $1, $2, $3, $4, 100 * $3 / ($1 * wall), $5, $6, $7, 100 * $6 / own }'
