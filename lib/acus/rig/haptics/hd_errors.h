// Errors of OpenHaptics: which matter, what they mean, and opening a device in spite of some.
#pragma once

#include <string>

#include "acus/rig/haptics/driver.h"
#include "acus/rig/haptics/hd_api.h"

namespace acus::haptics::hd {

/// Our own code: the library reports errors without end.
inline constexpr unsigned kEndlessErrors = 0xFFFF;
/// Our own code: hdScheduleAsynchronous gave no callback.
inline constexpr unsigned kNoCallback = 0xFFFE;

DriverFault KindOf(unsigned code) noexcept;

/// Plain words, and the vendor's own, if any.
std::string Text(const Api& api, unsigned code);

/// Fetches errors until there is none; of several, the one that matters most.
unsigned DrainErrors(const Api& api) noexcept;

/// Initialises a device; of those by default names, the first that is there. If a device is said to
/// be in use, it is disabled and tried again, ten times. @throws InputError
unsigned OpenDevice(const Api& api, const std::string& name);

}  // namespace acus::haptics::hd
