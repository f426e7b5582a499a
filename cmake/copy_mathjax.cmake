# cmake -D FROM=<MathJax 2> -D TO=<folder> -P copy_mathjax.cmake: what the pages load of it, a few megabytes of fifty.
set(math MathJax.js config/TeX-MML-AM_CHTML.js config/TeX-AMS-MML_HTMLorMML.js extensions jax fonts localization/en)
foreach(part IN LISTS math)
  file(REAL_PATH ${FROM}/${part} real)
  cmake_path(GET part PARENT_PATH folder)
  file(COPY ${real} DESTINATION ${TO}/${folder})
endforeach()
