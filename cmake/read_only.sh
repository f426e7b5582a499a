#!/usr/bin/env bash
# read_only.sh COMPILER [ARGUMENT...]: compiles for the errors and warnings alone, which takes half the time of unoptimised code.
# The object file is an empty one, so that the build knows what it has done.
set -euo pipefail
object="" before=""
for argument in "$@"; do
  if [ "$before" = -o ]; then object=$argument; fi
  before=$argument
done
case " $* " in
  *" c++-header "*) exec "$@" ;; # what the others read is needed
esac
"$@" -fsyntax-only
: >"$object"
