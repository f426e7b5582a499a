# awk -v include=<folder of headers> -f docs_filter.awk PAGE.md: a page of examples/pages, or a README of benchmarks, as Doxygen
# wants it. The pages themselves are plain Markdown, which reads well wherever it is shown.
#   title            gets the label page_<name>, and a heading below it <name>_<heading>; README.md of the pages is the main page
#   [text](name.md)  becomes a \ref to that label. The site's tree is made of the first links of the rows of the table of the
#                    main page, and of the last ones of benchmarks.md: they become a \subpage
#   other files      are not part of the site: the text of the link is left
#   pictures         are found by their names
#   $formula$        between \f$, a block of ```math between \f[ and \f]
#   `Name`           a class or concept of the library is linked, and some of its functions

BEGIN {
  command = "find '" include "' -name '*.hpp' -exec cat {} +"
  depth = 0
  while ((command | getline line) > 0) {
    if (line ~ /^namespace [a-z_:]+ \{/) {
      split(line, word, " ")
      scope[++depth] = word[2]
    } else if (line ~ /^} *\/\/ namespace/) {
      --depth
    } else if (line ~ /^(class|struct|concept|enum class) [A-Z][A-Za-z0-9]*( |$)/) {
      split(line, word, " ")
      learn(word[1] == "enum" ? word[3] : word[2])
    }
  }
  close(command)
  # Functions that the pages speak of; one that is not there any more is an error of Doxygen's.
  split("audit at_times check_gradient compose cost_of_accuracy every from_energy integrate make_hamiltonian make_scheme " \
        "poincare_section stepper_for with_stepper_for", word, " ")
  for (i in word) known[word[i]] = "semiexplicit::" word[i]
}

# Notes a name under all that a page may call it: Name, orbits::Name, ...
function learn(name,    i, whole, called) {
  whole = name
  for (i = depth; i > 0; --i) {
    if (scope[i] ~ /detail/) return
    whole = scope[i] "::" whole
  }
  called = name
  for (i = depth; i > 0; --i) {
    if ((called in known) && known[called] != whole) known[called] = ""
    else known[called] = whole
    called = scope[i] "::" called
  }
}

# The name of a page by its path: README of the main page, benchmark_<folder>, benchmark_<folder>_<file>, or the file's.
function page_name(path,    folder) {
  sub(/\.md$/, "", path)
  if (match(path, /benchmarks\/[a-z_]+\//)) {
    folder = substr(path, RSTART + 11, RLENGTH - 12)
    path = substr(path, RSTART + RLENGTH)
    return "benchmark_" folder (path == "README" ? "" : "_" path)
  }
  sub(/.*\//, "", path)
  return path
}
# Where a link of this page leads, from the top folder.
function from_top(target,    folder) {
  folder = FILENAME
  sub(/.*\/examples\//, "examples/", folder)
  sub(/.*\/benchmarks\//, "benchmarks/", folder)
  sub(/[^\/]*$/, "", folder)
  while (target ~ /^\.\.\//) {
    sub(/[^\/]*\/$/, "", folder)
    target = substr(target, 4)
  }
  return folder target
}
function is_page(path) {
  return path ~ /^examples\/pages\/[a-zA-Z_]+\.md$/ || path ~ /^benchmarks\/[a-z_]+\/(README|cluster)\.md$/
}
function label(name) { return name == "README" ? "index" : "page_" name }
function anchor(name, heading) {
  heading = tolower(heading)
  gsub(/[^a-z0-9 ]/, "", heading)
  gsub(/ +/, "_", heading)
  return name "_" heading
}

# A piece of a line without code in it.
function prose(text,    out, at, close_at, end, words, target, image, hash, part, path) {
  out = ""
  while ((at = index(text, "](")) > 0) {
    close_at = at + index(substr(text, at), ")") - 1
    target = substr(text, at + 2, close_at - at - 2)
    # Where the text of the link begins; pieces of code in it have been put away.
    for (end = at - 1; end > 0 && substr(text, end, 1) != "["; --end) continue
    words = substr(text, end + 1, at - end - 1)
    image = end > 1 && substr(text, end - 1, 1) == "!"
    out = out formulas(substr(text, 1, end - 1))
    if (image) {
      part = target
      sub(/.*\//, "", part)
      out = out "[" words "](" part ")"
    } else if (target ~ /^https?:/) {
      out = out "[" words "](" target ")"
    } else {
      hash = index(target, "#")
      part = hash ? substr(target, hash + 1) : ""
      path = from_top(hash ? substr(target, 1, hash - 1) : target)
      if (!is_page(path)) {
        out = out words
      } else if (hash) {
        gsub(/-/, "_", part)
        out = out "[" words "](@ref " page_name(path) "_" part ")"
      } else if (in_tree(path)) {
        out = out "@subpage " label(page_name(path)) " \"" words "\""
      } else {
        out = out "[" words "](@ref " label(page_name(path)) ")"
      }
      first_of_line = 0
    }
    text = substr(text, close_at + 1)
  }
  return out formulas(text)
}
function in_tree(path) {
  if ($0 !~ /^\| /) return 0
  return name == "README" ? first_of_line : name == "benchmarks" && path ~ /^benchmarks/
}
function formulas(text) {
  gsub(/\$/, "\\f$", text)
  return text
}

# A line: code between backquotes is put away, the rest is translated.
function translated(text,    out, at, n, piece) {
  n = 0
  out = ""
  while ((at = index(text, "`")) > 0) {
    piece = substr(text, at + 1)
    if (index(piece, "`") == 0) break
    code[++n] = substr(piece, 1, index(piece, "`") - 1)
    out = out substr(text, 1, at - 1) "\001" n "\001"
    text = substr(piece, index(piece, "`") + 1)
  }
  out = prose(out text)
  for (; n > 0; --n) {
    piece = code[n]
    if ((piece in known) && known[piece] != "" && out !~ ("\\[\001" n "\001\\]"))
      piece = "<tt>@ref " known[piece] " \"" piece "\"</tt>"
    else
      piece = "`" piece "`"
    gsub(/[\\&]/, "\\\\&", piece)
    sub("\001" n "\001", piece, out)
  }
  return out
}

FNR == 1 {
  name = page_name(FILENAME)
}
/^```/ {
  if (!fenced) {
    fenced = 1
    math = /^```math/
    print math ? "\\f[" : $0
  } else {
    print math ? "\\f]" : $0
    fenced = math = 0
  }
  next
}
fenced { print; next }
/^# / { print $0 " {#" (name == "README" ? "mainpage" : label(name)) "}"; next }
/^##+ / { heading = $0; sub(/^#+ /, "", heading); print $0 " {#" anchor(name, heading) "}"; next }
{ first_of_line = 1; print translated($0) }
