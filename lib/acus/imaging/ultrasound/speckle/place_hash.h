// A random number that belongs to a place: the same in every image.
#pragma once

#include <cstdint>

namespace acus::ultrasound {

/// All 32 bits depend on all bits of the place and of `which`, one of several numbers there.
inline std::uint32_t HashOfPlace(int x, int y, int z, std::uint32_t which) {
  auto h = static_cast<std::uint32_t>(x) * 0x9E3779B1U ^
           static_cast<std::uint32_t>(y) * 0x85EBCA77U ^
           static_cast<std::uint32_t>(z) * 0xC2B2AE3DU ^ which;
  h = (h ^ h >> 15) * 0x2C1B3C6DU;
  h = (h ^ h >> 13) * 0x297A2D39U;
  return h ^ h >> 16;
}

}  // namespace acus::ultrasound
