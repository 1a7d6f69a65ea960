#include "acus/imaging/ultrasound/aperture/aperture_tissue.h"

#include "acus/imaging/acoustics/beam_width.h"

namespace acus::ultrasound {
namespace {

/// Structure that no CT shows is made up: it has no place in an image that is matched with another.
bool MakesStructure(const ApertureOptions& options) {
  return !options.mean_speckle;
}

std::optional<std::uint64_t> OrgansOf(const ApertureOptions& options) {
  if (!options.organ_structure || !MakesStructure(options)) return {};
  return options.seed;
}

}  // namespace

ApertureTissue::ApertureTissue(const BeamTissue& tissue, const acoustics::Probe& probe,
                               const ApertureOptions& options, int num_threads)
    : volume(tissue, BeamMaterials(tissue, options, probe, 1.0), options.texture, num_threads,
             OrgansOf(options)) {
  if (!options.fibre_texture || !MakesStructure(options) || tissue.labels == nullptr) return;
  streaks.emplace(tissue, options.seed);
  if (!streaks->any()) streaks.reset();
}

ApertureTissueStore::Key ApertureTissueStore::KeyOf(const BeamTissue& tissue,
                                                    const acoustics::Probe& probe,
                                                    const ApertureOptions& options) {
  std::map<std::string, std::tuple<double, double, double>> fibres;
  for (const auto& [name, along] : tissue.fibres_in_ct) {
    fibres[name] = {along.x(), along.y(), along.z()};
  }
  return {tissue.ct,
          tissue.labels,
          tissue.acoustics,
          acoustics::ReceivedMhz(probe),
          acoustics::AxialFwhmMm(probe),
          options.texture,
          options.attenuation,
          options.speckle,
          options.fibre_texture,
          options.organ_structure,
          options.mean_speckle,
          options.seed,
          std::move(fibres)};
}

std::shared_ptr<const ApertureTissue> ApertureTissueStore::Get(const BeamTissue& tissue,
                                                               const acoustics::Probe& probe,
                                                               const ApertureOptions& options,
                                                               int num_threads) {
  const std::scoped_lock lock(mutex_);
  Key key = KeyOf(tissue, probe, options);
  std::shared_ptr<const ApertureTissue> made = tissue_.lock();
  if (made != nullptr && key == key_) return made;
  made = std::make_shared<const ApertureTissue>(tissue, probe, options, num_threads);
  key_ = std::move(key);
  tissue_ = made;
  return made;
}

}  // namespace acus::ultrasound
