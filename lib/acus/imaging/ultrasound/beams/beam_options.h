// What the beam renderer computes, effect by effect.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <map>
#include <string>

#include "acus/data/volume/volume.h"
#include "acus/imaging/acoustics/tissue_acoustics.h"
#include "acus/imaging/ultrasound/display/display_options.h"

namespace acus::ultrasound {

/// Effects of the model `beams`. One that is off is not computed and costs nothing.
struct BeamOptions {
  std::string name = "beams";

  bool interfaces = true;  ///< Echoes where the impedance changes, and what they leave.
  bool angle = true;  ///< ... depend on the angle: Fresnel's law and the lobe of a rough mirror.
  bool attenuation = true;  ///< Two-way loss, with fibres where they are known.
  bool shadow = true;       ///< Bone and gas let through `strong_transmission_db` only.
  bool comet_tail = true;   ///< Ring-down behind gas, and reverberation within the needle.
  bool speckle = true;
  std::uint64_t seed = 0;     ///< Of the speckle.
  bool fibre_texture = true;  ///< Speckle is longer along fibres, where their direction is known.
  bool point_spread = true;
  bool needle_shadow = true;

  bool refraction = false;      ///< Lines bend by Snell's law. More expensive.
  bool time_of_flight = false;  ///< Samples lie at their time, by the local speed. More expensive.
  bool multiple_reflections = false;  ///< Between strong interfaces and the face. More expensive.

  int elevation_planes = 1;         ///< Odd, 1 to 15, over the thickness of the slice.
  double point_spread_reach = 2.6;  ///< Windows end at this many standard deviations.

  double lobe_deg = 25.0;             ///< Standard deviation (in the tangent) of the mirror's lobe.
  double diffuse_share = 0.12;        ///< Echo amplitude that does not depend on the lobe.
  double smallest_reflection = 0.02;  ///< Weaker interfaces of a CT are noise.
  double strong_reflection = 0.43;    ///< Amplitude from which an interface is one of bone or gas.
  double strong_transmission_db = -50.0;
  double coupling_gap_mm = 3.0;  ///< Gel fills air up to this between face and skin.
  double face_reflection = 0.5;  ///< Amplitude, of the probe itself (multiple reflections).

  double needle_reflection = 0.9;  ///< Amplitude, of the shaft at a right angle to the beam.
  double needle_lobe_deg = 30.0;
  double needle_diffuse_share = 0.08;   ///< What a roughened shaft sends back at any angle.
  double needle_transmission_db = -12;  ///< Behind a shaft in the middle of the slice.
  double needle_ring_decay = 0.3;       ///< Amplitude from one reverberation to the next.
  double needle_tip_echo = 0.0;         ///< Amplitude, of the bevel at any angle.
  double gas_ring_decay = 0.5;          ///< A comet's tail tapers off within a centimetre.
  double gas_ring_spacing_mm = 1.2;

  DisplayOptions display{};  ///< What the scanner adds; but persistence, which needs the time.
};

/// What is imaged. At least one volume; if both, of the same geometry: then Hounsfield units serve
/// where the label is 0.
struct BeamTissue {
  const volume::CtVolume* ct = nullptr;
  const volume::LabelMap* labels = nullptr;
  const acoustics::TissueAcousticsTable* acoustics = nullptr;
  std::string labels_file = "labels";  ///< For messages.
  /// Direction of the fibres by tissue name, in CT space (LPS) at rest. Need not be unit vectors.
  std::map<std::string, Eigen::Vector3d> fibres_in_ct{};
};

}  // namespace acus::ultrasound
