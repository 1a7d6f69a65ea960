#include "acus/scene/effects/tubes/centrelines.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <string>

#include "acus/base/core/csv.h"
#include "acus/base/core/error.h"

namespace acus::effects {
namespace {

constexpr std::size_t kLeastSlices = 5;
/// Cross-sections with a larger ratio of axes belong to a vessel that lies in the slice.
constexpr double kLargestAspect = 3.0;

/// An ellipse with the second moments of a connected part of a slice.
struct Section {
  Eigen::Vector2d centre_mm;  ///< Along i and j of the map.
  double radius_mm;           ///< The smaller half axis.
};

/// Removes the connected part that holds (i, j) from `free`, in steps along i and j.
std::vector<Eigen::Vector2i> TakePart(std::vector<bool>& free, int width, int height, int i,
                                      int j) {
  std::vector<Eigen::Vector2i> part{{i, j}};
  const auto at = [&](int x, int y) {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(width) +
           static_cast<std::size_t>(x);
  };
  free[at(i, j)] = false;
  for (std::size_t n = 0; n < part.size(); ++n) {
    for (const auto& step : {Eigen::Vector2i(1, 0), Eigen::Vector2i(-1, 0), Eigen::Vector2i(0, 1),
                             Eigen::Vector2i(0, -1)}) {
      const Eigen::Vector2i next = part[n] + step;
      if (next.x() < 0 || next.y() < 0 || next.x() >= width || next.y() >= height) continue;
      if (!free[at(next.x(), next.y())]) continue;
      free[at(next.x(), next.y())] = false;
      part.push_back(next);
    }
  }
  return part;
}

std::vector<Section> SectionsOf(const volume::LabelMap& labels, volume::Label tissue, int k) {
  const int width = labels.geometry.size[0];
  const int height = labels.geometry.size[1];
  const Eigen::Vector2d spacing_mm = labels.geometry.spacing_mm.head<2>().matrix();
  std::vector<bool> free;
  for (int j = 0; j < height; ++j) {
    for (int i = 0; i < width; ++i) free.push_back(labels.At(i, j, k) == tissue);
  }
  std::vector<Section> sections;
  for (std::size_t n = 0; n < free.size(); ++n) {
    if (!free[n]) continue;
    const int i = static_cast<int>(n) % width;
    const int j = static_cast<int>(n) / width;
    const auto part = TakePart(free, width, height, i, j);
    const double count = static_cast<double>(part.size());
    Eigen::Vector2d mean_mm = Eigen::Vector2d::Zero();
    for (const auto& pixel : part) mean_mm += spacing_mm.cwiseProduct(pixel.cast<double>()) / count;
    // The second moments of a single pixel about its centre.
    Eigen::Matrix2d moments_mm2 = (spacing_mm.array().square() / 12.0).matrix().asDiagonal();
    for (const auto& pixel : part) {
      const Eigen::Vector2d off_mm = spacing_mm.cwiseProduct(pixel.cast<double>()) - mean_mm;
      moments_mm2 += off_mm * off_mm.transpose() / count;
    }
    const Eigen::Vector2d axes_mm =
        2.0 * Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d>(moments_mm2).eigenvalues().cwiseSqrt();
    if (axes_mm[0] < spacing_mm.maxCoeff() || axes_mm[1] > kLargestAspect * axes_mm[0]) continue;
    sections.push_back({mean_mm, axes_mm[0]});
  }
  return sections;
}

/// Sections of one vessel, in consecutive slices.
struct Track {
  int first_slice;
  std::vector<Section> sections;
};

/// A mean over five slices smooths the steps between voxels; symmetrically fewer at the ends.
Centreline LineOf(const Track& track, const volume::Geometry& geometry) {
  const Eigen::Affine3d ct_from_index = geometry.ct_from_index();
  Centreline line;
  const int count = static_cast<int>(track.sections.size());
  for (int n = 0; n < count; ++n) {
    const int half = std::min({2, n, count - 1 - n});
    Eigen::Vector2d mean_mm = Eigen::Vector2d::Zero();
    double radius_mm = 0.0;
    for (int m = n - half; m <= n + half; ++m) {
      const Section& section = track.sections[static_cast<std::size_t>(m)];
      mean_mm += section.centre_mm / (2.0 * half + 1.0);
      radius_mm += section.radius_mm / (2.0 * half + 1.0);
    }
    line.point_in_ct_mm.emplace_back(ct_from_index *
                                     Eigen::Vector3d(mean_mm.x() / geometry.spacing_mm[0],
                                                     mean_mm.y() / geometry.spacing_mm[1],
                                                     track.first_slice + n));
    line.radius_mm.push_back(radius_mm);
  }
  return line;
}

}  // namespace

std::vector<Centreline> ReadCentrelines(const std::filesystem::path& path) {
  const CsvTable table(path);
  const auto names = table.Texts("vessel");
  const auto x_mm = table.Numbers("x_mm");
  const auto y_mm = table.Numbers("y_mm");
  const auto z_mm = table.Numbers("z_mm");
  const auto radius_mm = table.Numbers("radius_mm");
  std::vector<Centreline> lines;
  for (std::size_t row = 0; row < table.num_rows(); ++row) {
    ACUS_REQUIRE(radius_mm[row] > 0.0, table.Where(row), ": radius_mm is ", radius_mm[row],
                 "; it must be above 0");
    if (row == 0 || names[row] != names[row - 1]) {
      ACUS_REQUIRE(lines.empty() || lines.back().radius_mm.size() >= 2, table.Where(row - 1),
                   ": vessel '", names[row - 1],
                   "' has one point; at least two are needed, one after the other");
      lines.emplace_back();
    }
    lines.back().point_in_ct_mm.emplace_back(x_mm[row], y_mm[row], z_mm[row]);
    lines.back().radius_mm.push_back(radius_mm[row]);
  }
  ACUS_REQUIRE(!lines.empty() && lines.back().radius_mm.size() >= 2, path.string(),
               ": the last vessel has fewer than two points");
  return lines;
}

std::vector<Centreline> CentrelinesOf(const volume::LabelMap& labels, volume::Label tissue) {
  std::vector<Track> open;
  std::vector<Track> done;
  for (int k = 0; k <= labels.geometry.size[2]; ++k) {
    std::vector<Section> sections;
    if (k < labels.geometry.size[2]) sections = SectionsOf(labels, tissue, k);
    std::vector<Track> next;
    for (Track& track : open) {
      // The nearest overlapping section extends the vessel; other sections start new vessels.
      const Section& last = track.sections.back();
      const auto nearest = std::ranges::min_element(sections, {}, [&last](const Section& s) {
        return (s.centre_mm - last.centre_mm).norm();
      });
      if (nearest != sections.end() &&
          (nearest->centre_mm - last.centre_mm).norm() < last.radius_mm + nearest->radius_mm) {
        track.sections.push_back(*nearest);
        sections.erase(nearest);
        next.push_back(std::move(track));
      } else if (track.sections.size() >= kLeastSlices) {
        done.push_back(std::move(track));
      }
    }
    for (const Section& section : sections) next.push_back({k, {section}});
    open = std::move(next);
  }
  std::vector<Centreline> lines;
  for (const Track& track : done) lines.push_back(LineOf(track, labels.geometry));
  return lines;
}

}  // namespace acus::effects
