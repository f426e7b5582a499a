#!/usr/bin/env bash
# kill.sh [KILLS [SEED]]: runs programs that are killed (kill -9) KILLS times, 50 unless told otherwise, at random moments and go on
# from their checkpoints, and compares what they leave with uninterrupted runs, byte for byte; see tests/examples/killed.sh.
set -euo pipefail
# shellcheck source=../../cmake/stage.sh
source "$(dirname "${BASH_SOURCE[0]}")/../../cmake/stage.sh"
kills=${1:-50} seed=${2:-random}

stage "Dependencies"
bash cmake/install-dependencies.sh run
stage "Build (Release)"
cmake --preset release >&2
cmake --build --preset release --parallel "$(nproc)" --target nls orbits >&2

stage "Killing"
survives() { # NAME EVERY PROGRAM [ARGUMENT...]
  bash tests/examples/killed.sh "$PWD/build/release/killed/$1" "$seed" "$kills" "$2" "$PWD/build/release/examples/$3" "${@:4}"
}
survives nls 100000 nls --time 400000
survives nls_gauss 100000 nls --time 100000 --method gauss
survives orbits 20000 orbits --time 3000year --samples 200000
