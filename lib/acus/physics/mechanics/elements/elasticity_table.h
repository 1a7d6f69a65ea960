// How stiff each tissue is: configs/elasticity.
#pragma once

#include <array>
#include <bitset>
#include <cstdint>
#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "acus/data/volume/labels.h"
#include "acus/physics/mechanics/elements/hyperelastic_law.h"
#include "acus/physics/mechanics/elements/membrane.h"
#include "acus/physics/mechanics/elements/relaxation.h"

namespace acus::mechanics {

/// Constants of an isotropic linear elastic solid.
struct ElasticTissue {
  double youngs_modulus_mpa = 0.0;
  double poissons_ratio = 0.0;

  double ShearModulusMpa() const { return youngs_modulus_mpa / (2.0 * (1.0 + poissons_ratio)); }
  double BulkModulusMpa() const {
    return youngs_modulus_mpa / (3.0 * (1.0 - 2.0 * poissons_ratio));
  }
};

/// Elastic constants by label. There is no fallback: a stiffness that was not chosen would change
/// every force without a word.
struct ElasticityTable {
  std::string file;  ///< Where it was read, for messages.
  std::string description;
  std::array<ElasticTissue, 256> tissue{};
  std::array<HyperelasticLaw, 256> law{};  ///< At large strain; neo_hookean where none is given.
  std::bitset<256> named;                  ///< Labels that the file has a row for.
  /// On surfaces of tissues; ascending by tissue, one per tissue at most. Of 3D meshes only.
  std::vector<Membrane> membranes;
  /// For tissues with a membrane: what the solid beneath it is like; others are not in it.
  std::array<ElasticTissue, 256> beneath{};
  std::bitset<256> has_beneath;
  /// Geometric standard deviation of the stiffness between patients; 1 or less: all have the same.
  std::array<double, 256> between_patients_gsd{};
  Relaxation relaxation;  ///< Of fe_2d and fe_3d; the moduli are those of fast deformation.

  /// @throws InputError that names tissue, file and remedy if there is no row for `label`.
  const ElasticTissue& At(volume::Label label) const;

  /// The solid of a tissue where its membrane is a shell of its own; At() where it has none.
  /// @throws InputError as At.
  const ElasticTissue& SolidAt(volume::Label label) const;

  /// Null: none between this tissue and what is on its other side (0: outside the body).
  const Membrane* MembraneOf(volume::Label covered, volume::Label beyond) const;

  /// The table of one patient: all moduli of a tissue and of its membrane, and the membrane's
  /// tension, times math::PatientFactor of its between_patients_gsd. Poisson's ratios and
  /// exponents stay. Seed 0: the table itself.
  ElasticityTable OfPatient(std::uint64_t seed) const;

  /// True if OfPatient changes anything.
  bool VariesBetweenPatients() const noexcept;
};

/// Reads configs/elasticity/*.json (format acus-elasticity/1). @throws InputError listing all
/// problems.
ElasticityTable ReadElasticityTable(const std::filesystem::path& path);

/// The same for a document in memory; `label` stands for the file name in messages.
ElasticityTable ElasticityTableFromJson(nlohmann::json document, const std::string& label);

}  // namespace acus::mechanics
