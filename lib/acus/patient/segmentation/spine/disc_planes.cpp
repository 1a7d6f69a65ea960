#include "acus/patient/segmentation/spine/disc_planes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "acus/data/volume/labels.h"
#include "acus/patient/segmentation/voxels/lps_axes.h"
#include "acus/patient/segmentation/voxels/trilinear.h"

namespace acus::segmentation {
namespace {

constexpr double kLineSmoothingMm = 7.5;
constexpr double kShortestLineMm = 30.0;
// The part of the column that is looked at, from the canal's middle: bodies are about 34 mm deep.
constexpr double kLookHalfWidthMm = 12.0;
constexpr double kLookFromMm = 12.0;
constexpr double kLookToMm = 28.0;
constexpr double kColumnGridMm = 2.0;
constexpr double kLeastHu = -150.0;
constexpr double kMostHu = 700.0;
constexpr double kNearestPlateMm = 2.0;
constexpr double kFarthestPlateMm = 7.0;
constexpr std::array kForwardTilts = {-0.36, -0.27, -0.18, -0.09, 0.0, 0.09, 0.18, 0.27, 0.36};
constexpr std::array kSidewaysTilts = {-0.18, -0.09, 0.0, 0.09, 0.18};
constexpr int kLeastPitch = 14;  // Steps of 1 mm.
constexpr int kMostPitch = 46;
constexpr double kPitchWeight = 6.0;      ///< Of the square of a relative change of the pitch.
constexpr double kLeastDiscShare = 0.45;  ///< Of the contrast that the clearest discs nearby have.
constexpr double kTiltCost = 0.4;         ///< Share of the contrast lost per radian.
constexpr double kLeastContrastHu = 12.0;

/// The column of bodies, straightened: HU by place across it and step along the canal.
struct Column {
  struct Place {
    double left_mm, forward_mm;
  };
  std::vector<Place> places;
  std::vector<std::vector<float>> hu;  ///< By place, then by step.
};

Column Straightened(const volume::CtVolume& ct, const CanalLine& canal) {
  Column column;
  const auto index_from_ct = ct.geometry.index_from_ct();
  for (double left = -kLookHalfWidthMm; left <= kLookHalfWidthMm; left += kColumnGridMm) {
    for (double forward = kLookFromMm; forward <= kLookToMm; forward += kColumnGridMm) {
      column.places.push_back({left, forward});
      auto& line = column.hu.emplace_back();
      for (std::size_t s = 0; s < canal.points_mm.size(); ++s) {
        const Eigen::Vector3d p =
            canal.points_mm[s] + forward * canal.forward[s] + left * canal.Left(s);
        line.push_back(
            static_cast<float>(std::clamp(TrilinearAt(ct, index_from_ct * p), kLeastHu, kMostHu)));
      }
    }
  }
  return column;
}

/// Mean HU over planes of one tilt, by step; not a number where the plane leaves the canal's line.
std::vector<double> Profile(const Column& column, double forward_tilt, double sideways_tilt) {
  const std::size_t n = column.hu.front().size();
  std::vector<double> sum(n, 0.0);
  for (std::size_t p = 0; p < column.places.size(); ++p) {
    const auto& place = column.places[p];
    const double rise = forward_tilt * place.forward_mm + sideways_tilt * place.left_mm;
    for (std::size_t s = 0; s < n; ++s) {
      const double at = std::clamp(static_cast<double>(s) + rise, 0.0, static_cast<double>(n - 1));
      const auto low = std::min(static_cast<std::size_t>(at), n - 2);
      const double part = at - static_cast<double>(low);
      sum[s] += (1.0 - part) * column.hu[p][low] + part * column.hu[p][low + 1];
    }
  }
  for (double& value : sum) value /= static_cast<double>(column.places.size());
  return sum;
}

struct Candidate {
  double contrast_hu = -std::numeric_limits<double>::infinity();
  double forward_tilt = 0.0;
  double sideways_tilt = 0.0;
};

std::vector<Candidate> CandidatesIn(const Column& column) {
  const std::size_t n = column.hu.front().size();
  std::vector<Candidate> best(n);
  const auto nearest = static_cast<std::size_t>(kNearestPlateMm);
  const auto farthest = static_cast<std::size_t>(kFarthestPlateMm);
  for (const double forward : kForwardTilts) {
    for (const double sideways : kSidewaysTilts) {
      const std::vector<double> profile = Profile(column, forward, sideways);
      for (std::size_t s = farthest; s + farthest < n; ++s) {
        const double middle = (profile[s - 1] + profile[s] + profile[s + 1]) / 3.0;
        double plates = -std::numeric_limits<double>::infinity();
        for (std::size_t t = nearest; t <= farthest; ++t) {
          plates = std::max(plates, std::min(profile[s - t], profile[s + t]));
        }
        const double tilt = std::hypot(forward, sideways);
        const double contrast_hu = (plates - middle) * (1.0 - kTiltCost * tilt);
        if (contrast_hu > best[s].contrast_hu) best[s] = {contrast_hu, forward, sideways};
      }
    }
  }
  return best;
}

/// Steps of the best sequence. `gain`: of a disc at each step; a disc without gain costs.
std::vector<int> BestSequence(const std::vector<double>& gain) {
  const int n = static_cast<int>(gain.size());
  constexpr int kPitches = kMostPitch - kLeastPitch + 1;
  constexpr double kNoSequence = -1e30;
  const auto index = [](int s, int p) {
    return static_cast<std::size_t>(s) * kPitches + static_cast<std::size_t>(p);
  };
  // Best value of all sequences that end with a disc at s, the last distance being kLeastPitch + p.
  std::vector<double> value(static_cast<std::size_t>(n) * kPitches, kNoSequence);
  std::vector<int> from(value.size(), -1);
  double best_value = 0.0;
  std::pair<int, int> best{-1, -1};
  for (int s = 0; s < n; ++s) {
    for (int p = 0; p < kPitches; ++p) {
      const int pitch = kLeastPitch + p;
      const int before = s - pitch;
      if (before < 0) continue;
      double most = gain[static_cast<std::size_t>(before)];  // The first two discs.
      int way = -1;
      for (int q = 0; q < kPitches; ++q) {
        const double earlier = value[index(before, q)];
        if (earlier == kNoSequence) continue;
        const double change = static_cast<double>(p - q) / (kLeastPitch + q);
        if (earlier - kPitchWeight * change * change > most) {
          most = earlier - kPitchWeight * change * change;
          way = q;
        }
      }
      const std::size_t here = index(s, p);
      value[here] = most + gain[static_cast<std::size_t>(s)];
      from[here] = way;
      if (value[here] > best_value) {
        best_value = value[here];
        best = {s, p};
      }
    }
  }
  std::vector<int> steps;
  if (best.first < 0) return steps;
  auto [s, p] = best;
  while (true) {
    steps.push_back(s);
    const int way = from[index(s, p)];
    s -= kLeastPitch + p;
    if (way < 0) break;
    p = way;
  }
  steps.push_back(s);
  std::ranges::reverse(steps);
  return steps;
}

/// What a disc is nearby, by step: the median, over the stretches of 35 mm within 70 mm, of the
/// clearest candidate in each. Every vertebra has one disc in about that length.
std::vector<double> TypicalContrast(const std::vector<Candidate>& candidates) {
  const int n = static_cast<int>(candidates.size());
  std::vector<double> typical;
  for (int s = 0; s < n; ++s) {
    std::vector<double> peaks;
    for (int from = s - 70; from < s + 70; from += 35) {
      double most = 0.0;
      for (int t = std::max(from, 0); t < std::min(from + 35, n); ++t) {
        most = std::max(most, candidates[static_cast<std::size_t>(t)].contrast_hu);
      }
      if (std::min(from + 35, n) - std::max(from, 0) >= 30) peaks.push_back(most);
    }
    std::ranges::sort(peaks);
    typical.push_back(peaks.empty() ? kLeastContrastHu
                                    : std::max(peaks[peaks.size() / 2], kLeastContrastHu));
  }
  return typical;
}

/// Means over adjacent points in a Gaussian along a list of points.
std::vector<Eigen::Vector3d> Smoothed(const std::vector<Eigen::Vector3d>& points, double sigma) {
  const int n = static_cast<int>(points.size());
  const int reach = static_cast<int>(std::ceil(3.0 * sigma));
  std::vector<Eigen::Vector3d> out;
  for (int i = 0; i < n; ++i) {
    // As far to both sides, so that the ends do not bend inwards.
    const int side = std::min({reach, i, n - 1 - i});
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    double weights = 0.0;
    for (int d = -side; d <= side; ++d) {
      const double w = std::exp(-0.5 * d * d / (sigma * sigma));
      sum += w * points[static_cast<std::size_t>(i + d)];
      weights += w;
    }
    out.push_back(sum / weights);
  }
  return out;
}

}  // namespace

CanalLine CanalLineOf(const volume::LabelMap& tissues) {
  const volume::Geometry& g = tissues.geometry;
  const volume::Label canal = volume::LabelOf("spinal_canal");
  const auto ct_from_index = g.ct_from_index();
  // Means by height, so that any order of the axes is served.
  constexpr double kBinMm = 2.0;
  std::vector<Eigen::Vector3d> sums;
  std::vector<int> counts;
  const Eigen::Vector3d last = ct_from_index * (g.size.cast<double>() - 1.0).matrix();
  CanalLine line;
  line.axes = Turned(g, LpsOrder(g)).direction;
  const Eigen::Vector3d back = line.axes.col(1), up = line.axes.col(2);
  const double lowest = std::min(up.dot(ct_from_index.translation()), up.dot(last)) - 500.0;
  for (int k = 0; k < g.size[2]; ++k) {
    for (int j = 0; j < g.size[1]; ++j) {
      for (int i = 0; i < g.size[0]; ++i) {
        if (tissues.At(i, j, k) != canal) continue;
        const Eigen::Vector3d p = ct_from_index * Eigen::Vector3d(i, j, k);
        const auto bin = static_cast<std::size_t>((up.dot(p) - lowest) / kBinMm);
        if (bin >= sums.size()) {
          sums.resize(bin + 1, Eigen::Vector3d::Zero());
          counts.resize(bin + 1, 0);
        }
        sums[bin] += p;
        ++counts[bin];
      }
    }
  }
  std::vector<Eigen::Vector3d> raw;
  for (std::size_t bin = 0; bin < sums.size(); ++bin) {
    if (counts[bin] > 0) raw.emplace_back(sums[bin] / counts[bin]);
  }
  if (raw.size() < 2 || up.dot(raw.back() - raw.front()) < kShortestLineMm) return line;
  const double sigma = kLineSmoothingMm / kBinMm;
  raw = Smoothed(raw, sigma);
  // Steps of equal length.
  double left = 0.0;
  line.points_mm.push_back(raw.front());
  for (std::size_t n = 1; n < raw.size(); ++n) {
    const double length = (raw[n] - raw[n - 1]).norm();
    double at = line.step_mm - left;
    for (; at <= length; at += line.step_mm) {
      line.points_mm.emplace_back(raw[n - 1] + at / length * (raw[n] - raw[n - 1]));
    }
    left = length - (at - line.step_mm);
  }
  const std::size_t n = line.points_mm.size();
  for (std::size_t s = 0; s < n; ++s) {
    const std::size_t reach = std::min(
        {std::size_t{10}, std::max<std::size_t>(s, 1), std::max<std::size_t>(n - 1 - s, 1)});
    const auto& above = line.points_mm[std::min(s + reach, n - 1)];
    const auto& below = line.points_mm[s - std::min(s, reach)];
    const Eigen::Vector3d tangent = (above - below).normalized();
    line.tangent.push_back(tangent);
    line.forward.push_back((back.dot(tangent) * tangent - back).normalized());
  }
  return line;
}

std::vector<DiscPlane> FindDiscPlanes(const volume::CtVolume& ct, const CanalLine& canal) {
  if (canal.points_mm.size() < 3 * static_cast<std::size_t>(kFarthestPlateMm)) return {};
  const std::vector<Candidate> candidates = CandidatesIn(Straightened(ct, canal));
  const std::vector<double> typical_hu = TypicalContrast(candidates);
  std::vector<double> gain;
  for (std::size_t s = 0; s < candidates.size(); ++s) {
    gain.push_back(std::clamp(candidates[s].contrast_hu / typical_hu[s], -1.0, 1.2) -
                   kLeastDiscShare);
  }
  std::vector<DiscPlane> planes;
  for (const int step : BestSequence(gain)) {
    const auto s = static_cast<std::size_t>(step);
    const Candidate& c = candidates[s];
    const Eigen::Vector3d normal =
        canal.tangent[s] - c.forward_tilt * canal.forward[s] - c.sideways_tilt * canal.Left(s);
    planes.push_back({canal.points_mm[s], normal.normalized(), c.contrast_hu, step});
  }
  return planes;
}

}  // namespace acus::segmentation
