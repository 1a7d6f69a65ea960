// The force for a device whose servo does not run the steps.
#pragma once

#include <array>
#include <cstdint>

#include "acus/base/core/seqlock.h"
#include "acus/rig/haptics/device_reading.h"

namespace acus::live {

/// One thread writes, any number of threads read; none waits. A reader that overlaps a write reads
/// again, at most a few times, and then returns no force.
class ForceMailbox {
 public:
  void Put(const haptics::DeviceForce& force, std::int64_t time_ns) noexcept {
    const Eigen::Vector3d& f = force.force_n;
    const Eigen::Vector3d& m = force.torque_nmm;
    newest_.Store({.values = {f[0], f[1], f[2], m[0], m[1], m[2]}, .time_ns = time_ns});
  }

  /// The last force; none if it is older than `oldest_ns`.
  haptics::DeviceForce Get(std::int64_t now_ns, std::int64_t oldest_ns) const noexcept {
    if (newest_.num_stored() == 0) return {};
    Letter letter{};
    for (int attempt = 0; attempt < 8; ++attempt) {
      if (!newest_.TryLoad(letter)) continue;
      if (now_ns - letter.time_ns > oldest_ns) return {};
      const auto& v = letter.values;
      return {.force_n = {v[0], v[1], v[2]}, .torque_nmm = {v[3], v[4], v[5]}};
    }
    return {};
  }

 private:
  struct Letter {
    std::array<double, 6> values;  ///< N, then N mm.
    std::int64_t time_ns;
  };
  Seqlock<Letter> newest_;
};

}  // namespace acus::live
