#include "acus/data/volume/structure_set.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <set>
#include <utility>

#include "acus/base/core/error.h"
#include "acus/base/core/words.h"
#include "acus/data/volume/dicom_header.h"
#include "acus/data/volume/dicom_items.h"

namespace acus::volume {
namespace {

namespace fs = std::filesystem;

constexpr std::uint32_t kRois = 0x30060020U;
constexpr std::uint32_t kRoiNumber = 0x30060022U;
constexpr std::uint32_t kRoiFrame = 0x30060024U;
constexpr std::uint32_t kRoiName = 0x30060026U;
constexpr std::uint32_t kRoiContours = 0x30060039U;
constexpr std::uint32_t kContours = 0x30060040U;
constexpr std::uint32_t kContourType = 0x30060042U;
constexpr std::uint32_t kNumberOfPoints = 0x30060046U;
constexpr std::uint32_t kContourData = 0x30060050U;
constexpr std::uint32_t kObservations = 0x30060080U;
constexpr std::uint32_t kReferencedRoi = 0x30060084U;
constexpr std::uint32_t kInterpretedType = 0x300600A4U;
constexpr std::uint32_t kRoiCode = 0x30060086U;
constexpr double kFlatMm = 0.1;       ///< Of a contour, across its plane.
constexpr double kOnePlaneMm = 0.01;  ///< Contours nearer than this are of one plane.

/// Interpreted types of what is planned or placed, not of what the patient has.
constexpr std::array<std::string_view, 13> kNoTissue = {
    "PTV",         "CTV",     "TREATED_VOLUME",  "IRRAD_VOLUME", "BOLUS",
    "SUPPORT",     "MARKER",  "REGISTRATION",    "ISOCENTER",    "FIXATION",
    "DOSE_REGION", "CONTROL", "DOSE_MEASUREMENT"};

using Points = std::vector<Eigen::Vector3d>;  ///< Continuous indices of the grid.

struct Roi {
  int number = 0;
  ValueName name;
  std::string type;
  std::string frame_uid;
  std::vector<Points> contours;
};

int WholeNumber(const DicomItem& item, std::uint32_t tag) {
  const auto value = item.Decimals(tag, 1);
  return value.empty() ? 0 : static_cast<int>(std::clamp(value[0], -1e9, 1e9));
}

const std::vector<DicomItem>& ItemsOf(const DicomItem& item, std::uint32_t sequence) {
  static const std::vector<DicomItem> kNone;
  const auto found = item.sequences.find(sequence);
  return found == item.sequences.end() ? kNone : found->second;
}

std::vector<Roi> RoisOf(const DicomItem& root) {
  std::vector<Roi> rois;
  for (const DicomItem& item : ItemsOf(root, kRois)) {
    Roi& roi = rois.emplace_back();
    roi.number = WholeNumber(item, kRoiNumber);
    roi.name.text = item.Text(kRoiName);
    roi.frame_uid = item.Text(kRoiFrame);
  }
  for (const DicomItem& item : ItemsOf(root, kObservations)) {
    const auto roi = std::ranges::find(rois, WholeNumber(item, kReferencedRoi), &Roi::number);
    if (roi == rois.end()) continue;
    roi->type = item.Text(kInterpretedType);
    const DicomItem* code = item.First(kRoiCode);
    if (code != nullptr && code->Text(0x00080102U) == "SCT") {
      roi->name.codes.push_back(code->Text(0x00080100U));
    }
  }
  return rois;
}

/// The points of a contour. @throws InputError if they are not triples of numbers.
Points PointsOf(const DicomItem& contour, const Roi& roi, const Eigen::Affine3d& index_from_ct,
                const fs::path& path) {
  const auto bytes = contour.values.find(kContourData);
  const int stated = WholeNumber(contour, kNumberOfPoints);
  if (bytes == contour.values.end()) {
    ACUS_REQUIRE(stated <= 0, path.string(), ": a contour of '", roi.name.text, "' states ", stated,
                 " points and holds none; export it again");
    return {};
  }
  const auto count = static_cast<std::size_t>(std::ranges::count(bytes->second, '\\')) + 1;
  const auto numbers = contour.Decimals(kContourData, count);
  ACUS_REQUIRE(numbers.size() == count && count % 3 == 0, path.string(), ": a contour of '",
               roi.name.text, "' is not a list of points (x\\y\\z\\...); export it again");
  ACUS_REQUIRE(stated <= 0 || count == 3 * static_cast<std::size_t>(stated), path.string(),
               ": a contour of '", roi.name.text, "' states ", stated, " points and holds ",
               count / 3, "; export it again");
  Points points;
  for (std::size_t n = 0; n < count; n += 3) {
    points.push_back(index_from_ct * Eigen::Vector3d(numbers[n], numbers[n + 1], numbers[n + 2]));
  }
  return points;
}

void ReadContours(const DicomItem& root, const Geometry& grid, const fs::path& path,
                  std::vector<Roi>& rois) {
  const Eigen::Affine3d index_from_ct = grid.index_from_ct();
  for (const DicomItem& item : ItemsOf(root, kRoiContours)) {
    const auto roi = std::ranges::find(rois, WholeNumber(item, kReferencedRoi), &Roi::number);
    ACUS_REQUIRE(roi != rois.end(), path.string(), ": has contours of the ROI ",
                 WholeNumber(item, kReferencedRoi), ", which it does not name; export it again");
    for (const DicomItem& contour : ItemsOf(item, kContours)) {
      const std::string type = contour.Text(kContourType);
      if (!type.starts_with("CLOSED")) continue;  // Points and open lines enclose nothing.
      Points points = PointsOf(contour, *roi, index_from_ct, path);
      const bool is_copy = std::ranges::find(roi->contours, points) != roi->contours.end();
      if (points.size() >= 3 && !is_copy) roi->contours.push_back(std::move(points));
    }
  }
}

/// A plane of contours, and a slice of the grid that it lies along.
struct Plane {
  double at = 0.0;  ///< Continuous index along the normal.
  std::vector<const Points*> contours;
};

double ThicknessMm(const Points& points, int axis, const Geometry& grid) {
  const auto [low, high] = std::ranges::minmax(points, {}, [&](const auto& p) { return p[axis]; });
  return (high[axis] - low[axis]) * grid.spacing_mm[axis];
}

/// The axis of the grid that all contours are perpendicular to.
int NormalAxis(const std::vector<Roi>& rois, const Geometry& grid, const fs::path& path) {
  std::array<double, 3> thickest_mm{};
  const Roi* first = nullptr;
  for (const Roi& roi : rois) {
    for (const Points& points : roi.contours) {
      if (first == nullptr) first = &roi;
      for (int axis = 0; axis < 3; ++axis) {
        double& thickest = thickest_mm[static_cast<std::size_t>(axis)];
        thickest = std::max(thickest, ThicknessMm(points, axis, grid));
      }
    }
  }
  ACUS_REQUIRE(first != nullptr, path.string(),
               ": has no closed contour; is it a set of points or lines?");
  const auto axis = std::ranges::min_element(thickest_mm) - thickest_mm.begin();
  ACUS_REQUIRE(thickest_mm[static_cast<std::size_t>(axis)] <= kFlatMm, path.string(),
               ": contours do not lie in planes of the CT: they reach over ",
               thickest_mm[static_cast<std::size_t>(axis)],
               " mm across its slices. Give the CT that they were drawn on, or export the "
               "structures as a label map (DICOM SEG, NIfTI)");
  return static_cast<int>(axis);
}

std::vector<Plane> PlanesOf(const Roi& roi, int axis, const Geometry& grid) {
  std::vector<std::pair<double, const Points*>> placed;
  for (const Points& points : roi.contours) placed.emplace_back(points.front()[axis], &points);
  std::ranges::stable_sort(placed, {}, &std::pair<double, const Points*>::first);
  std::vector<Plane> planes;
  for (const auto& [at, points] : placed) {
    if (planes.empty() || (at - planes.back().at) * grid.spacing_mm[axis] > kOnePlaneMm) {
      planes.push_back({.at = at, .contours = {}});
    }
    planes.back().contours.push_back(points);
  }
  return planes;
}

/// Distance between the planes of an ROI, in slices: the lower quartile, as planes that are missing
/// make distances larger.
double StepOf(const std::vector<Plane>& planes) {
  std::vector<double> steps;
  for (std::size_t n = 1; n < planes.size(); ++n) steps.push_back(planes[n].at - planes[n - 1].at);
  if (steps.empty()) return 1.0;
  const auto quartile = steps.begin() + static_cast<std::ptrdiff_t>(steps.size() / 4);
  std::ranges::nth_element(steps, quartile);
  return std::max(*quartile, 1.0);
}

/// Rows of pixels of one plane, and where contours cross them.
class PlaneFill {
 public:
  PlaneFill(const Geometry& grid, int axis)
      : u_((axis + 1) % 3), v_((axis + 2) % 3), columns_(grid.size[u_]), rows_(grid.size[v_]) {}

