# cmake -D FROM=<MathJax 2> -D TO=<folder> -P copy_mathjax.cmake: the parts of it that Doxygen's pages load.
foreach(part IN ITEMS MathJax.js extensions jax/element jax/input/TeX jax/output/HTML-CSS fonts/HTML-CSS/TeX)
  cmake_path(GET part PARENT_PATH folder)
  file(COPY ${FROM}/${part} DESTINATION ${TO}/${folder} FOLLOW_SYMLINK_CHAIN)
endforeach()
