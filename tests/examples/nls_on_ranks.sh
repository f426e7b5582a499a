#!/usr/bin/env bash
# nls_on_ranks.sh MPIEXEC PROGRAM FOLDER: one lattice by 1, 2 and 3 processes takes the same evaluations to the same state but for
# rounding; a run of which a process was killed goes on from what all had saved, to the very figures of an undisturbed one; a step
# that does not converge ends on all.
set -euo pipefail
mpiexec=$1 program=$2 folder=$3
# shellcheck source=tests/examples/killed_process.sh
source "$(dirname "${BASH_SOURCE[0]}")/killed_process.sh"
export OMPI_MCA_mpi_yield_when_idle=1

# figures FILE: all but the timing.
figures() { grep -E '^(sites|participation|worst)' "$1"; }
for n in 1 2 3; do
  timeout 100 "$mpiexec" -n $n "$program" --sites 1000 --time 3 --tolerance 1e-24 >ranks$n.log || fail "$n processes: $(cat ranks$n.log)"
  cat ranks$n.log
  [ "$(grep ^sites ranks$n.log)" = "$(grep ^sites ranks1.log)" ] || fail "$n processes took other evaluations"
  paste <(grep ^participation ranks$n.log) <(grep ^participation ranks1.log) |
    awk '{ d = $3 - $(NF / 2 + 3); if (d < 0) d = -d; exit !($3 > 0 && d <= 1e-12 * $3) }' || fail "$n processes came elsewhere"
  sed -nE 's/^worst energy error: ([0-9.e+-]+), worst mass error: ([0-9.e+-]+)$/\1 \2/p' ranks$n.log |
    awk '{ seen = 1; bad = !($1 < 1e-6 && $2 < 1e-12) } END { exit bad || !seen }' || fail "$n processes: the invariants drift"
done

settings=(--sites 3000 --dt 0.005 --time 4 --checkpoint 50 --output "$folder/saved")
timeout 200 "$mpiexec" -n 2 "$program" --sites 3000 --dt 0.005 --time 4 >whole.log
"$mpiexec" -n 2 "$program" "${settings[@]}" >killed.log 2>&1 &
launcher=$!
for _ in $(seq 3000); do
  if [ "$(find saved -name '*of2-step*0.checkpoint' 2>/dev/null | wc -l)" -ge 4 ]; then break; fi
  sleep 0.01
done
kill_one "$folder/saved" "$launcher"
# As if it had been killed between the saves of the two: one rank lacks the latest.
latest=$(find saved -name 'rank0of2-*' | sed -E 's/.*step([0-9]+).*/\1/' | sort -n | tail -1)
rm -f "saved/rank1of2-step$latest.checkpoint"
# And as if the saves before had not been taken away yet.
for rank in 0 1; do
  for file in saved/rank${rank}of2-*; do cp "$file" "$folder/old"; done
  for step in 1 2; do cp "$folder/old" "saved/rank${rank}of2-step$step.checkpoint"; done
done
cp "saved/rank0of2-step$latest.checkpoint" another
# A start that is refused leaves all files: one where a rank lacks its own, one that finds a damaged file.
refuses() { # refuses WHY
  ls saved >before.txt
  if timeout 100 "$mpiexec" -n 2 "$program" "${settings[@]}" >refused.log 2>&1; then fail "it did not refuse: $1"; fi
  grep -q -- "$1" refused.log || fail "$(cat refused.log)"
  ls saved | diff before.txt - || fail "a start that was refused took files away"
}
# One that begins anew beside files of another number of processes says so, and leaves them.
ls saved >before.txt
timeout 100 "$mpiexec" -n 1 "$program" --sites 3000 --dt 0.005 --time 0.1 --checkpoint 50 --output "$folder/saved" >other.log 2>&1 ||
  fail "$(cat other.log)"
grep -q "begins anew; .*rank0of2-step.* another number of processes" other.log || fail "files of two processes went unmentioned"
ls saved | diff before.txt - || fail "a run of one process took files of two away"
mkdir away
mv saved/rank1* away
refuses "bring the missing files back"
mv away/* saved
for rank in 0 1; do echo "not one" >"saved/rank${rank}of2-step999999.checkpoint"; done
refuses "is not a checkpoint"
rm saved/*step999999*
timeout 200 "$mpiexec" -n 2 "$program" "${settings[@]}" >resumed.log 2>&1 || fail "$(cat resumed.log)"
cat resumed.log
common=$(sed -nE 's/^resumed: ([0-9]+) of 800 steps .*/\1/p' resumed.log)
[ -n "$common" ] && [ "$common" -gt 0 ] && [ "$common" -lt "$latest" ] || fail "it went on from step '$common', not before $latest"
[ "$(figures resumed.log)" = "$(figures whole.log)" ] || fail "the resumed run has other figures: $(cat whole.log)"
[ -z "$(ls saved)" ] || fail "checkpoints were left behind"

# Figures that could not be written are to be had again.
mkdir kept
if timeout 100 "$program" --sites 300 --time 2 --checkpoint 5 --output "$folder/kept" >/dev/full 2>full.log; then fail "lost figures went unnoticed"; fi
grep -q "its text is lost" full.log || fail "$(cat full.log)"
[ -n "$(ls kept)" ] || fail "the checkpoints of lost figures were taken away"

# A run leaves a file alone that another run has written since it began.
mkdir shared
timeout 100 "$mpiexec" -n 2 "$program" --sites 100000 --dt 0.005 --time 4 --checkpoint 400 --output "$folder/shared" >shared.log 2>&1 &
launcher=$!
sleep 2
cp another shared/rank0of2-step400.checkpoint
if wait $launcher; then fail "a file of another run went unnoticed"; fi
grep -q "rank0of2-step400.checkpoint: .*another" shared.log || fail "$(cat shared.log)"
cmp another shared/rank0of2-step400.checkpoint

if timeout 100 "$mpiexec" -n 2 "$program" --sites 100 --time 1 --checkpoint 50 --output /proc >unwritable.log 2>&1; then fail "a folder that takes no file went unnoticed"; fi
grep -q "nls_mpi.*: /proc/rank.*: cannot be written" unwritable.log || fail "$(cat unwritable.log)"

if timeout 100 "$mpiexec" -n 3 "$program" --sites 100 --dt 20 --time 20 >failed.log 2>&1; then fail "a step of 20 was taken"; fi
cat failed.log
grep -q "nls_mpi: .* failed at t = 0" failed.log || fail "a step that fails did not say so"
if timeout 100 "$mpiexec" -n 3 "$program" --sites 2 >few.log 2>&1; then fail "a process without sites went unnoticed"; fi
grep -q -- "--sites: fewer than processes" few.log || fail "$(cat few.log)"
