#!/usr/bin/env bash
# docs.sh: installs what is missing and builds the documentation, build/docs/docs/html/index.html. A warning of Doxygen is an
# error.
set -euo pipefail
if [ $# -gt 0 ]; then
  echo "usage: bash cmake/docs.sh" >&2
  [ "$*" = --help ] || exit 2
  exit 0
fi
cd "$(dirname "${BASH_SOURCE[0]}")/.."

bash cmake/install-dependencies.sh docs
cmake -S . -B build/docs -G Ninja -D SEMIEXPLICIT_BUILD_TESTS=OFF -D SEMIEXPLICIT_BUILD_EXAMPLES=OFF \
  -D SEMIEXPLICIT_BUILD_BENCHMARKS=OFF >&2
cmake --build build/docs --target docs >&2

# What Doxygen did not understand it may also pass on as it is, without a warning.
html=build/docs/docs/html
if grep --line-number '\\ilinebr\|@ref \|@subpage \|\\f[$[]' "$html"/page_*.html "$html"/index.html; then
  echo "docs.sh: in these lines Doxygen left its own commands in the page (a ' between backquotes does that)" >&2
  exit 1
fi

# A name of the library that stands in a text and leads nowhere is one that has changed.
names=$(sed -e '/<div class="fragment">/,/<!-- fragment -->/d; /<pre/,/<\/pre>/d; /class="ttc"/d' \
  -e 's|<a [^>]*>[^<]*</a>||g; s|<code>[^<]*</code>||g' "$html"/page_*.html "$html"/index.html | grep -o 'semiexplicit::[A-Za-z_:]*' || true)
if [ -n "$names" ]; then
  echo "docs.sh: pages speak of what is not there: ${names//$'\n'/, }" >&2
  exit 1
fi
echo "The documentation: $PWD/$html/index.html"
