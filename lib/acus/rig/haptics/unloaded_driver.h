// A device of which only the settings are known: none of the vendor's code has run.
#pragma once

#include <string>
#include <utility>

#include "acus/base/core/error.h"
#include "acus/rig/haptics/driver.h"

namespace acus::haptics {

class UnloadedDriver final : public Driver {
 public:
  explicit UnloadedDriver(DeviceInfo info) : info_(std::move(info)) {}

  DeviceInfo Open() override { return info_; }
  /// @throws InputError always.
  void Run(GuardedServo&) override {
    throw InputError(info_.name + ": was only checked, and cannot be started");
  }
  void Halt() noexcept override {}
  void ZeroNow() noexcept override {}
  std::string FaultText(int) const override { return info_.name; }

 private:
  DeviceInfo info_;
};

}  // namespace acus::haptics
