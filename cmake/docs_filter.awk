# awk -v include=<folder of headers> -f docs_filter.awk PAGE.md: a page of examples/pages as Doxygen wants it. The pages
# themselves are plain Markdown, which reads well wherever it is shown.
#   title            gets the label page_<name>, and a heading below it <name>_<heading>; README.md is the main page
#   [text](name.md)  becomes a \ref to that label; the first link of a line of a list or table of README.md a \subpage
#   other files      are not part of the site: the text of the link is left, and the path behind it
#   pictures         are found by their names
#   $formula$        between \f$, a block of ```math between \f[ and \f]
#   `Name`           a class or concept of the library is linked

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

function stem(path) {
  sub(/.*\//, "", path)
  sub(/\.md$/, "", path)
  return path
}
function label(name) { return name == "README" ? "index" : "page_" name }
function anchor(name, heading) {
  heading = tolower(heading)
  gsub(/[^a-z0-9 ]/, "", heading)
  gsub(/ +/, "_", heading)
  return name "_" heading
}

# A piece of a line without code in it.
function prose(text,    out, at, close_at, end, words, target, image, hash, part) {
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
    } else if (target ~ /^[a-zA-Z_]+\.md(#.*)?$/) {
      hash = index(target, "#")
      if (hash) {
        part = substr(target, hash + 1)
        gsub(/-/, "_", part)
        out = out "[" words "](@ref " stem(substr(target, 1, hash - 1)) "_" part ")"
      } else if (main_page && first_of_line && $0 ~ /^(- |\| )/) {
        out = out "@subpage " label(stem(target)) " \"" words "\""
      } else
        out = out "[" words "](@ref " label(stem(target)) ")"
      first_of_line = 0
    } else if (target ~ /^https?:/) {
      out = out "[" words "](" target ")"
    } else {
      part = target
      gsub(/\.\.\//, "", part)
      # The text says it already where it is that path, or the name of a program that stands below.
      out = out words
      if (target ~ /\// && !(words ~ /^\001[0-9]+\001$/ && index(code[substr(words, 2) + 0], part)))
        out = out " (<tt>" part "</tt>)"
    }
    text = substr(text, close_at + 1)
  }
  return out formulas(text)
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
  name = stem(FILENAME)
  main_page = name == "README"
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
/^# / { print $0 " {#" (main_page ? "mainpage" : label(name)) "}"; next }
/^##+ / { heading = $0; sub(/^#+ /, "", heading); print $0 " {#" anchor(name, heading) "}"; next }
{ first_of_line = 1; print translated($0) }
