#include "acus/patient/segmentation/spine_profile.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "acus/data/volume/labels.h"

namespace acus::segmentation {
namespace {

constexpr double kRegionGridMm = 2.0;
constexpr double kLeastShown = 0.9;  ///< Of a region; otherwise the CT does not show it.
constexpr int kFlankSteps = 3;       ///< Foramina are open at a disc or so far above and below it.
constexpr double kLeastPedicle = 0.65;
constexpr double kMostClosed = 0.5;
constexpr int kHighestVertebraSteps = 48;  ///< With the discs above and below.
// The wings of a sacrum, below the disc on it.
constexpr double kLeastWing = 0.65;
constexpr int kWingWithinSteps = 26;
constexpr double kLeastIlium = 0.15;
constexpr int kLeastIliumSteps = 10;
constexpr double kLeastTiltDeg = 12.0;

/// A part of the plane across the canal: distances from the canal's middle, mm.
struct Region {
  double aside_from, aside_to, forward_from, forward_to;
};
constexpr Region kPedicle{10.0, 16.0, 4.0, 10.0};
constexpr Region kWing{24.0, 40.0, 5.0, 25.0};
constexpr Region kIlium{45.0, 60.0, -25.0, 10.0};

/// The share of bone in a region on one side; negative if the volume does not hold it.
double ShareOfBone(const volume::LabelMap& tissues, const Eigen::Affine3d& index_from_ct,
                   const Eigen::Vector3d& middle_mm, const Eigen::Vector3d& aside,
                   const Eigen::Vector3d& forward, const Region& region) {
  static const volume::Label kBone = volume::LabelOf("bone");
  int all = 0, shown = 0, bone = 0;
  for (double a = region.aside_from; a <= region.aside_to; a += kRegionGridMm) {
    for (double f = region.forward_from; f <= region.forward_to; f += kRegionGridMm) {
      ++all;
      const Eigen::Array3i v =
          (index_from_ct * (middle_mm + a * aside + f * forward)).array().round().cast<int>();
      if (!tissues.geometry.Contains(v[0], v[1], v[2])) continue;
      ++shown;
      bone += tissues.At(v[0], v[1], v[2]) == kBone ? 1 : 0;
    }
  }
  return shown < kLeastShown * all ? -1.0 : static_cast<double>(bone) / shown;
}

/// The least share of bone in the foramina at a disc.
double ClosedAt(const SpineProfile& profile, const DiscPlane& disc) {
  double least = 1.0;
  for (int s = disc.step - kFlankSteps; s <= disc.step + kFlankSteps; ++s) {
    least = std::min(least, std::max(profile.At(s).pedicle, 0.0));
  }
  return least;
}

}  // namespace

SpineProfile::SpineProfile(const CanalLine& line, const volume::LabelMap& tissues) {
  if (line.points_mm.empty()) return;
  const Eigen::Affine3d index_from_ct = tissues.geometry.index_from_ct();
  const auto count = static_cast<int>(line.points_mm.size());
  for (int step = -kBelowSteps; step < count; ++step) {
    const auto on_line = static_cast<std::size_t>(std::max(step, 0));
    const Eigen::Vector3d middle =
        line.points_mm[on_line] + (step < 0 ? Eigen::Vector3d(step * line.step_mm * line.tangent[0])
                                            : Eigen::Vector3d(Eigen::Vector3d::Zero()));
    const Eigen::Vector3d left = line.Left(on_line);
    const auto lesser = [&](const Region& region) {
      const auto share = [&](const Eigen::Vector3d& aside) {
        return ShareOfBone(tissues, index_from_ct, middle, aside, line.forward[on_line], region);
      };
      return std::min(share(left), share(-left));
    };
    at_.push_back({lesser(kPedicle), lesser(kWing), lesser(kIlium)});
  }
}

BesideCanal SpineProfile::At(int step) const {
  const int n = step + kBelowSteps;
  if (n < 0 || n >= static_cast<int>(at_.size())) return {-1.0, -1.0, -1.0};
  return at_[static_cast<std::size_t>(n)];
}

bool IsOpenAt(const SpineProfile& profile, const DiscPlane& disc) {
  return ClosedAt(profile, disc) <= kMostClosed;
}

int DropDiscsWithinVertebrae(const SpineProfile& profile, std::vector<DiscPlane>& discs) {
  int dropped = 0;
  for (std::size_t n = 0; n < discs.size();) {
    const bool has_lower = n > 0, has_upper = n + 1 < discs.size();
    const bool within = ClosedAt(profile, discs[n]) >= kLeastPedicle && (has_lower || has_upper) &&
                        (!has_lower || IsOpenAt(profile, discs[n - 1])) &&
                        (!has_upper || IsOpenAt(profile, discs[n + 1]));
    const int height = has_lower && has_upper ? discs[n + 1].step - discs[n - 1].step : 0;
    if (!within || height > kHighestVertebraSteps) {
      ++n;
      continue;
    }
    discs.erase(discs.begin() + static_cast<std::ptrdiff_t>(n));
    ++dropped;
  }
  return dropped;
}

std::optional<std::size_t> DiscOnSacrum(const SpineProfile& profile, const CanalLine& line,
                                        const std::vector<DiscPlane>& discs) {
  const double least_lean = std::sin(kLeastTiltDeg * std::numbers::pi / 180.0);
  for (std::size_t n = discs.size(); n-- > 0;) {
    double wing = 0.0;
    int ilium_steps = 0;
    for (int s = discs[n].step - kWingWithinSteps; s < discs[n].step; ++s) {
      wing = std::max(wing, profile.At(s).wing);
      ilium_steps += profile.At(s).ilium >= kLeastIlium ? 1 : 0;
    }
    const bool leans = -discs[n].normal.dot(line.axes.col(1)) >= least_lean;
    if (leans && wing >= kLeastWing && ilium_steps >= kLeastIliumSteps) return n;
  }
  return std::nullopt;
}

}  // namespace acus::segmentation
