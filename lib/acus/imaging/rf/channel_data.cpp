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

ChannelData WithTransmissions(const ChannelData& data, std::span<const int> numbers) {
  if (numbers.empty()) return data;
  ChannelData out = data;
  out.transmits = static_cast<int>(numbers.size());
  out.values.clear();
  const std::size_t length = static_cast<std::size_t>(data.samples) * data.elements;
  for (const int number : numbers) {
    ACUS_REQUIRE(number >= 0 && number < data.transmits, "channel data: transmission ", number,
                 " of ", data.transmits, "; their numbers begin at 0");
    const auto begin = data.values.begin() + static_cast<std::ptrdiff_t>(data.Offset(number, 0));
    out.values.insert(out.values.end(), begin, begin + static_cast<std::ptrdiff_t>(length));
  }
  return out;
}

}  // namespace acus::rf
