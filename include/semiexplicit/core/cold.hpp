#pragma once

/// Marks what runs rarely, as what writes a message or a table: it is compiled to be short instead of fast,
/// which takes the compiler half the time. No gradient or energy is to be inlined into it.
#if defined(__GNUC__) || defined(__clang__)
#define SEMIEXPLICIT_COLD __attribute__((cold))
#else
#define SEMIEXPLICIT_COLD
#endif
