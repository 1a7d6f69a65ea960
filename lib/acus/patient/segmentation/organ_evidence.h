// What a CT shows for and against an organ that an atlas found.
#pragma once

#include <optional>
#include <string>
#include <vector>

namespace acus::segmentation {

/// Measured without a reference, on the grid of the registration. Shares are between 0 and 1.
/// "Expected": where the bent or shifted atlas has the organ.
struct OrganEvidence {
  std::string name;            ///< "liver", "kidney_left": as in OrganCheck.
  double edge_share = 0.0;     ///< Of the surface, at an edge of the CT.
  double barred_share = 0.0;   ///< Of what was expected, in bone, lung, gas, skin or air.
  double covered_share = 0.0;  ///< Of the organ, that the CT of at least one atlas patient shows.
  std::optional<double> self_check = {};  ///< Dice of atlas patients found by each other, mean.
};

inline constexpr double kRightOrganDice = 0.88;  ///< An organ counts as right from there.

/// The Dice with a reference, if the surface is right where it lies at an edge of the CT, and a
/// fixed distance beside it elsewhere (docs/models/segmentation.md).
double ExpectedDice(const OrganEvidence& evidence);

/// What speaks against the organ, for people; empty: nothing.
std::vector<std::string> DoubtsIn(const OrganEvidence& evidence);

}  // namespace acus::segmentation
