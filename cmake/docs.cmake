# The target `docs`: the pages of examples/pages and what the headers say, as HTML in <build>/docs/html.
find_package(Doxygen 1.9 QUIET)
if(NOT DOXYGEN_FOUND)
  return()
endif()

set(docs_dir ${PROJECT_BINARY_DIR}/docs)
set(docs_html ${docs_dir}/html)

# Each version warns of other things; this project's is that of Debian 12, 1.9.4.
set(warn_as_error FAIL_ON_WARNINGS)
if(DOXYGEN_VERSION VERSION_GREATER_EQUAL 1.10)
  set(warn_as_error NO)
endif()

# The table of contents is the pages there are, in the order of their file names.
file(GLOB pages CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/examples/pages/*.md)
set(contents "")
foreach(page IN LISTS pages)
  file(STRINGS ${page} title LIMIT_COUNT 1 ENCODING UTF-8)
  if(NOT title MATCHES "^# .+ {#(page_[a-z_]+)}$")
    message(FATAL_ERROR "${page} does not begin with a line '# Title {#page_name}'.")
  endif()
  string(APPEND contents "- \\subpage ${CMAKE_MATCH_1}\n")
endforeach()
configure_file(${CMAKE_CURRENT_LIST_DIR}/docs_main.md.in ${docs_dir}/main.md @ONLY)

# Formulas are drawn by MathJax: by a copy beside the pages where Debian's is installed, so that they can be read without a
# network; else by the one on the web.
find_path(MATHJAX MathJax.js PATHS /usr/share/javascript/mathjax)
if(MATHJAX)
  set(mathjax mathjax)
  set(copy_mathjax COMMAND ${CMAKE_COMMAND} -D FROM=${MATHJAX} -D TO=${docs_html}/mathjax -P ${CMAKE_CURRENT_LIST_DIR}/copy_mathjax.cmake)
else()
  set(mathjax https://cdn.jsdelivr.net/npm/mathjax@2)
endif()

string(REPLACE ";" "\" \"" docs_input "\"${docs_dir}/main.md;${pages};${PROJECT_SOURCE_DIR}/include\"")
configure_file(${CMAKE_CURRENT_LIST_DIR}/Doxyfile.in ${docs_dir}/Doxyfile @ONLY)
add_custom_target(docs
  COMMAND ${CMAKE_COMMAND} -E rm -rf ${docs_html}
  COMMAND Doxygen::doxygen ${docs_dir}/Doxyfile
  ${copy_mathjax}
  COMMENT "Documentation: ${docs_html}/index.html"
  VERBATIM)
