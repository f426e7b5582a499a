#!/usr/bin/env bash
# other_compilers.sh libc++|aarch64|mingw: the tests of the core built by clang++ with libc++, or by g++ for 64-bit ARM and run
# under qemu; or every header compiled by MinGW's g++ for Windows. Needs Debian or Ubuntu, and a minute or more.
set -euo pipefail
# shellcheck source=cmake/stage.sh
source "$(dirname "${BASH_SOURCE[0]}")/stage.sh"

usage() {
  current_stage="arguments"
  echo "usage: bash cmake/other_compilers.sh libc++|aarch64|mingw" >&2
  exit 2
}
[ $# -eq 1 ] || usage

folder=build/other-$1
flags=(-std=c++20 -O1 -Wall -Wextra -Wpedantic -Wshadow -Werror -I include -I tests -isystem /usr/include/eigen3)
# The headers of Boost and Catch2 alone: all of /usr/include would be another machine's.
mkdir -p "$folder/headers"
for name in boost catch2; do ln -sfn "/usr/include/$name" "$folder/headers/$name"; done
flags+=(-isystem "$folder/headers")

stage "Dependencies"
case $1 in
  libc++)
    bash cmake/install-dependencies.sh libc++
    compiler=(clang++ -stdlib=libc++)
    run=()
    ;;
  aarch64)
    bash cmake/install-dependencies.sh aarch64
    compiler=(aarch64-linux-gnu-g++ -static)
    run=(qemu-aarch64)
    ;;
  mingw)
    bash cmake/install-dependencies.sh mingw
    compiler=(x86_64-w64-mingw32-g++-posix -Wa,-mbig-obj) # with <mutex>
    ;;
  *) usage ;;
esac

if [ "$1" = mingw ]; then
  stage "Every header"
  for header in include/semiexplicit/*.hpp; do
    echo "#include \"$header\"" >"$folder/header.cpp"
    "${compiler[@]}" "${flags[@]}" -I . -fsyntax-only "$folder/header.cpp"
  done
  stage "A program"
  "${compiler[@]}" "${flags[@]}" -static examples/quickstart.cpp -o "$folder/quickstart.exe"
  exit
fi

stage "Build"
"${compiler[@]}" "${flags[@]}" -c tests/main.cpp -o "$folder/main.o"
for tests in schemes solvers steppers core; do
  find "tests/$tests" -name 'test_*.cpp' | sort | sed 's|.*|#include "../../&"|' >"$folder/$tests.cpp"
  "${compiler[@]}" "${flags[@]}" "$folder/$tests.cpp" "$folder/main.o" -o "$folder/test_$tests"
  stage "Test: $tests"
  "${run[@]}" "$folder/test_$tests" "~[.]~[long]"
done
