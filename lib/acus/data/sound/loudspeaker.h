// A sound through the loudspeaker of this computer: OpenAL Soft, which is loaded when it is asked
// for and not before.
#pragma once

#include <memory>

#include "acus/data/sound/sound.h"

namespace acus::loudspeaker {

/// One sound, ready to be played. For one thread at a time; not for the thread that feels forces.
class Loudspeaker {
 public:
  /// Opens the system's loudspeaker; ALSOFT_DRIVERS and ALSOFT_CONF choose another.
  /// @throws InputError if the library is not installed, or there is no loudspeaker.
  explicit Loudspeaker(const sound::Sound& sound);
  ~Loudspeaker();  ///< Breaks off what plays.
  Loudspeaker(const Loudspeaker&) = delete;
  Loudspeaker& operator=(const Loudspeaker&) = delete;

  /// From the beginning, now; what still plays is broken off. Returns at once.
  void Play() noexcept;

 private:
  struct Device;
  std::unique_ptr<Device> device_;
};

}  // namespace acus::loudspeaker
