#pragma once

/// Marks what runs rarely, as what writes a message or a table: with clang++ it is compiled to be short
/// instead of fast, which takes half the time. No gradient or energy is to be inlined into it. Not `cold`
/// with g++, which takes for cold, too, whatever surely calls such a function, and a gradient in an unnamed
/// namespace, or a lambda, that is called from there only: without `noipa` a whole run would be.
#if defined(__clang__)
#define SEMIEXPLICIT_COLD __attribute__((cold))
#elif defined(__GNUC__)
#define SEMIEXPLICIT_COLD __attribute__((noipa))
#else
#define SEMIEXPLICIT_COLD
#endif
