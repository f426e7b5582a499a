#!/usr/bin/env bash
# fuzz.sh [SECONDS [HARNESS...]]: fuzzes what reads input from outside, 900 seconds each unless told otherwise, one after the other:
# the harnesses in tests/fuzz, by clang++'s libFuzzer under the address and undefined-behaviour sanitizers. Inputs that find
# something are left in build/fuzz; put them into tests/fuzz/seeds, where the ordinary tests go through them, too.
set -euo pipefail
# shellcheck source=cmake/stage.sh
source "$(dirname "${BASH_SOURCE[0]}")/stage.sh"

seconds=${1:-900}
if ! [[ $seconds =~ ^[1-9][0-9]*$ ]]; then
  echo "usage: bash cmake/fuzz.sh [SECONDS [HARNESS...]]" >&2
  current_stage="arguments"
  [ "$seconds" = --help ] || exit 2
  exit 0
fi
shift || true
harnesses=("$@")
[ ${#harnesses[@]} -gt 0 ] || harnesses=(vortex_file arguments checkpoint)

stage "Dependencies"
bash cmake/install-dependencies.sh run check
compiler=clang++
if command -v clang++-14 >/dev/null; then compiler=clang++-14; fi

mkdir -p build/fuzz
for harness in "${harnesses[@]}"; do
  stage "$harness: build"
  nice "$compiler" -std=c++20 -O1 -g1 -fsanitize=fuzzer,address,undefined -fno-sanitize-recover=all -D_GLIBCXX_ASSERTIONS \
    -Iinclude -Iexamples -isystem /usr/include/eigen3 "tests/fuzz/$harness.cpp" -o "build/fuzz/$harness"
  stage "$harness: $seconds seconds"
  mkdir -p "build/fuzz/corpus/$harness"
  nice "build/fuzz/$harness" -max_total_time="$seconds" -max_len=2048 -print_final_stats=1 -dict=tests/fuzz/options.dict \
    -artifact_prefix="build/fuzz/$harness-" "build/fuzz/corpus/$harness" "tests/fuzz/seeds/$harness" >"build/fuzz/$harness.log" 2>&1 || {
    tail -n 30 "build/fuzz/$harness.log" >&2
    exit 1
  }
  grep -E "^Done|stat::(number|average|new)" "build/fuzz/$harness.log"
done
