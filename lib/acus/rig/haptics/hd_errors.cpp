#include "acus/rig/haptics/hd_errors.h"

#include <array>
#include <cstdlib>
#include <span>
#include <sstream>

#include "acus/base/core/error.h"

namespace acus::haptics::hd {
namespace {

constexpr int kMostInits = 10;
constexpr int kMostErrors = 100;

const char* Meaning(unsigned code) {
  switch (code) {
    case 0x200:
      return "its motors are warm: let it rest for some minutes";
    case 0x201:
      return "more force was requested than it has";
    case 0x202:
      return "its force changed faster than it allows";
    case 0x203:
      return "it was moved faster than it allows";
    case 0x204:
      return "it could not give the force";
    case 0x300:
      return "the device is not there or faulty: is it plugged in and switched on?";
    case 0x301:
      return "the device is in use: close other programs that use it";
    case 0x302:
      return "communication with the device was lost: is its cable plugged in?";
    case 0x303:
      return "the device is not set up: pair it with the vendor's setup program";
    case 0x304:
      return "the vendor's servo timer failed";
    case 0x600:
      return "the licence of OpenHaptics is not valid";
    case kEndlessErrors:
      return "the library reports errors without end";
    case kNoCallback:
      return "the vendor's scheduler takes no callback";
    default:
      return "an error that is not known";
  }
}

unsigned InitByName(const Api& api, const char* name, unsigned& error) {
  unsigned handle = kNoDevice;
  for (int i = 0; i < kMostInits; ++i) {
    DrainErrors(api);
    handle = api.InitDevice(name);
    error = DrainErrors(api);
    if (error != kAlreadyInitiated) break;
    // Left behind by a program that crashed, or by ourselves.
    api.DisableDevice(api.GetCurrentDevice());
  }
  if (error == kSuccess && handle == kNoDevice) error = kDeviceFault;
  const bool is_usable = error == kSuccess || KindOf(error) == DriverFault::kWarning;
  if (is_usable) return handle;
  if (handle != kNoDevice) api.DisableDevice(handle);
  return kNoDevice;
}

}  // namespace

DriverFault KindOf(unsigned code) noexcept {
  if (code == kSuccess) return DriverFault::kNone;
  if (code == kInvalidLicense) return DriverFault::kFatal;
  // Motors are warm, a force was too large: the device looks after itself. And a value that this
  // device does not have.
  if (code >= kWarmMotors && code <= kForceError) return DriverFault::kWarning;
  if (code >= kInvalidEnum && code <= kInvalidInputType) return DriverFault::kWarning;
  return DriverFault::kReopen;
}

std::string Text(const Api& api, unsigned code) {
  std::ostringstream text;
  text << Meaning(code) << " (error 0x" << std::hex << code;
  const char* words = api.GetErrorString != nullptr ? api.GetErrorString(code) : nullptr;
  if (words != nullptr && words[0] != '\0' && code < kNoCallback) text << ", " << words;
  text << ")";
  return text.str();
}

unsigned DrainErrors(const Api& api) noexcept {
  unsigned worst = kSuccess;
  for (int i = 0; i < kMostErrors; ++i) {
    const unsigned code = api.GetError().code;
    if (code == kSuccess) return worst;
    if (KindOf(worst) < KindOf(code)) worst = code;
  }
  return kEndlessErrors;
}

unsigned OpenDevice(const Api& api, const std::string& name) {
  // Some versions do not take NULL for the default device, and its name has changed.
  const std::array<const char*, 3> defaults = {nullptr, "Default Device", "Default PHANToM"};
  const std::array<const char*, 1> named = {name.c_str()};
  unsigned first_error = kSuccess;
  for (const char* candidate : name.empty() ? std::span<const char* const>(defaults)
                                            : std::span<const char* const>(named)) {
    unsigned error = kSuccess;
    const unsigned device = InitByName(api, candidate, error);
    if (device != kNoDevice) return device;
    if (first_error == kSuccess) first_error = error;
  }
  throw InputError(
      Message("OpenHaptics: the device '", name.empty() ? "default" : name,
              "' cannot be used: ", Text(api, first_error),
              std::getenv("GTDD_HOME") != nullptr
                  ? ""
                  : ". GTDD_HOME is not set: it names the folder with the pairing files"));
}

}  // namespace acus::haptics::hd
