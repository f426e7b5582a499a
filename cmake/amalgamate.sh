#!/usr/bin/env bash
# amalgamate.sh FILE: writes the whole library as one header, which needs nothing but Eigen: every header that one of those in
# include/semiexplicit itself leads to, once, where it is first included. FILE is written whole or not at all.
set -euo pipefail

if [ $# -ne 1 ] || [[ $1 = -* ]] || [ -z "$1" ]; then
  echo "usage: bash cmake/amalgamate.sh FILE" >&2
  exit 2
fi
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
output=$1
part=$output.part
if [ ! -d "$(dirname "$output")" ]; then
  echo "amalgamate.sh: there is no folder $(dirname "$output"); make it first" >&2
  exit 2
fi
for file in "$output" "$part"; do
  if [ -L "$file" ] || { [ -e "$file" ] && [ ! -f "$file" ]; }; then
    echo "amalgamate.sh: $file is no regular file and would be replaced; give another name" >&2
    exit 2
  fi
done
trap 'rm -f "$part"' EXIT

version_part() { awk -v name="SEMIEXPLICIT_VERSION_$1" '$2 == name { print $3 }' "$root/include/semiexplicit/version.hpp"; }

{
  echo "// semiexplicit $(version_part MAJOR).$(version_part MINOR).$(version_part PATCH), the whole library in one header. Made by cmake/amalgamate.sh: do not edit."
  echo "//"
  sed -e 's|^|// |' -e 's| *$||' "$root/LICENSE"
  echo
  echo "#pragma once"
  groups=$(cd "$root/include" && echo semiexplicit/*.hpp)
  awk -v include="$root/include/" -v groups="$groups" '
    function unfold(header, line) {
      if (header in seen) return
      seen[header]
      print "\n// ======== " header
      while ((status = (getline line < (include header))) > 0) {
        if (line ~ /^#include <semiexplicit\//) {
          sub(/^#include </, "", line)
          sub(/>.*/, "", line)
          unfold(line)
        } else if (line ~ /^#pragma once/) {
        } else if (line ~ /^[ \t]*#[ \t]*include[ \t]*[<"]semiexplicit/) {
          print header ": an include that is not at the beginning of its line: " line > "/dev/stderr"
          exit 1
        } else {
          print line
        }
      }
      if (status < 0) {
        print include header ": cannot be read" > "/dev/stderr"
        exit 1
      }
      close(include header)
    }
    BEGIN {
      count = split(groups, group, " ")
      for (i = 1; i <= count; ++i) unfold(group[i])
    }'
} >"$part"
mv "$part" "$output"
