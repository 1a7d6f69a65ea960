// The liver phantom of Fortmeier-2016, section 4.1, for the upper half of its figure 5: by
// algorithm 1 as printed along one axis, and by the springs of lib/acus/physics/tissue.
#pragma once

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>
#include <vector>

#include "acus/data/volume/labels.h"
#include "acus/physics/forces/laws/force_table.h"
#include "acus/physics/mechanics/elements/elasticity_table.h"
#include "acus/physics/tissue/spring_model.h"

namespace acus::testing_support {

/// The paper's constants; it does not tell the spacing of path nodes.
struct FortmeierLiver {
  static constexpr double kA1 = 0.048;         ///< N/mm
  static constexpr double kA2 = 0.0052;        ///< N/mm^2
  static constexpr double kCapsuleN = 2.5;     ///< f_cut at the capsule.
  static constexpr double kInsideN = 1.0;      ///< f_cut inside.
  static constexpr double kFrictionN = 0.025;  ///< R of a node.
  static constexpr double kNodeNPerMm = 0.5;   ///< k of a node.
  static constexpr double kSpacingMm = 2.0;    ///< Delta p: chosen.
};

/// Eq. 4 to 7 to the letter for a needle that goes straight; the capsule is at 0.
class FortmeierAsPrinted {
 public:
  /// @return the force against insertion at this depth of the device, N.
  double Step(double device_mm) {
    using L = FortmeierLiver;
    const double travel_mm = device_mm - device_mm_;
    device_mm_ = device_mm;
    if (device_mm < 0.0 && tip_mm_ <= 0.0) {
      nodes_.clear();
      inside_ = false;
      tip_mm_ = 0.0;
      return 0.0;
    }
    const double ahead_mm = device_mm - tip_mm_;
    const double cut_n = inside_ ? L::kInsideN : L::kCapsuleN;
    const double advance_mm = tissue::TipAdvanceMm(ahead_mm, L::kA1, L::kA2, cut_n);
    if (advance_mm > 0.0 && !inside_) {
      inside_ = true;  // The capsule has given way: from here on the cutting force is the liver's.
      tip_mm_ += tissue::TipAdvanceMm(ahead_mm, L::kA1, L::kA2, L::kInsideN);
    } else {
      tip_mm_ = std::max(0.0, tip_mm_ + advance_mm);
    }
    PlaceNodes();
    const double x = std::max(0.0, device_mm - tip_mm_);
    double force_n = (L::kA2 * x + L::kA1) * x;
    double before_mm = 0.0;
    for (std::size_t i = 0; i < nodes_.size(); ++i) {
      Node& node = nodes_[i];
      node.offset_mm =
          tissue::FrictionOffsetMm(node.offset_mm, travel_mm, L::kNodeNPerMm, L::kFrictionN);
      const double end_mm = i + 1 == nodes_.size() ? tip_mm_ : node.at_mm;
      force_n += L::kNodeNPerMm * (end_mm - before_mm) / L::kSpacingMm * node.offset_mm;
      before_mm = end_mm;
    }
    return force_n;
  }

  double tip_mm() const { return tip_mm_; }  ///< Of the path: behind the device while it presses.

 private:
  struct Node {
    double at_mm;
    double offset_mm = 0.0;
  };

  /// The last node is the tip; those before stay where they were put.
  void PlaceNodes() {
    constexpr double kSpacing = FortmeierLiver::kSpacingMm;
    if (nodes_.empty() && tip_mm_ > 0.0) nodes_.push_back({tip_mm_});
    if (nodes_.empty()) return;
    nodes_.back().at_mm = tip_mm_;
    const auto before = [&] { return nodes_.size() < 2 ? 0.0 : nodes_[nodes_.size() - 2].at_mm; };
    while (tip_mm_ - before() > 1.5 * kSpacing) {
      nodes_.insert(nodes_.end() - 1, {before() + kSpacing, nodes_.back().offset_mm});
    }
    while (nodes_.size() > 1 && tip_mm_ - before() < 0.5 * kSpacing) nodes_.erase(nodes_.end() - 2);
  }

  double device_mm_ = -1.0;
  double tip_mm_ = 0.0;
  bool inside_ = false;
  std::vector<Node> nodes_;  ///< From the capsule to the tip.
};

/// The same liver below z = 0 for the springs of lib/tissue: a shear modulus for which a node has
/// the paper's k, friction of R over the spacing, and a capsule.
/// @param as_printed  a1 and a2 inside, too, and k from the force table.
inline tissue::SpringModel FortmeierSprings(bool as_printed = false) {
  using L = FortmeierLiver;
  constexpr double kDiameterMm = 1.27;
  tissue::SpringSettings settings;
  settings.node_spacing_mm = L::kSpacingMm;
  const double per_modulus = 2.0 * std::numbers::pi * L::kSpacingMm /
                             std::log(settings.influence_radius_mm / (0.5 * kDiameterMm));
  const double shear_mpa = L::kNodeNPerMm / per_modulus;
  const double poisson = 0.45;
  nlohmann::json forces = {{"format", "acus-forces/1"},
                           {"reference_diameter_mm", kDiameterMm},
                           {"tissues",
                            {{{"tissue", "soft_tissue"}, {"source", "paper"}},
                             {{"tissue", "liver"},
                              {"source", "paper"},
                              {"a1_n_per_mm", L::kA1},
                              {"a2_n_per_mm2", L::kA2},
                              {"puncture_n", L::kCapsuleN},
                              {"cutting_n", L::kInsideN},
                              {"friction_n_per_mm", L::kFrictionN / L::kSpacingMm}}}}};
  if (as_printed) {
    nlohmann::json& liver = forces["tissues"][1];
    liver["cutting_a1_n_per_mm"] = L::kA1;
    liver["cutting_a2_n_per_mm2"] = L::kA2;
    liver["shaft_n_per_mm2"] = L::kNodeNPerMm / L::kSpacingMm;
  }
  const nlohmann::json elasticity = {
      {"format", "acus-elasticity/1"},
      {"tissues",
       {{{"tissue", "liver"},
         {"source", "paper"},
         {"youngs_modulus_kpa", as_printed ? 1.0 : 2e3 * shear_mpa * (1.0 + poisson)},
         {"poissons_ratio", poisson}}}}};
  forces::NeedleProperties needle;
  needle.length_mm = 150.0;
  needle.beam.outer_diameter_mm = kDiameterMm;
  needle.beam.youngs_modulus_mpa = 193e3;
  const volume::Label liver = volume::LabelOf("liver");
  std::bitset<256> labels;
  labels.set(liver);
  return {settings,
          forces::ForceTableFromJson(forces, "figure 5"),
          needle,
          mechanics::ElasticityTableFromJson(elasticity, "figure 5"),
          labels,
          [liver](const Eigen::Vector3d& p) -> volume::Label { return p.z() >= 0.0 ? liver : 0; }};
}

/// In at 5 mm/s to 40 mm, a pause of 2 s, out again, at 1 kHz: depth of the device, mm.
inline std::vector<double> FortmeierMotionMm() {
  std::vector<double> depth_mm;
  for (int n = 0; n <= 8400; ++n) depth_mm.push_back(-2.0 + 0.005 * n);
  for (int n = 0; n < 2000; ++n) depth_mm.push_back(40.0);
  for (int n = 0; n <= 8400; ++n) depth_mm.push_back(40.0 - 0.005 * n);
  return depth_mm;
}

}  // namespace acus::testing_support
