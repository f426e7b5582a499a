#pragma once

#include <cstdint>
#include <string_view>

namespace semiexplicit {

/// The checksum FNV-1a with 64 bits, of `bytes` after those that gave `so_far`. A single changed byte always
/// changes it. Source: G. Fowler, L. C. Noll, K.-P. Vo, D. Eastlake, The FNV Non-Cryptographic Hash Algorithm
/// (IETF draft-eastlake-fnv).
inline std::uint64_t checksum(std::string_view bytes, std::uint64_t so_far = 0xcbf29ce484222325U) {
  for (const char byte : bytes) so_far = (so_far ^ static_cast<unsigned char>(byte)) * 0x100000001b3U;
  return so_far;
}

}  // namespace semiexplicit
