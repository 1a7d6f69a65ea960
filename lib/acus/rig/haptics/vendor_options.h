// What the user can say about a device that a vendor's library drives.
#pragma once

#include <string>

namespace acus::haptics {

struct VendorOptions {
  std::string library;  ///< Absolute path, or name without a slash; empty: the usual names.
  std::string device;   ///< Name, serial number or address; empty: the default one.
  std::string axes;     ///< haptics/axes.h; empty: as the vendor has them.
  double rate_hz = 1000.0;
  double timeout_s = 5.0;  ///< For loading the library and for finding the device.
};

}  // namespace acus::haptics
