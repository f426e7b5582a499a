# cmake -D README=... -D PROGRAM=... -P readme_shows.cmake: the README quotes the program word for word.
file(READ "${README}" readme)
file(READ "${PROGRAM}" program)
string(FIND "${readme}" "```cpp\n${program}```" found)
if(found EQUAL -1)
  message(FATAL_ERROR "${README} does not show ${PROGRAM} as it is. Copy the whole file into its ```cpp block.")
endif()
