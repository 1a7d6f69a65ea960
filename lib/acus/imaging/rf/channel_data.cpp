#include "acus/imaging/rf/channel_data.h"

#include <cmath>

#include "acus/base/core/error.h"

namespace acus::rf {

const ChannelData& Checked(const ChannelData& data, const char* label) {
  ACUS_REQUIRE(data.samples >= 16 && data.elements >= 1 && data.transmits >= 1, label,
               ": channel data of ", data.samples, " samples, ", data.elements, " elements and ",
               data.transmits, " transmissions; at least 16, 1 and 1 are needed");
  ACUS_REQUIRE(
      data.values.size() == static_cast<std::size_t>(data.samples) * data.elements * data.transmits,
      label, ": ", data.values.size(), " values do not fill the channel data");
  ACUS_REQUIRE(std::isfinite(data.sampling_mhz) && data.sampling_mhz > 0.0, label,
               ": the sampling rate is ", data.sampling_mhz, " MHz; it must be above 0");
  ACUS_REQUIRE(std::isfinite(data.start_us), label, ": the start is ", data.start_us,
               " us; a finite number is needed");
  for (std::size_t i = 0; i < data.values.size(); ++i) {
    ACUS_REQUIRE(std::isfinite(data.values[i]), label, ": value ", i, " is ", data.values[i],
                 "; finite numbers are needed");
  }
  return data;
}

}  // namespace acus::rf
