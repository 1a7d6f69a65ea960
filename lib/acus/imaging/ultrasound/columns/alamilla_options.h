// What Alamilla's image makes of each tissue.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace acus::ultrasound {

enum class TissueTexture {
  kSpeckle,      ///< Round grains.
  kThickFibres,  ///< Streaks along the fibres, dots across them (muscle).
  kThinFibres,   ///< Speckle blurred along the fibres (tendon, ligament).
};

/// Images that a tissue's texture is to look like.
struct TextureImages {
  std::filesystem::path along;   ///< In it the fibres run from left to right.
  std::filesystem::path across;  ///< A cut across them; may be empty.
  double mm_per_px = 0.0;        ///< Of both, > 0.
};

struct AlamillaTissue {
  std::string tissue;     ///< Name of a label.
  double grey = 0.0;      ///< Mean share of white, right under the probe.
  double contrast = 0.0;  ///< Of the texture: grey times 1 - c to 1 + c.
  double grain_mm = 0.5;
  TissueTexture texture = TissueTexture::kSpeckle;
  /// Instead of noise; contrast and grain are then those of the images.
  std::optional<TextureImages> example{};
  double absorption_per_cm = 0.0;  ///< Grey falls as exp(-this times depth in cm).
  double reflection = 0.0;         ///< Share of white that its surface adds, met at a right angle.
  bool blocks = false;             ///< Bone and gas: shadow behind its surface.
};

/// As in configs/schema/acus-image-alamilla.schema.json, where the ranges and defaults are.
/// A stage that is off is not computed.
struct AlamillaOptions {
  std::string name;
  std::string file;  ///< For messages.
  std::vector<AlamillaTissue> tissues;
  bool reflection = true;
  bool shadow = true;
  bool absorption = true;
  bool speckle = true;
  std::uint64_t seed = 0;          ///< Of the speckle.
  bool fibres = true;              ///< Off: fibrous tissues have round grains.
  double surface_mm = 0.0;         ///< Thickness of a reflection's line.
  double shadow_share = 0.0;       ///< Left of the grey behind bone and gas.
  double needle_share = 1.0;       ///< The same behind the needle, which is thinner than the slice.
  int angle_exponent = 0;          ///< Reflections fall with cos^n of the angle.
  double thick_fibre_ratio = 1.0;  ///< Length of a streak over its width.
  double thin_fibre_mm = 0.0;      ///< Length of the blur along thin fibres.
  double coupling_gap_mm = 0.0;
  /// Deformed tissue displaces the pixels of the finished image, as in the paper; false: the scene,
  /// so that echoes and shadows are those of the displaced tissue. Not of the file: of who calls.
  bool displaces_pixels = false;
  /// Gain of the probe for which the table of greys holds, dB; nothing: the probe's, whatever it
  /// is.
  std::optional<double> gain_of_table_db;

  /// The files of all tissues.
  std::vector<std::filesystem::path> ExampleImages() const;
};

/// Reads configs/acoustics/<name>.json (format acus-image-alamilla/1).
/// @throws InputError listing all problems.
AlamillaOptions ReadAlamillaOptions(const std::filesystem::path& path);

}  // namespace acus::ultrasound
