#include "acus/data/volume/dicom_series.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "acus/base/core/parallel.h"
#include "acus/base/core/text_table.h"
#include "acus/base/math/statistics.h"
#include "acus/data/volume/dicom_frame.h"
#include "acus/data/volume/dicom_groups.h"
#include "acus/data/volume/dicom_header.h"
#include "acus/data/volume/dicom_pixels.h"
#include "acus/data/volume/scalar_file.h"
#include "acus/data/volume/volume_io.h"

namespace acus::volume {
namespace {

namespace fs = std::filesystem;

constexpr double kMaxStepDeviation = 0.02;  ///< Of slice steps, relative to their median.
constexpr double kMaxShiftMm = 0.05;        ///< Per slice; below it a tilt is rounding.

using Group = SliceGroup;

bool IsCtLike(const Group& group) {
  return group.headers.size() >= 3 && group.headers.front().is_placed &&
         (group.headers.front().modality == "CT" || group.headers.front().modality.empty());
}

std::string Listed(const std::vector<Group>& groups) {
  std::string text;
  for (const Group& group : groups) {
    text += Message("\n  ", group.series.uid, "  ", group.headers.size(), " slices of ",
                    group.series.image_size[0], " x ", group.series.image_size[1], "  ",
                    group.headers.front().modality, "  ", group.series.description);
  }
  return text;
}

Group Chosen(const fs::path& folder, const std::string& wanted, std::vector<Group> groups) {
  std::vector<Group> fitting;
  for (Group& group : groups) {
    const bool exact = group.series.uid == wanted;
    const bool part = group.series.uid.find(wanted) != std::string::npos ||
                      group.series.description.find(wanted) != std::string::npos;
    if (exact) return std::move(group);
    if (wanted.empty() ? IsCtLike(group) : part) fitting.push_back(group);
  }
  ACUS_REQUIRE(!fitting.empty(), folder.string(), ": ",
               wanted.empty() ? "no series looks like a CT (at least 3 placed slices, modality CT)"
                              : Message("no series is called '", wanted, "'"),
               "; there are:", Listed(groups));
  ACUS_REQUIRE(fitting.size() == 1, folder.string(), ": ", fitting.size(), " series ",
               wanted.empty() ? "look like a CT" : Message("fit '", wanted, "'"),
               "; choose one with --series and its UID or a part of it (/patient/series of a "
               "scenario):",
               Listed(fitting));
  return std::move(fitting.front());
}

/// How the slices lie: the step along the normal, and the shift within the plane from one slice to
/// the next (of a tilted gantry), in mm along columns and rows.
struct Stack {
  double step_mm = 0.0;
  bool is_rounded = false;  ///< Positions are rounded to 0.1 mm; the step is their mean.
  Eigen::Array2d shift_mm = Eigen::Array2d::Zero();
};

/// The even step that places along the normal show which are rounded to 0.1 mm; nothing if they
/// are not, as where a slice is missing.
std::optional<double> StepOfRounded(const std::vector<DicomHeader>& headers) {
  constexpr double kRoundingMm = 0.06;
  constexpr double kLeastStepMm = 0.3;  // Below it, a missing slice would look like rounding.
  const Eigen::Vector3d normal = NormalOf(headers.front());
  const double count = static_cast<double>(headers.size() - 1);
  double step_mm = (headers.back().position_mm - headers.front().position_mm).dot(normal) / count;
  const auto& first_at = headers.front().slice_location_mm;
  const auto& last_at = headers.back().slice_location_mm;
  if (first_at && last_at) {
    const double stated_mm = std::abs(*last_at - *first_at) / count;
    if (std::abs(stated_mm - step_mm) * count < 2.0 * kRoundingMm) step_mm = stated_mm;
  }
  if (step_mm < kLeastStepMm) return {};
  for (std::size_t s = 0; s < headers.size(); ++s) {
    const double along_mm = (headers[s].position_mm - headers.front().position_mm).dot(normal);
    const double off_mm = along_mm - step_mm * static_cast<double>(s);
    if (std::abs(off_mm) > 2.0 * kRoundingMm) return {};
  }
  return step_mm;
}

Stack StackOf(const fs::path& folder, const std::vector<DicomHeader>& headers) {
  const DicomHeader& first = headers.front();
  const Eigen::Vector3d normal = NormalOf(first);
  std::vector<double> steps;
  for (std::size_t s = 1; s < headers.size(); ++s) {
    steps.push_back((headers[s].position_mm - headers[s - 1].position_mm).dot(normal));
  }
  const double typical = math::Median(steps);
  const bool is_even = std::ranges::all_of(steps, [typical](double step) {
    return std::abs(step - typical) <= kMaxStepDeviation * typical + 1e-2;
  });
  const auto rounded_mm = is_even ? std::nullopt : StepOfRounded(headers);
  for (std::size_t s = 0; s < steps.size(); ++s) {
    const std::string between = Message(headers[s].file.filename().string(), " and ",
                                        headers[s + 1].file.filename().string());
    ACUS_REQUIRE(steps[s] > 1e-3, folder.string(), ": ", between, " lie at the same place (",
                 headers[s].position_mm.transpose(),
                 " mm); two scans or copies are mixed in this "
                 "series, keep one of them");
    ACUS_REQUIRE(rounded_mm || std::abs(steps[s] - typical) <= kMaxStepDeviation * typical + 1e-2,
                 folder.string(), ": the slices are not evenly spaced: ", steps[s], " mm between ",
                 between, ", ", typical, " mm elsewhere (", headers.size(),
                 " slices). Slices are "
                 "missing or it is a scan in blocks; export the whole series, or one block");
  }
  const Eigen::Vector3d span = headers.back().position_mm - first.position_mm;
  const double count = static_cast<double>(steps.size());
  Stack stack;
  stack.step_mm = rounded_mm.value_or(span.dot(normal) / count);
  stack.is_rounded = rounded_mm.has_value();
  const Eigen::Array2d shift_mm(span.dot(first.column_axis) / count,
                                span.dot(first.row_axis) / count);
  for (std::size_t s = 0; s < headers.size(); ++s) {
    const Eigen::Vector3d off = headers[s].position_mm - first.position_mm;
    const Eigen::Array2d in_plane(off.dot(first.column_axis), off.dot(first.row_axis));
    ACUS_REQUIRE((in_plane - shift_mm * static_cast<double>(s)).matrix().norm() < 0.5,
                 folder.string(), ": slice ", headers[s].file.filename().string(),
                 " does not lie above the adjacent slices; this series is not one straight stack");
  }
  if (shift_mm.matrix().norm() > kMaxShiftMm) stack.shift_mm = shift_mm;
  return stack;
}

/// out(x, y) = in(x - shift[0], y - shift[1]), linear, padding outside.
void PlaceShifted(const std::vector<std::int16_t>& slice, const DicomHeader& header,
                  const Eigen::Array2d& shift_px, CtVolume& ct, int k) {
  const auto at = [&](int x, int y) -> double {
    const bool inside = x >= 0 && y >= 0 && x < header.columns && y < header.rows;
    return inside
               ? slice[static_cast<std::size_t>(y) * header.columns + static_cast<std::size_t>(x)]
               : kPaddingHu;
  };
  for (int j = 0; j < ct.geometry.size[1]; ++j) {
    const double y = j - shift_px[1];
    const int y0 = static_cast<int>(std::floor(y));
    for (int i = 0; i < ct.geometry.size[0]; ++i) {
      const double x = i - shift_px[0];
      const int x0 = static_cast<int>(std::floor(x));
      const double fx = x - x0;
      const double fy = y - y0;
      const double value = (1 - fy) * ((1 - fx) * at(x0, y0) + fx * at(x0 + 1, y0)) +
                           fy * ((1 - fx) * at(x0, y0 + 1) + fx * at(x0 + 1, y0 + 1));
      ct.At(i, j, k) = static_cast<std::int16_t>(std::lround(value));
    }
  }
}

/// The grid that holds all slices, and the shift of the first slice in it.
std::pair<Geometry, Eigen::Array2d> GridOf(const std::vector<DicomHeader>& headers,
                                           const Stack& stack) {
  const DicomHeader& first = headers.front();
  const double last = static_cast<double>(headers.size() - 1);
  const Eigen::Array2d total_px = stack.shift_mm * last / first.spacing_mm;
  const Eigen::Array2d first_px = (-total_px).max(0.0).ceil();
  Geometry grid;
  grid.size = {first.columns + static_cast<int>(std::ceil(std::abs(total_px[0]))),
               first.rows + static_cast<int>(std::ceil(std::abs(total_px[1]))),
               static_cast<int>(headers.size())};
  grid.spacing_mm = {first.spacing_mm[0], first.spacing_mm[1], stack.step_mm};
  grid.direction << first.column_axis, first.row_axis, NormalOf(first);
  grid.origin_mm = first.position_mm - first.column_axis * (first_px[0] * first.spacing_mm[0]) -
                   first.row_axis * (first_px[1] * first.spacing_mm[1]);
  return {grid, first_px};
}

void RequireCtSlices(const fs::path& folder, const std::vector<DicomHeader>& headers) {
  for (const DicomHeader& header : headers) {
    ACUS_REQUIRE(header.is_placed, header.file.string(),
                 ": has no usable position, orientation "
                 "or pixel spacing, so it cannot be placed; export the original slices");
    ACUS_REQUIRE(header.num_frames == 1, header.file.string(), ": holds ", header.num_frames,
                 " frames without a position of each; export it as Enhanced CT or as single "
                 "slices");
  }
  const std::string& modality = headers.front().modality;
  ACUS_REQUIRE(modality == "CT" || modality.empty(), folder.string(), ": modality is ", modality,
               "; a CT is needed, because tissues are distinguished by Hounsfield units");
  ACUS_REQUIRE(headers.size() >= 3, folder.string(), ": the series has only ", headers.size(),
               " slices; at least 3 are needed");
}

/// "-512 to 3071": over all slices; "-" if the pixels cannot be decoded.
std::string ValueRange(const Group& group, const RunContext& context) {
  const auto count = static_cast<int>(group.headers.size());
  std::vector<std::pair<int, int>> ranges(group.headers.size());
  try {
    ParallelFor(count, context.num_threads, [&](int i) {
      const auto slice = DecodedSlice(group.headers[static_cast<std::size_t>(i)]);
      const auto [low, high] = std::ranges::minmax(slice);
      ranges[static_cast<std::size_t>(i)] = {low, high};
    });
  } catch (const InputError&) {
    return "-";
  }
  const int low = std::ranges::min(ranges, {}, &std::pair<int, int>::first).first;
  const int high = std::ranges::max(ranges, {}, &std::pair<int, int>::second).second;
  return Message(low, " to ", high);
}

std::vector<std::string> RowOf(const Group& group, const fs::path& folder,
                               const RunContext& context) {
  const DicomHeader& first = group.headers.front();
  std::string spacing = "-", field = "-";
  if (first.is_placed) {
    std::vector<double> steps_mm;
    for (std::size_t i = 1; i < group.headers.size(); ++i) {
      steps_mm.push_back(
          (group.headers[i].position_mm - group.headers[i - 1].position_mm).dot(NormalOf(first)));
    }
    const double step_mm = steps_mm.empty() ? 0.0 : math::Median(steps_mm);
    spacing = Message(RoundedText(first.spacing_mm[0], 3), " x ",
                      RoundedText(first.spacing_mm[1], 3), " x ", RoundedText(step_mm, 3));
    field = Message(std::lround(first.spacing_mm[0] * first.columns), " x ",
                    std::lround(first.spacing_mm[1] * first.rows), " x ",
                    std::lround(step_mm * static_cast<double>(group.headers.size())));
  }
  const std::string where = first.file.parent_path().lexically_relative(folder).string();
  return {std::to_string(group.headers.size()),
          Message(first.columns, " x ", first.rows),
          spacing,
          field,
          first.modality.empty() ? "-" : first.modality,
          ValueRange(group, context),
          where.empty() ? "." : where,
          group.series.description,
          group.series.uid};
}

}  // namespace

std::vector<DicomSeries> ListDicomSeries(const fs::path& folder) {
  std::vector<DicomSeries> series;
  for (Group& group : SliceGroupsIn(folder, 1)) series.push_back(std::move(group.series));
  return series;
}

DicomFrame FrameOfCt(const fs::path& ct, const std::string& series, int num_threads) {
  if (!fs::is_directory(ct) && (IsScalarFileName(ct) || !ReadDicomHeader(ct))) return {};
  const Group group = Chosen(ct, series, SliceGroupsIn(ct, num_threads));
  const DicomHeader& first = group.headers.front();
  DicomFrame frame;
  if (!first.frame_uid.empty()) frame.uids = {first.frame_uid};
  if (!first.series_uid.empty()) frame.series = {first.series_uid};
  return frame;
}

std::string SeriesTable(const fs::path& folder, const RunContext& context) {
  const auto groups = SliceGroupsIn(folder, context.num_threads);
  std::vector<std::vector<std::string>> rows;
  for (std::size_t i = 0; i < groups.size(); ++i) {
    context.Checkpoint("reading DICOM slices",
                       static_cast<double>(i) / static_cast<double>(groups.size()));
    rows.push_back(RowOf(groups[i], folder, context));
  }
  return TextTable({"slices", "pixels", "spacing mm", "field mm", "kind", "values HU", "folder",
                    "description", "UID"},
                   rows);
}

CtVolume ReadDicomCt(const fs::path& folder, const std::string& series, const RunContext& context) {
  context.Checkpoint("reading DICOM headers", 0.0);
  const Group group = Chosen(folder, series, SliceGroupsIn(folder, context.num_threads));
  const auto& headers = group.headers;
  RequireCtSlices(folder, headers);
  const Stack stack = StackOf(folder, headers);
  for (const std::string& note : group.notes) context.Warn(Message(folder.string(), ": ", note));
  if (stack.is_rounded) {
    context.Warn(Message(folder.string(),
                         ": positions of the slices are rounded to 0.1 mm; their "
                         "mean distance of ",
                         stack.step_mm, " mm is used"));
  }
  const auto [grid, first_px] = GridOf(headers, stack);
  const bool tilted = (stack.shift_mm != 0.0).any();
  if (tilted) {
    const double angle_rad = std::atan2(stack.shift_mm.matrix().norm(), stack.step_mm);
    context.Warn(Message(folder.string(), ": the gantry was tilted by ", angle_rad * 180.0 / M_PI,
                         " degrees; the slices are shifted onto a rectangular grid"));
  }
  CtVolume ct(grid, kPaddingHu);
  constexpr int kSlicesAtOnce = 16;
  const int count = static_cast<int>(headers.size());
  for (int begin = 0; begin < count; begin += kSlicesAtOnce) {
    context.Checkpoint("reading DICOM slices", begin / static_cast<double>(count));
    ParallelFor(std::min(kSlicesAtOnce, count - begin), context.num_threads, [&](int i) {
      const int k = begin + i;
      const DicomHeader& header = headers[static_cast<std::size_t>(k)];
      const auto slice = DecodedSlice(header);
      if (tilted) {
        PlaceShifted(slice, header, first_px + stack.shift_mm * k / header.spacing_mm, ct, k);
      } else {
        std::ranges::copy(slice,
                          ct.voxels.begin() + static_cast<std::ptrdiff_t>(grid.Index(0, 0, k)));
      }
    });
  }
  context.Checkpoint("reading DICOM slices", 1.0);
  return ct;
}

}  // namespace acus::volume
