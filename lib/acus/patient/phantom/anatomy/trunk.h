// The outline of the trunk and the course of the spine, on which all parts are built.
#pragma once

#include "acus/base/core/random.h"
#include "acus/patient/phantom/anatomy/anatomy.h"

namespace acus::phantom {

/// Cross-section of a layer at one height: half axes and centre, mm.
struct Section {
  double half_width_mm;
  double half_depth_mm;
  double centre_y_mm;
};

/// Smooth tube-like layers: skin outside fascia outside cavity.
class Trunk {
 public:
  explicit Trunk(const BodySettings& settings);

  /// y of the back wall of the vertebral bodies at height z (lordosis below, kyphosis above).
  double SpineY(double z_mm) const;
  double SpineSlope(double z_mm) const;

  Section Skin(double z_mm) const { return At(z_mm, &Level::skin); }
  Section Fascia(double z_mm) const { return At(z_mm, &Level::fascia); }  ///< Under the fat.
  Section Cavity(double z_mm) const { return At(z_mm, &Level::cavity); }  ///< Inside the wall.

  double SkinDistance(const Eigen::Vector3d& p) const;
  double FasciaDistance(const Eigen::Vector3d& p) const;
  double CavityDistance(const Eigen::Vector3d& p) const;

 private:
  /// All that depends on height alone, at steps of kStepMm: most of the work of a voxel is here.
  struct Level {
    double spine_y, spine_slope;
    Section skin, fascia, cavity;
  };
  std::pair<std::size_t, double> Step(double z_mm) const;  ///< Level below, share of the next.
  Section At(double z_mm, Section Level::*layer) const;

  std::vector<Level> levels_;
};

/// Height of the diaphragm over (x, y), mm.
double DiaphragmZ(double x_mm, double y_mm);

/// What the builders fill, in order of priority.
struct Builder {
  const Trunk& trunk;
  const BodySettings& settings;
  std::uint64_t seed;
  std::vector<Part>& parts;
  Landmarks& landmarks;

  void Add(std::string name, Material material, Shape shape) {
    parts.push_back({std::move(name), material, material, 0.0, std::move(shape)});
  }
  void AddShelled(std::string name, Material core, Material shell, double shell_mm, Shape shape) {
    parts.push_back({std::move(name), core, shell, shell_mm, std::move(shape)});
  }
  /// A factor near 1 that belongs to the name of a part.
  double Vary(const std::string& name, std::uint64_t index = 0) const {
    const double z = RandomStream(seed, "size of " + name, index).Normal();
    return 1.0 + 0.01 * settings.variation_percent * std::min(std::max(z, -2.5), 2.5);
  }
};

void AddSpine(Builder& builder);  ///< Vertebrae, sacrum, discs, ligaments, canal.
void AddPelvis(Builder& builder);
void AddRibs(Builder& builder);  ///< With costal cartilage.
void AddVessels(Builder& builder);
void AddLesion(Builder& builder);
void AddBileDucts(Builder& builder);  ///< Dilated, and only if they are.
void AddOrgans(Builder& builder);
void AddBowel(Builder& builder);
void AddMuscles(Builder& builder);

}  // namespace acus::phantom
