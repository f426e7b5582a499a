# The target `docs`: the pages of examples/pages, the READMEs of benchmarks and what the headers say, as HTML in <build>/docs/html.
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

# Formulas are drawn by MathJax: by a copy beside the pages where Debian's is installed, so that they can be read without a
# network; else by the one on the web.
find_path(MATHJAX MathJax.js PATHS /usr/share/javascript/mathjax)
if(MATHJAX)
  set(mathjax mathjax)
  set(copy_mathjax COMMAND ${CMAKE_COMMAND} -D FROM=${MATHJAX} -D TO=${docs_html}/mathjax -P ${CMAKE_CURRENT_LIST_DIR}/copy_mathjax.cmake)
else()
  set(mathjax https://cdn.jsdelivr.net/npm/mathjax@2)
endif()

# The theme is that of Debian's package doxygen-awesome-css, with the styles of docs.css after it; without the package Doxygen's
# own.
set(docs_styles ${CMAKE_CURRENT_LIST_DIR}/docs.css)
set(docs_scripts "")
set(docs_header "")
find_path(DOXYGEN_AWESOME doxygen-awesome.css PATHS /usr/share/doxygen-awesome-css)
if(DOXYGEN_AWESOME)
  list(PREPEND docs_styles ${DOXYGEN_AWESOME}/doxygen-awesome.css ${DOXYGEN_AWESOME}/doxygen-awesome-sidebar-only.css
    ${DOXYGEN_AWESOME}/doxygen-awesome-sidebar-only-darkmode-toggle.css)
  set(docs_scripts ${DOXYGEN_AWESOME}/doxygen-awesome-darkmode-toggle.js
    ${DOXYGEN_AWESOME}/doxygen-awesome-fragment-copy-button.js)
  # Doxygen's own header, with the theme's scripts.
  set(docs_header ${docs_dir}/header.html)
  file(MAKE_DIRECTORY ${docs_dir})
  execute_process(COMMAND ${DOXYGEN_EXECUTABLE} -w html header.html footer.html style.css
    WORKING_DIRECTORY ${docs_dir} OUTPUT_QUIET ERROR_QUIET)
  file(READ ${docs_header} header)
  set(scripts "")
  foreach(script IN LISTS docs_scripts)
    cmake_path(GET script FILENAME script)
    string(APPEND scripts "<script type=\"text/javascript\" src=\"$relpath^${script}\"></script>\n")
  endforeach()
  string(APPEND scripts "<script type=\"text/javascript\">DoxygenAwesomeDarkModeToggle.init(); "
    "DoxygenAwesomeFragmentCopyButton.init();</script>\n")
  string(REPLACE "</head>" "${scripts}</head>" header "${header}")
  file(WRITE ${docs_header} "${header}")
endif()

# Doxygen runs the filter by a shell, and in the folder where it was started.
configure_file(${CMAKE_CURRENT_LIST_DIR}/docs_filter.sh.in ${docs_dir}/docs_filter.sh @ONLY)
file(GLOB docs_benchmarks CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/benchmarks/*/*.md)
foreach(list IN ITEMS docs_styles docs_scripts docs_benchmarks)
  string(REPLACE ";" "\" \"" ${list} "\"${${list}}\"")
endforeach()
configure_file(${CMAKE_CURRENT_LIST_DIR}/Doxyfile.in ${docs_dir}/Doxyfile @ONLY)
add_custom_target(docs
  COMMAND ${CMAKE_COMMAND} -E rm -rf ${docs_html}
  COMMAND Doxygen::doxygen ${docs_dir}/Doxyfile
  ${copy_mathjax}
  WORKING_DIRECTORY ${docs_dir}
  COMMENT "Documentation: ${docs_html}/index.html"
  VERBATIM)
