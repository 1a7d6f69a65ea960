// A graphics driver with stereo for shutter glasses, as far as a window asks for it.
#pragma once

namespace acus::testing_support {

/// While one lives, GLX gives a window that asks for stereo one without, in place of none: what is
/// drawn for both eyes is then there, but no screen shows it.
class OfferShutterStereo {
 public:
  OfferShutterStereo();
  ~OfferShutterStereo();
  OfferShutterStereo(const OfferShutterStereo&) = delete;
  OfferShutterStereo& operator=(const OfferShutterStereo&) = delete;
};

}  // namespace acus::testing_support