  int u() const { return u_; }
  int v() const { return v_; }

  /// Pixels (u, v) inside an odd number of contours. A centre on an edge belongs to what begins.
  std::vector<std::array<int, 2>> Inside(const Plane& plane) const {
    std::vector<std::vector<double>> crossings(static_cast<std::size_t>(rows_));
    for (const Points* points : plane.contours) {
      for (std::size_t n = 0; n < points->size(); ++n) {
        Edge((*points)[n], (*points)[(n + 1) % points->size()], crossings);
      }
    }
    std::vector<std::array<int, 2>> pixels;
    for (int row = 0; row < rows_; ++row) {
      auto& at = crossings[static_cast<std::size_t>(row)];
      std::ranges::sort(at);
      for (std::size_t n = 0; n + 1 < at.size(); n += 2) {
        const int end = Bounded(at[n + 1], columns_);
        for (int column = Bounded(at[n], columns_); column < end; ++column) {
          pixels.push_back({column, row});
        }
      }
    }
    return pixels;
  }

 private:
  /// The first whole number not below x, within 0 and `end`.
  static int Bounded(double x, int end) {
    return static_cast<int>(std::ceil(std::clamp(x, 0.0, static_cast<double>(end))));
  }

  void Edge(const Eigen::Vector3d& a, const Eigen::Vector3d& b,
            std::vector<std::vector<double>>& crossings) const {
    const auto [low, high] = std::minmax(a[v_], b[v_]);
    const int end = Bounded(high, rows_);
    for (int row = Bounded(low, rows_); row < end; ++row) {
      const double share = (row - a[v_]) / (b[v_] - a[v_]);
      crossings[static_cast<std::size_t>(row)].push_back(a[u_] + share * (b[u_] - a[u_]));
    }
  }

