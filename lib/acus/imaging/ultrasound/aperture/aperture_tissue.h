// What the aperture renderer reads of a patient, shared by all renderers of one scene.
#pragma once

#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <tuple>

#include "acus/imaging/acoustics/probe.h"
#include "acus/imaging/ultrasound/aperture/aperture_options.h"
#include "acus/imaging/ultrasound/beams/acoustic_volume.h"
#include "acus/imaging/ultrasound/columns/fibre_streaks.h"

namespace acus::ultrasound {

/// Some bytes for each voxel of the patient.
struct ApertureTissue {
  ApertureTissue(const BeamTissue& tissue, const acoustics::Probe& probe,
                 const ApertureOptions& options, int num_threads);

  AcousticVolume volume;
  std::optional<FibreStreaks> streaks;  ///< Nothing: off, or no tissue has any.
};

/// Gives renderers of the same patient and settings one ApertureTissue, as long as one of them
/// lives. For any number of threads.
class ApertureTissueStore {
 public:
  std::shared_ptr<const ApertureTissue> Get(const BeamTissue& tissue, const acoustics::Probe& probe,
                                            const ApertureOptions& options, int num_threads);

 private:
  /// All that an ApertureTissue depends on; patients and tables by their address.
  using Key = std::tuple<const void*, const void*, const void*, double, double, bool, bool, bool,
                         bool, bool, bool, std::uint64_t,
                         std::map<std::string, std::tuple<double, double, double>>>;
  static Key KeyOf(const BeamTissue& tissue, const acoustics::Probe& probe,
                   const ApertureOptions& options);

  std::mutex mutex_;
  Key key_{};
  std::weak_ptr<const ApertureTissue> tissue_;
};

}  // namespace acus::ultrasound
