#include "acus/run/live/rig.h"

#include <algorithm>

#include "acus/base/core/error.h"
#include "acus/rig/haptics/open_device.h"

namespace acus::live {
namespace {

/// Finds the vendors' libraries of both tools before it reports a problem of either.
void CheckLibraries(const haptics::DevicesFile& file) {
  std::string wrong;
  for (const haptics::ToolConfig* tool : {&file.needle, &file.probe}) {
    if (tool->device.empty()) continue;
    try {
      haptics::CheckDevice(*file.Find(tool->device));
    } catch (const InputError& error) {
      wrong += (wrong.empty() ? "" : ". Also, ") + std::string(error.what());
    }
  }
  ACUS_REQUIRE(wrong.empty(), wrong);
}

}  // namespace

Rig::Rig(const LiveDevices& devices, Use use) : devices_(devices), use_(use) {
  for (const TrackerConfig& tracker : devices_.trackers) {
    trackers_.push_back(std::make_unique<tracking::IgtlSource>(tracker.options));
  }
  if (devices_.camera) {
    auto tracker = std::make_unique<camera::CameraTracker>(
        camera::ReadCamera(devices_.camera->model), camera::ReadFacets(devices_.camera->facets),
        devices_.camera->options);
    camera_ = tracker.get();
    trackers_.push_back(std::move(tracker));
  }
  if (use == Use::kCheck) CheckLibraries(devices_.haptics);
  for (const haptics::ToolConfig* tool : {&devices_.haptics.needle, &devices_.haptics.probe}) {
    if (tool->device.empty()) continue;
    const haptics::DeviceConfig& config = *devices_.haptics.Find(tool->device);
    if (config.driver == haptics::DriverKind::kVirtualHand) continue;
    opened_.push_back({tool->device, use == Use::kCheck ? haptics::CheckDevice(config)
                                                        : haptics::OpenDevice(config)});
  }
}

Rig::~Rig() {
  for (const Device& opened : opened_) opened.device->Stop();
  for (const auto& tracker : trackers_) tracker->Stop();
}

haptics::HapticDevice* Rig::Find(const std::string& device) const {
  const auto found = std::ranges::find(opened_, device, &Device::name);
  return found == opened_.end() ? nullptr : found->device.get();
}

void Rig::StartTrackers() {
  if (trackers_run_) return;
  for (const auto& tracker : trackers_) tracker->Start();
  trackers_run_ = true;
}

void Rig::ReleaseDevices() noexcept {
  for (const Device& opened : opened_) {
    if (use_ == Use::kManySessions) {
      opened.device->Park();
    } else {
      opened.device->Stop();
    }
  }
}

void Rig::ReleaseTrackers() noexcept {
  if (use_ == Use::kManySessions) return;
  for (const auto& tracker : trackers_) tracker->Stop();
  trackers_run_ = false;
}

}  // namespace acus::live
