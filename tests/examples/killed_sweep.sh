#!/usr/bin/env bash
# killed_sweep.sh MPIEXEC PROGRAM FOLDER: a sweep by four processes, of which one is killed and one of whose checkpoints is
# damaged, goes on when it is started again, and gives the very file of an undisturbed run by one process.
set -euo pipefail
mpiexec=$1 program=$2 folder=$3
# shellcheck source=tests/examples/killed_process.sh
source "$(dirname "${BASH_SOURCE[0]}")/killed_process.sh"
settings=(--members 1501 --block 16 --time 30 --no-plot)

"$program" "${settings[@]}" --output whole

"$mpiexec" -n 4 "$program" "${settings[@]}" --output "$folder/killed" >killed.log 2>&1 &
launcher=$!
blocks() { find killed -name '*.block' 2>/dev/null | wc -l; }
for _ in $(seq 3000); do
  if [ "$(blocks)" -ge 2 ]; then break; fi
  sleep 0.01
done
kill_one "$folder/killed" "$launcher"
if compgen -G "killed/sweep.*" | grep -v checkpoints; then fail "a killed run left results"; fi
left=$(blocks)
[ "$left" -gt 0 ] && [ "$left" -lt 94 ] || fail "$left of 94 blocks were left: nothing to resume"
find killed -name '*.block' | sort | head -1 | xargs truncate --size=-1

"$mpiexec" -n 4 "$program" "${settings[@]}" --output "$folder/killed" >resumed.log 2>&1 || fail "$(cat resumed.log)"
cat resumed.log
grep -q "resumed: $((left - 1)) of 94 blocks" resumed.log || fail "it did not go on from $((left - 1)) good blocks"
grep -q "block: .*computed anew" resumed.log || fail "the damaged block went unnoticed"
for result in whole/sweep.*; do cmp "$result" "killed/${result#whole/}"; done
if compgen -G "killed/*.checkpoints" || compgen -G "killed/*.part"; then fail "something was left behind"; fi
