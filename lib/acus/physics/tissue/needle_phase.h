// Where a needle is, to tissue that it deforms.
#pragma once

#include <cstdint>

namespace acus::tissue {

enum class NeedlePhase : std::uint8_t {
  kFree,    ///< Outside.
  kOnSkin,  ///< The tip presses the skin.
  kInside,  ///< The skin has yielded.
};

}  // namespace acus::tissue
