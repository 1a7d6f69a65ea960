// What the aperture renderer computes, effect by effect.
#pragma once

#include "acus/imaging/ultrasound/beams/beam_options.h"
#include "acus/imaging/ultrasound/beams/side_lobes.h"

namespace acus::ultrasound {

/// Effects of the model `aperture`. Those of BeamOptions mean the same, but refraction includes the
/// time of flight, and fibre_texture means FibreStreaks; time_of_flight and the thresholds of
/// strong interfaces are not used. An effect that is off costs nothing.
struct ApertureOptions : BeamOptions {
  ApertureOptions() {
    name = "aperture";
    fibre_texture = false;
    elevation_planes = 3;
    coupling_gap_mm = 8.0;
    lobe_deg = 15.0;
    diffuse_share = 0.03;
    needle_transmission_db = -5.0;
    needle_ring_decay = 0.15;
    needle_lobe_deg = 22.0;
    needle_diffuse_share = 0.01;
    needle_tip_echo = 0.1;
  }

  bool texture = true;  ///< Scatterers follow the CT within each tissue.
  /// Kidney, capsules, walls and the spinal canal are filled with what a CT does not resolve.
  bool organ_structure = false;
  bool clutter = true;      ///< Haze of nearby echoes, which fills shadows.
  bool noise = true;        ///< Electronic noise of the receiver.
  bool ring_down = true;    ///< Echoes of the probe itself, next to its face.
  bool side_lobes = false;  ///< Of the array, and grating lobes: ghosts of strong reflectors.
  Apodisation apodisation = Apodisation::kRectangular;  ///< ... of both apertures.
  /// The mean intensity of the scatterers in place of their speckle, and rough surfaces whose
  /// pattern stays with the lines: an image that changes smoothly with the pose.
  bool mean_speckle = false;
  int aperture_rays = 13;  ///< Odd, 1 to 31: directions over transmit and receive aperture.

  /// Two-way loss within bone and gas. Their echo and shadow begin at the smooth surface.
  double strong_loss_db_per_mm = 40.0;
  /// Depth over which the echo of a rough, strong surface decays; 0: all surfaces are mirrors.
  double rough_layer_mm = 0.3;
  double rough_layer_db = -14.0;  ///< Its start, relative to a mirror's echo.
  double clutter_db = -29.0;      ///< Amplitude, relative to the echoes around.
  double clutter_reach_mm = 2.5;
  double noise_db = -134.0;  ///< Amplitude at the receiver; 0 dB is a perfect flat reflector.
  /// TGC grows no further where it would lift the noise above black: at a gain of 28 dB, that of
  /// the presets, the noise then stays 4 dB below a range of 60 dB.
  double tgc_limit_db = 42.0;
  double ring_down_db = -30.0;  ///< Amplitude of the first echo of the face.
};

}  // namespace acus::ultrasound
