// How tissues carry sound: a table by tissue name, and by Hounsfield unit where nothing is
// labelled.
#pragma once

#include <array>
#include <bitset>
#include <filesystem>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "acus/data/volume/volume.h"

namespace acus::acoustics {

/// One tissue. The values of configs/acoustics/tissues.json name their sources.
struct TissueAcoustics {
  double speed_m_per_s = 1540.0;
  double impedance_mrayl = 1.62;
  /// One way at 1 MHz, across the fibres where there are any. An echo loses it twice.
  double attenuation_db_per_cm_mhz = 0.5;
  double attenuation_along_fibres_db_per_cm_mhz = 0.5;  ///< The same as across if there are none.
  double attenuation_exponent = 1.0;  ///< Attenuation grows with the frequency to this power.
  double scatterers_per_mm3 = 50.0;   ///< Effective number density; what is below it is not random.
  double backscatter_db = -48.0;      ///< Share of intensity sent back per mm of depth.
  double fibre_ratio = 1.0;  ///< Texture is this much longer along the fibres than across; >= 1.

  /// dB/cm one way. `cos_to_fibres`: cosine of the angle between beam and fibres; the loss goes
  /// with its square between across (0) and along (1).
  double AttenuationDbPerCm(double frequency_mhz, double cos_to_fibres = 0.0) const;
};

/// A tissue at a Hounsfield unit; in between all values are linear.
struct HuTissue {
  double hu = 0.0;
  std::string tissue;
};

struct TissueAcousticsTable {
  std::string name;
  std::string file;                                ///< Where it was read, for messages.
  std::map<std::string, TissueAcoustics> tissues;  ///< Also materials such as "water" and "steel".
  std::vector<HuTissue> by_hu;                     ///< At least one, sorted.

  /// @throws InputError naming the tissue, the file and the nearest name.
  const TissueAcoustics& Of(std::string_view tissue) const;

  /// For places without a label. Constant beyond the ends.
  TissueAcoustics AtHu(double hu) const;
};

/// Reads configs/acoustics/<name>.json (format acus-tissue-acoustics/1), or the spatial models of a
/// PLUS configuration (*.xml, see plus_simulator.h).
/// @throws InputError listing all problems.
TissueAcousticsTable ReadTissueAcoustics(const std::filesystem::path& path);

/// For the inner loops of a renderer: by label number. Entries of labels that do not occur are
/// those of the first knot of by_hu. Label 0 is where nothing is labelled: read AtHu() there; its
/// entry is that of "outside" if the table has one, else of "water".
struct LabelAcoustics {
  std::array<TissueAcoustics, 256> of;
  std::bitset<256> occurs;  ///< In the label map.
};

/// @param labels_file  Where the labels came from, for messages.
/// @throws InputError if a label that occurs has no entry: names label, tissue, both files and what
///     to do. A label goes by its name in the map, else by its standard name.
LabelAcoustics AcousticsOfLabels(const TissueAcousticsTable& table, const volume::LabelMap& labels,
                                 const std::string& labels_file);

}  // namespace acus::acoustics
