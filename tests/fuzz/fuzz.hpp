#pragma once

#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>

// Every harness is a file of this folder with the function that libFuzzer calls. cmake/fuzz.sh builds it with
// the fuzzer; in the ordinary tests replay.cpp calls it with the seeds and with every input that once found
// something.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);

/// Ends the program, in a way that fuzzer and tests notice, where a promise is broken.
inline void promise(bool kept, const char* what) {
  if (kept) return;
  std::fprintf(stderr, "broken: %s\n", what);
  std::abort();
}
