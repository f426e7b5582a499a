# The components of find_package(semiexplicit COMPONENTS ...): a target semiexplicit::<component> for each kind of header
# that needs more than Eigen. A new one is a name in this list, and what it stands for below.
set(semiexplicit_components boost openmp)

# semiexplicit_find_component(<component> <target> <complaint>): finds what a component needs and sets <target> to it; where
# that is not to be had, <target> is empty and <complaint> says what to do.
function(semiexplicit_find_component component target complaint)
  if(component STREQUAL "boost") # compat/odeint.hpp, and multiprecision numbers
    find_package(Boost QUIET)
    set(needs Boost::headers)
    set(remedy "the headers of Boost (Debian, Ubuntu: apt-get install libboost-dev)")
  elseif(component STREQUAL "openmp") # ensembles and large systems on all cores
    find_package(OpenMP QUIET COMPONENTS CXX)
    set(needs OpenMP::OpenMP_CXX)
    set(remedy "OpenMP (g++ brings it along; for clang++ apt-get install libomp-dev), and the language CXX enabled")
  else()
    list(JOIN semiexplicit_components ", " known)
    set(${target} "" PARENT_SCOPE)
    set(${complaint} "it has no component '${component}'; the components are ${known}" PARENT_SCOPE)
    return()
  endif()
  set(${target} ${needs} PARENT_SCOPE)
  set(${complaint} "" PARENT_SCOPE)
  if(NOT TARGET ${needs})
    set(${target} "" PARENT_SCOPE)
    set(${complaint} "its component ${component} needs ${remedy}" PARENT_SCOPE)
  endif()
endfunction()
