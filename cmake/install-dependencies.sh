#!/usr/bin/env bash
# install-dependencies.sh run|test|check|format|docs|benchmark|libc++|aarch64|mingw...: installs what these tasks need and this machine lacks. Where all is there
# it does nothing and needs no rights.
set -euo pipefail

# Debian's name of each package, and why it is needed.
declare -A purpose=(
  [g++]="the C++20 compiler, with concepts (g++ 12 and clang 14 are tested)"
  [cmake]="configures the build (3.22 or later)"
  [ninja-build]="runs the build; CMakePresets.json names it"
  [libeigen3-dev]="Eigen 3.4 or later, the one dependency of the library itself"
  [libcli11-dev]="CLI11, the command lines of the example programs"
  [gnuplot-nox]="gnuplot, which the example programs call to draw their pictures"
  [catch2]="Catch2 2 or 3, the test framework"
  [pkg-config]="asks for the flags that an installed library wants; its file is tested"
  [libboost-dev]="Boost headers: numbers and reference functions of the tests, integrators of the benchmark"
  [libsundials-dev]="SUNDIALS, whose integrators the benchmark compares with"
  [libgsl-dev]="the GNU Scientific Library, whose integrators the benchmark compares with"
  [libopenmpi-dev]="Open MPI, for the example that runs on many machines"
  [openmpi-bin]="its mpirun"
  [libhdf5-dev]="HDF5, the format of that example's results"
  [libomp-dev]="OpenMP for clang; g++ has its own"
  [clang]="the second compiler that everything must pass, and the quicker one for the tests"
  [lld]="its linker, which links the tests in half the time"
  [libclang-rt-14-dev]="the run-time part of its sanitizers"
  [libc++-dev]="the other C++ library of clang"
  [libc++abi-dev]="its run-time part"
  [g++-aarch64-linux-gnu]="the compiler for 64-bit ARM"
  [qemu-user]="runs its programs here"
  [g++-mingw-w64-x86-64]="a compiler for Windows"
  [clang-format]="checks the formatting"
  [doxygen]="makes the documentation, from examples/pages and the headers"
  [doxygen-awesome-css]="the theme of the documentation"
  [libjs-mathjax]="MathJax, which draws the formulas of the documentation without a network"
)
# The program by which a package is recognised, wherever it comes from; libraries are asked of dpkg.
declare -A program=(
  [g++]=g++ [cmake]=cmake [ninja-build]=ninja [gnuplot-nox]=gnuplot [clang]=clang++ [lld]=ld.lld [clang-format]=clang-format
  [pkg-config]=pkg-config [g++-aarch64-linux-gnu]=aarch64-linux-gnu-g++ [qemu-user]=qemu-aarch64
  [g++-mingw-w64-x86-64]=x86_64-w64-mingw32-g++-posix [doxygen]=doxygen [openmpi-bin]=mpirun
)

packages=()
for task in "$@"; do
  case $task in
    run) packages+=(g++ cmake ninja-build libeigen3-dev libcli11-dev gnuplot-nox) ;;
    test)
      packages+=(g++ clang lld cmake ninja-build libeigen3-dev libcli11-dev catch2 libboost-dev libomp-dev libopenmpi-dev openmpi-bin libhdf5-dev)
      ;;
    benchmark) packages+=(g++ cmake ninja-build libeigen3-dev libcli11-dev gnuplot-nox libboost-dev libgsl-dev libsundials-dev) ;;
    libc++) packages+=(clang libc++-dev libc++abi-dev libeigen3-dev catch2 libboost-dev) ;;
    aarch64) packages+=(g++-aarch64-linux-gnu qemu-user libeigen3-dev catch2 libboost-dev) ;;
    mingw) packages+=(g++-mingw-w64-x86-64 libeigen3-dev libboost-dev) ;;
    check) packages+=(clang libclang-rt-14-dev libgsl-dev libsundials-dev pkg-config) ;;
    format) packages+=(clang-format) ;;
    docs) packages+=(g++ cmake ninja-build libeigen3-dev doxygen doxygen-awesome-css libjs-mathjax) ;;
    *)
      echo "install-dependencies.sh: unknown task '$task'; give run, test, check, format, docs, benchmark, libc++, aarch64 or mingw" >&2
      exit 2
      ;;
  esac
done

has_apt() { command -v apt-get >/dev/null && command -v dpkg-query >/dev/null; }

is_here() {
  if [ -n "${program[$1]:-}" ]; then
    command -v "${program[$1]}" >/dev/null
  elif has_apt; then
    [ "$(dpkg-query --show --showformat='${db:Status-Status}' "$1" 2>/dev/null)" = installed ]
  else
    true # CMake will look for it, and say so if it is not there
  fi
}

mapfile -t packages < <(printf '%s\n' "${packages[@]}" | sort --unique)
missing=()
for package in "${packages[@]}"; do
  is_here "$package" || missing+=("$package")
done
[ ${#missing[@]} -gt 0 ] || exit 0

if ! has_apt; then
  echo "This system has no apt-get, so please install by its own means (under Debian's names):" >&2
  for package in "${packages[@]}"; do
    state="not looked for here"
    if [ -n "${program[$package]:-}" ]; then
      state="missing"
      if is_here "$package"; then state="here"; fi
    fi
    printf '  %-14s %s: %s\n' "$package" "${purpose[$package]}" "$state" >&2
  done
  exit 1
fi

install=(apt-get install --yes --quiet --no-install-recommends "${missing[@]}")
give_up() {
  echo "$1 Please run as root, then start again:" >&2
  echo "  apt-get update && ${install[*]}" >&2
  exit 1
}

as_root=(env DEBIAN_FRONTEND=noninteractive)
if [ "$(id -u)" -ne 0 ]; then
  command -v sudo >/dev/null || give_up "Packages are missing, and there is no sudo to install them with."
  as_root=(sudo "${as_root[@]}")
fi

echo "Installing: ${missing[*]}" >&2
"${as_root[@]}" apt-get update --quiet >&2 || echo "apt-get update failed; trying with the lists at hand" >&2
"${as_root[@]}" "${install[@]}" >&2 || give_up "Installing failed."
