# What the project's own tests and programs are compiled with; nothing here reaches a program that uses the library.
option(SEMIEXPLICIT_DEVELOPER_WARNINGS "Compile the tests and programs with many warnings, as errors" OFF)
option(SEMIEXPLICIT_SANITIZE "Compile the tests and programs with the address and undefined-behaviour sanitizers" OFF)
option(SEMIEXPLICIT_TEST_COMPILERS "Test packages, every header alone and the compilers' messages, too: some minutes more" ON)
set(SEMIEXPLICIT_TEST_PART all CACHE STRING
  "What is tested: all, library, programs (with the pages), what is worth a second compiler, or the long tests")
set_property(CACHE SEMIEXPLICIT_TEST_PART PROPERTY STRINGS all library programs second long)
option(SEMIEXPLICIT_NATIVE "Compile the examples and benchmarks for this machine, fully optimised" OFF)

# For code that must be free of warnings whatever the options say.
add_library(semiexplicit_warnings INTERFACE)
target_compile_options(semiexplicit_warnings INTERFACE -Wall -Wextra -Wpedantic -Wconversion -Wsign-conversion -Wshadow -Werror)

# For every test and program.
add_library(semiexplicit_developer INTERFACE)
if(SEMIEXPLICIT_DEVELOPER_WARNINGS)
  target_link_libraries(semiexplicit_developer INTERFACE semiexplicit_warnings)
endif()
if(SEMIEXPLICIT_SANITIZE)
  set(sanitizers -fsanitize=address,undefined -fno-sanitize-recover=all)
  target_compile_options(semiexplicit_developer INTERFACE ${sanitizers} -fno-omit-frame-pointer)
  target_compile_definitions(semiexplicit_developer INTERFACE _GLIBCXX_ASSERTIONS)
  target_link_options(semiexplicit_developer INTERFACE ${sanitizers})
endif()

# g++ takes a tenth less time where it looks for unused memory less often.
if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
  target_compile_options(semiexplicit_developer INTERFACE --param=ggc-min-expand=300 --param=ggc-min-heapsize=1000000)
endif()

# clang's own linker takes half the time, where it is installed.
if(CMAKE_CXX_COMPILER_ID STREQUAL "Clang")
  find_program(SEMIEXPLICIT_LLD ld.lld)
  mark_as_advanced(SEMIEXPLICIT_LLD)
  if(SEMIEXPLICIT_LLD)
    target_link_options(semiexplicit_developer INTERFACE -fuse-ld=lld)
  endif()
endif()

# For what takes longer to compile than to run.
add_library(semiexplicit_unoptimised INTERFACE)
target_compile_options(semiexplicit_unoptimised INTERFACE $<$<CXX_COMPILER_ID:GNU,Clang,AppleClang>:-O0>)

# For examples and benchmarks, on top: whole programs, so that no two parts of one disagree about Eigen's alignment.
add_library(semiexplicit_program INTERFACE)
target_link_libraries(semiexplicit_program INTERFACE semiexplicit semiexplicit_developer)
if(SEMIEXPLICIT_SANITIZE)
  # Their tests follow orbits for years: a tenth of the time for three times that of compiling.
  target_compile_options(semiexplicit_program INTERFACE -O1)
endif()
if(SEMIEXPLICIT_NATIVE)
  target_compile_options(semiexplicit_program INTERFACE -O3 -march=native)
  target_compile_definitions(semiexplicit_program INTERFACE NDEBUG)
endif()

# Ensembles use as many threads as OpenMP gives them; without it they have one.
find_package(OpenMP QUIET COMPONENTS CXX)
if(NOT TARGET OpenMP::OpenMP_CXX)
  message(STATUS "Ensembles go without threads: no OpenMP found (Debian, Ubuntu: g++ has it; clang++ needs libomp-dev)")
endif()
