#!/usr/bin/env bash
# run.sh [OPTION...]: all tables and figures of the paper, published values beside ours, in out/paper. Installs what is
# missing and builds what is needed, shows a progress bar, and goes on where it was interrupted. Options go to the program
# (see build/release/benchmarks/bench_paper --help).
set -euo pipefail
# shellcheck source=cmake/stage.sh
source "$(dirname "${BASH_SOURCE[0]}")/../../cmake/stage.sh"

stage "Dependencies"
bash cmake/install-dependencies.sh run

stage "Build (Release)"
cmake --preset release >&2
cmake --build --preset release --parallel "$(nproc)" --target bench_paper >&2

stage "Tables and figures of the paper"
build/release/benchmarks/bench_paper --output out/paper "$@"
