#!/usr/bin/env bash
# test.sh [--programs | --long | --warnings | --all]: installs what is missing, builds the tests of the library by clang++ and
# runs them; with --programs, those of the bundled programs and of the pages, by g++, and the formatting; with --long, those of
# the library that go through the same code with many methods or for long; with --warnings, everything is read by g++ with its
# warnings as errors. --all does the rest: tests of methods, runs and ensembles, some programs and benchmarks by g++, packages,
# the compilers' messages, the documentation, and the tests by clang++ with the address and undefined-behaviour sanitizers.
set -euo pipefail
# shellcheck source=cmake/stage.sh
source "$(dirname "${BASH_SOURCE[0]}")/stage.sh"

preset=test
case "$*" in
  "") ;;
  --programs) preset=programs ;;
  --long) preset=long ;;
  --warnings | --all) preset= ;;
  *)
    current_stage="arguments"
    echo "usage: bash cmake/test.sh [--programs | --long | --warnings | --all]" >&2
    exit 2
    ;;
esac

# Configures and builds one preset of CMakePresets.json.
build() {
  stage "$1: configure"
  cmake --preset "$1"
  stage "$1: build"
  cmake --build --preset "$1" --parallel "$(nproc)"
}

build_and_test() {
  build "$1"
  stage "$1: test"
  ctest --preset "$1" --parallel "$(nproc)"
}

check_format() {
  local formatter=clang-format
  if command -v clang-format-14 >/dev/null; then formatter=clang-format-14; fi
  if ! "$formatter" --version | grep -q 'version 14\.'; then
    echo "skipped: versions format differently, this project's is 14, and here is $("$formatter" --version)" >&2
    return
  fi
  find include tests examples benchmarks \( -name '*.hpp' -o -name '*.cpp' \) -print0 |
    xargs -0 "$formatter" --dry-run --Werror
}

stage "Dependencies"
bash cmake/install-dependencies.sh test
if [ "$*" = --programs ]; then
  bash cmake/install-dependencies.sh format
  stage "Formatting"
  check_format
fi
if [ -n "$preset" ]; then
  build_and_test "$preset"
  exit
fi
bash cmake/install-dependencies.sh check
if [ "$*" = --warnings ]; then
  build warnings
  exit
fi
build_and_test gcc
stage "Documentation"
bash cmake/docs.sh
build_and_test asan
