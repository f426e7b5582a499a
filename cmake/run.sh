#!/usr/bin/env bash
# run.sh [OPTION...]: the NLS lattice to T = 1000 with four methods side by side, as a table and a picture in out/.
# Installs what is missing and builds what is needed; options go to the program (see build/release/examples/nls --help).
set -euo pipefail
# shellcheck source=cmake/stage.sh
source "$(dirname "${BASH_SOURCE[0]}")/stage.sh"

stage "Dependencies"
bash cmake/install-dependencies.sh run

stage "Build (Release)"
cmake --preset release >&2
cmake --build --preset release --parallel "$(nproc)" --target nls >&2

stage "NLS lattice, four methods"
if [ $# -gt 0 ]; then # with options of its own the program says itself what it leaves, and where
  exec build/release/examples/nls --compare "$@"
fi
picture=out/nls_comparison.png
mkdir -p out
rm -f "$picture"
build/release/examples/nls --compare --output out

if [ ! -s "$picture" ]; then
  echo "The program ended well but left no picture at $picture." >&2
  exit 1
fi
echo "The picture: $PWD/$picture"
