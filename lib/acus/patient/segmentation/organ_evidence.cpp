#include "acus/patient/segmentation/organ_evidence.h"

#include <algorithm>

#include "acus/base/core/error.h"
#include "acus/base/core/text_table.h"

namespace acus::segmentation {
namespace {

/// How far the surface lies from that of a reference where no edge of the CT holds it: fitted to
/// the cases of the totalseg example in testdata/organ_evidence.csv.
constexpr double kFreeSurfaceMm = 11.0;
constexpr double kMostExpected = 0.95;  // More was hardly ever measured.
constexpr double kLeastCovered = 0.8;
constexpr double kMostBarred = 0.15;

/// Surface by volume, 1/mm: of balls of 1500 ml, 160 ml and 200 ml.
double SurfacePerVolume(const std::string& organ) {
  if (organ == "liver") return 0.042;
  return organ == "spleen" ? 0.083 : 0.089;
}

std::string ShareText(double share) {
  return FixedText(100.0 * share, 0) + " %";
}

}  // namespace

double ExpectedDice(const OrganEvidence& evidence) {
  const double free_share = 1.0 - evidence.edge_share;
  return std::clamp(1.0 - kFreeSurfaceMm * SurfacePerVolume(evidence.name) * free_share, 0.0,
                    kMostExpected);
}

std::vector<std::string> DoubtsIn(const OrganEvidence& evidence) {
  std::vector<std::string> doubts;
  const double expected = ExpectedDice(evidence);
  if (expected < kRightOrganDice) {
    doubts.push_back(Message("only ", ShareText(evidence.edge_share),
                             " of its surface lies at an edge of the CT"));
  }
  if (evidence.covered_share < kLeastCovered) {
    doubts.push_back(Message("only ", ShareText(evidence.covered_share),
                             " of it lies where the atlas shows the body"));
  }
  if (evidence.barred_share > kMostBarred) {
    doubts.push_back(Message(ShareText(evidence.barred_share),
                             " of where the atlas expects it are bone, lung, gas, skin or air"));
  }
  if (evidence.self_check && *evidence.self_check < kRightOrganDice) {
    doubts.push_back(Message("the patients of the atlas find it in each other with Dice ",
                             FixedText(*evidence.self_check, 2)));
  }
  return doubts;
}

}  // namespace acus::segmentation
