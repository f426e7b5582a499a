#!/usr/bin/env bash
# amalgamate.sh SCRIPT FOLDER: cmake/amalgamate.sh, run in FOLDER, replaces files and nothing else.
set -euo pipefail

script=$1
rm -rf "$2"
mkdir -p "$2/folder"
cd "$2"
fail() {
  echo "$1" >&2
  exit 1
}

echo old >target
ln -s target link
ln -s target linked.part
mkfifo pipe
for name in link pipe folder linked; do
  if bash "$script" "$name" 2>said; then fail "$name is replaced"; fi
  grep -q 'is no regular file and would be replaced; give another name' said || fail "$name: $(cat said)"
done
[ -L link ] && [ -L linked.part ] && [ -p pipe ] || fail "something is gone"
[ "$(cat target)" = old ] || fail "what a link leads to was written to"
[ -z "$(ls folder)" ] || fail "something was put into the folder"

bash "$script" target
grep -q 'the whole library in one header' target || fail "a file is not replaced"
