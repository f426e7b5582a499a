# shellcheck shell=bash
# Sourced by the scripts beside it: stage messages on stderr, with the time since the start, and the name of the stage
# that failed. Leaves the caller in the project's root.

cd "$(dirname "${BASH_SOURCE[0]}")/.." || exit

current_stage="start"

stage() {
  current_stage=$1
  printf '\n== %s (at %dm%02ds)\n' "$1" $((SECONDS / 60)) $((SECONDS % 60)) >&2
}

report_end() {
  local code=$?
  if [ "$code" -eq 0 ]; then
    printf '\n== done in %dm%02ds\n' $((SECONDS / 60)) $((SECONDS % 60)) >&2
  else
    printf '\n== FAILED (exit code %d) in stage: %s\n' "$code" "$current_stage" >&2
  fi
}
trap report_end EXIT
