#!/usr/bin/env bash
# killed.sh FOLDER SEED KILLS EVERY PROGRAM [ARGUMENT...]
#
# Runs PROGRAM in FOLDER to its end, and again with a checkpoint after EVERY steps, killed (kill -9) at KILLS random moments and
# started anew after each; SEED is a number, or random. Fails unless all files and all that is printed are the same in the end, byte for byte but for the
# seconds, unless each start goes on from a multiple of EVERY that is no earlier than that of the start before it, and unless
# some of them did go on. EVERY is 0 for a program that saves piece by piece, in a folder.
set -euo pipefail
folder=$1 seed=$2 kills=$3 every=$4
shift 4
[ "$seed" != random ] || seed=$RANDOM
RANDOM=$seed
rm -rf "$folder"
mkdir -p "$folder"
cd "$folder"
fail() {
  echo "seed $seed: $1" >&2
  exit 1
}

begin=$(date +%s%N)
"$@" --no-plot --output whole >whole.txt
took=$((($(date +%s%N) - begin) / 1000)) # microseconds

saving=(--checkpoint run.checkpoint)
[ "$every" -eq 0 ] || saving+=(--checkpoint-every "$every")
start() { exec "$@" --no-plot --output killed "${saving[@]}" >killed.txt; }
saved() { compgen -G 'run.checkpoint*' >/dev/null; }
useful() { if [ "$every" -eq 0 ]; then compgen -G 'run.checkpoint*/*.block' >/dev/null; else [ -e run.checkpoint ]; fi; } # to go on from
gone_on=0 reached=0
look() { # where the last start went on from
  local step
  [ -e killed.txt ] || return 0
  step=$(sed -n 's/^goes on from .*, [a-z]* \([0-9]*\)$/\1/p' killed.txt)
  [ -n "$step" ] || return 0
  [ $((step % (every > 0 ? every : 1))) -eq 0 ] && [ "$step" -ge "$reached" ] || fail "went on from step $step after $reached"
  gone_on=$((gone_on + 1)) reached=$step
}
done_kills=0 code=0
end_start() { # kills the start $child, which may have ended
  kill -9 "$child" 2>/dev/null || true
  code=0
  wait "$child" 2>/dev/null || code=$?
  look
  case $code in
    0) ;; # it was faster
    137) done_kills=$((done_kills + 1)) ;;
    *) fail "a start ended with exit code $code" ;;
  esac
}
for ((attempt = 0; attempt < kills; ++attempt)); do
  start "$@" & # which becomes the program itself, so that the kill meets it and not a shell
  child=$!
  # A share of the whole run that lets about three quarters of the kills fall before its end.
  delay=$((took * (RANDOM % 1000 + 1) * 3 / (2000 * kills)))
  sleep "$(printf '%d.%06d' $((delay / 1000000)) $((delay % 1000000)))"
  end_start
  [ "$code" -ne 0 ] || break
done
if [ ! -e killed ] || saved || [ "$done_kills" -eq "$kills" ]; then
  (start "$@")
  look
fi
# On a busy machine all of these may fall before the first checkpoint or after the end: then anew, killed at a checkpoint.
for ((attempt = 0; gone_on == 0 && attempt < 20; ++attempt)); do
  rm -rf killed killed.txt run.checkpoint*
  reached=0
  start "$@" &
  child=$!
  until useful || ! kill -0 "$child" 2>/dev/null; do sleep 0.001; done
  end_start
  (start "$@")
  look
done

same() { grep -vE '^(goes on from|seconds|data:) ?' "$1"; }
diff <(same whole.txt) <(same killed.txt) || fail "the output differs"
rm -f killed/*.part.[0-9]* # rows of starts that were killed before they were saved
diff -r whole killed || fail "the files differ"
! saved || fail "the checkpoint was left behind"
[ "$gone_on" -gt 0 ] || fail "no start went on from a checkpoint"
echo "seed $seed: $done_kills kills, $gone_on starts went on, the last from step $reached; all files the same"