  int u_, v_;
  int columns_, rows_;
};

/// The slices of the grid for which a plane is the nearest one, within half of a step.
std::pair<int, int> SlicesOf(const std::vector<Plane>& planes, std::size_t n, double step,
                             int num_slices) {
  const double at = planes[n].at;
  const double from =
      n == 0 ? at - 0.5 * step : std::max(at - 0.5 * step, 0.5 * (planes[n - 1].at + at));
  const double to = n + 1 == planes.size()
                        ? at + 0.5 * step
                        : std::min(at + 0.5 * step, 0.5 * (planes[n + 1].at + at));
  // Rounding must not move a plane on a slice to the next one.
  const auto bounded = [&](double x) {
    return static_cast<int>(std::ceil(std::clamp(x - 1e-6, 0.0, static_cast<double>(num_slices))));
  };
  return {bounded(from), bounded(to)};
}

std::vector<std::uint32_t> VoxelsOf(const Roi& roi, int axis, const Geometry& grid) {
  const PlaneFill fill(grid, axis);
  const std::vector<Plane> planes = PlanesOf(roi, axis, grid);
  const double step = StepOf(planes);
  std::vector<std::uint32_t> voxels;
  for (std::size_t n = 0; n < planes.size(); ++n) {
    const auto [first, end] = SlicesOf(planes, n, step, grid.size[axis]);
    if (first >= end) continue;
    const auto pixels = fill.Inside(planes[n]);
    std::array<int, 3> index{};
    for (int slice = first; slice < end; ++slice) {
      index[static_cast<std::size_t>(axis)] = slice;
      for (const auto& [column, row] : pixels) {
        index[static_cast<std::size_t>(fill.u())] = column;
        index[static_cast<std::size_t>(fill.v())] = row;
        voxels.push_back(static_cast<std::uint32_t>(grid.Index(index[0], index[1], index[2])));
      }
    }
  }
  return voxels;
}

/// Omits the ROIs of another frame of reference, if one is of that of the CT.
void OmitOtherFrames(const std::vector<std::string>& frame_uids, std::vector<Roi>& rois,
                     std::vector<std::string>& omitted) {
  const auto is_of_ct = [&](const Roi& roi) {
    return std::ranges::find(frame_uids, roi.frame_uid) != frame_uids.end();
  };
  if (std::ranges::none_of(rois, is_of_ct)) return;
  std::erase_if(rois, [&](const Roi& roi) {
    const bool is_other = !roi.frame_uid.empty() && !is_of_ct(roi);
    if (is_other) omitted.push_back(roi.name.text + " (another frame of reference)");
    return is_other;
  });
}

}  // namespace

bool IsStructureSet(const fs::path& path) {
  const auto header = ReadDicomHeader(path);
  return header && header->modality == "RTSTRUCT";
}

NamedValues ReadStructureSet(const fs::path& path, const Geometry& grid,
                             const std::vector<std::string>& frame_uids) {
  ACUS_REQUIRE(grid.num_voxels() < 0xFFFFFFFFU, path.string(), ": the CT has ", grid.num_voxels(),
               " voxels; structures are read on grids of less than 2^32");
  const DicomDataSet data = ReadDicomDataSet(path);
  std::vector<Roi> rois = RoisOf(data.root);
  std::vector<std::string> omitted;
  ReadContours(data.root, grid, path, rois);
  OmitOtherFrames(frame_uids, rois, omitted);
  std::erase_if(rois, [&](const Roi& roi) {
    const bool is_tissue = std::ranges::find(kNoTissue, roi.type) == kNoTissue.end();
    if (!is_tissue) omitted.push_back(Message(roi.name.text, " (", roi.type, ")"));
    if (is_tissue && roi.contours.empty()) omitted.push_back(roi.name.text + " (no contour)");
    return !is_tissue || roi.contours.empty();
  });
  const int axis = NormalAxis(rois, grid, path);
  std::vector<NamedMask> masks;
  for (const Roi& roi : rois) {
    masks.push_back({.name = roi.name, .voxels = VoxelsOf(roi, axis, grid)});
    if (masks.back().voxels.empty()) omitted.push_back(roi.name.text + " (outside the CT)");
  }
  std::erase_if(masks, [](const NamedMask& mask) { return mask.voxels.empty(); });
  ACUS_REQUIRE(!masks.empty(), path.string(),
               ": its contours hold no voxel of the CT; are both of one study, and in the same "
               "frame of reference?");
  NamedValues map = Merged(masks, grid);
  map.named_by = "by the names of its ROIs";
  if (!omitted.empty()) map.named_by += "; omitted: " + Joined(omitted);
  return map;
}

}  // namespace acus::volume
