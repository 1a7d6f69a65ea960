#include "acus/data/volume/volume_io.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <cstring>
#include <limits>
#include <nlohmann/json.hpp>
#include <utility>

#include "acus/base/core/atomic_file.h"
#include "acus/base/core/input_file.h"
#include "acus/base/core/number_text.h"
#include "acus/data/volume/dicom_header.h"
#include "acus/data/volume/dicom_series.h"
#include "acus/data/volume/header_check.h"
#include "acus/data/volume/labels.h"
#include "acus/data/volume/scalar_file.h"
#include "acus/data/volume/segment_keys.h"
#include "acus/data/volume/vti_file.h"

namespace acus::volume {
namespace {

namespace fs = std::filesystem;

/// Calls use(i, value) for every scalar of a file, in its own type.
template <typename T, typename Use>
void ForEachOf(const ScalarFile& file, const Use& use) {
  for (std::size_t i = 0; i < file.bytes.size() / sizeof(T); ++i) {
    T value;
    std::memcpy(&value, &file.bytes[i * sizeof(T)], sizeof(T));
    use(i, value);
  }
}

template <typename Use>
void ForEach(const ScalarFile& file, const Use& use) {
  switch (file.type) {
    case ScalarType::kInt8:
      return ForEachOf<std::int8_t>(file, use);
    case ScalarType::kUint8:
      return ForEachOf<std::uint8_t>(file, use);
    case ScalarType::kInt16:
      return ForEachOf<std::int16_t>(file, use);
    case ScalarType::kUint16:
      return ForEachOf<std::uint16_t>(file, use);
    case ScalarType::kInt32:
      return ForEachOf<std::int32_t>(file, use);
    case ScalarType::kUint32:
      return ForEachOf<std::uint32_t>(file, use);
    case ScalarType::kInt64:
      return ForEachOf<std::int64_t>(file, use);
    case ScalarType::kUint64:
      return ForEachOf<std::uint64_t>(file, use);
    case ScalarType::kFloat32:
      return ForEachOf<float>(file, use);
    case ScalarType::kFloat64:
      return ForEachOf<double>(file, use);
  }
}

template <typename T>
std::int16_t HuFrom(T value) {
  if constexpr (std::is_floating_point_v<T>) {
    if (!std::isfinite(value)) return kPaddingHu;  // Resampling programs mark "no data" so.
    return static_cast<std::int16_t>(
        std::clamp(std::round(static_cast<double>(value)), -1024.0, 32767.0));
  } else {
    if (value < T{} && static_cast<std::int64_t>(value) < kPaddingHu) return kPaddingHu;
    const bool too_high = value > T{} && static_cast<std::uint64_t>(value) > 32767U;
    return too_high ? std::int16_t{32767} : static_cast<std::int16_t>(value);
  }
}

template <typename T>
std::int32_t IntegerFrom(T value, const fs::path& path) {
  if constexpr (std::is_floating_point_v<T>) {
    // Resampling and rescaling leave integers that are rounded to single precision.
    ACUS_REQUIRE(std::abs(value - std::round(value)) <= T{1e-3F} && std::abs(value) <= T{1 << 24},
                 path.string(), ": value ", value,
                 " is not an integer label; is this an image and not a label map?");
    value = std::round(value);
  } else {
    const bool too_large = value > T{} && static_cast<std::uint64_t>(value) > 0x7FFFFFFFU;
    const bool too_small = value < T{} && static_cast<std::int64_t>(value) < -0x7FFFFFFF;
    ACUS_REQUIRE(!too_large && !too_small, path.string(), ": label ", +value, " is too large");
  }
  return static_cast<std::int32_t>(value);
}

/// A CT without air or with only positive values was probably not stored in Hounsfield units.
void WarnIfNotHounsfield(const CtVolume& ct, const fs::path& path, const RunContext& context) {
  const auto [low, high] = std::ranges::minmax(ct.voxels);
  ACUS_REQUIRE(low < high, path.string(), ": all voxels have the value ", low,
               "; there is nothing in it");
  const auto shifted =
      std::ranges::count_if(ct.voxels, [](int hu) { return hu > 900 && hu < 1150; });
  ACUS_REQUIRE(
      low < -200 || static_cast<double>(shifted) < 0.2 * static_cast<double>(ct.voxels.size()),
      path.string(), ": the lowest value is ", low, " and most tissue lies near 1024, so ",
      "these are not Hounsfield units; subtract 1024 (the rescale intercept was lost)");
  if (low >= -200) {
    context.Warn(Message(path.string(), ": the lowest value is ", low,
                         ", so there is no air in it. "
                         "Are these Hounsfield units? (Some exports are shifted by 1024)"));
  }
}

/// Hounsfield units that were normalised, or attenuation.
/// @throws InputError if the values lie so near each other that they would be lost by rounding.
void RequireRangeOfCt(const ScalarFile& file, const fs::path& path) {
  constexpr double kLeastRange = 20.0;  // From air to tissue it is 1000.
  if (file.type != ScalarType::kFloat32 && file.type != ScalarType::kFloat64) return;
  double low = std::numeric_limits<double>::infinity(), high = -low;
  ForEach(file, [&](std::size_t, auto value) {
    if (!std::isfinite(static_cast<double>(value))) return;
    low = std::min(low, static_cast<double>(value));
    high = std::max(high, static_cast<double>(value));
  });
  ACUS_REQUIRE(!(high > low) || high - low >= kLeastRange, path.string(), ": its values lie from ",
               low, " to ", high,
               "; they are not in Hounsfield units, but normalised or attenuation. Export the CT "
               "in HU");
}

/// What the JSON file of BIDS or dcm2niix beside a NIfTI file says of its values.
/// @throws InputError if that is something else than a CT in HU.
void RequireCtBySidecar(const fs::path& path) {
  constexpr std::uintmax_t kMostBytes = 1U << 20U;
  const fs::path sidecar = path.parent_path() / (VolumeStem(path) + ".json");
  std::error_code error;
  const bool is_there = path.filename().string().find(".nii") != std::string::npos &&
                        fs::is_regular_file(sidecar, error) &&
                        fs::file_size(sidecar, error) <= kMostBytes;
  if (!is_there) return;
  const std::string bytes = ReadTextFile(sidecar);
  RequireJsonDepth(bytes, sidecar.string());
  const auto document = nlohmann::json::parse(bytes, nullptr, /*allow_exceptions=*/false);
  const auto text = [&](const char* key) {
    const bool has = document.is_object() && document.contains(key) && document[key].is_string();
    return has ? document[key].get<std::string>() : std::string();
  };
  const std::string modality = text("Modality");
  ACUS_REQUIRE(modality.empty() || modality == "CT", path.string(), ": is no CT: its Modality in ",
               sidecar.filename().string(), " is ", modality,
               ". A CT is needed, because tissues are distinguished by Hounsfield units");
  std::string units = text("Units");
  std::ranges::transform(units, units.begin(), [](unsigned char c) { return std::tolower(c); });
  ACUS_REQUIRE(units.empty() || units == "hu" || units.starts_with("hounsfield"), path.string(),
               ": its Units in ", sidecar.filename().string(), " are '", text("Units"),
               "'; Hounsfield units (HU) are needed");
}

/// What a DICOM file is that is given in place of a folder. @throws InputError unless it holds all
/// slices of a CT.
void RequireMultiFrameCt(const fs::path& path) {
  const auto header = ReadDicomHeader(path);
  if (!header) return;
  const bool is_ct = header->modality == "CT" || header->modality.empty();
  ACUS_REQUIRE(header->has_pixels && is_ct, path.string(), ": is a DICOM object of the kind ",
               header->modality.empty() ? "without an image" : header->modality,
               "; a CT is needed here, as the folder that holds its slices. Labels (SEG, "
               "RTSTRUCT) are given by --import");
  ACUS_REQUIRE(header->num_frames > 1, path.string(),
               ": is one DICOM slice; give the folder that holds the whole series");
}

/// A file of labels is given as CT by mistake.
void RequireNoLabelMap(const ScalarFile& file, const CtVolume& ct, const fs::path& path) {
  constexpr std::ptrdiff_t kMostLabels = 128;  // A CT that is cut to 8 bit has about 256 values.
  const bool has_segments = std::ranges::any_of(
      file.keys, [](const auto& key) { return key.first.starts_with("Segment0_"); });
  std::array<bool, 256> occurs{};
  bool fits = true;
  for (const std::int16_t hu : ct.voxels) {
    if (hu < 0 || hu > 255) {
      fits = false;
      break;
    }
    occurs[static_cast<std::size_t>(hu)] = true;
  }
  const auto count = std::ranges::count(occurs, true);
  ACUS_REQUIRE(!has_segments && !(fits && count > 1 && count <= kMostLabels), path.string(),
               ": is a label map",
               fits ? Message(" (", count, " different values from 0 to 255)") : "",
               ", and a CT in Hounsfield units is needed here. Give labels by --labels");
}

/// Voxels of a patient's CT are not finer than this, nor is it larger than a room.
void RequireSizeOfBody(const Geometry& geometry, const fs::path& path) {
  constexpr double kFinestMm = 0.02;
  constexpr double kLargestMm = 1e4;
  const Eigen::Array3d size_mm = geometry.spacing_mm * geometry.size.cast<double>();
  const bool is_tiny = geometry.spacing_mm.maxCoeff() < kFinestMm;
  ACUS_REQUIRE(!is_tiny && size_mm.maxCoeff() < kLargestMm, path.string(), ": is a volume of ",
               size_mm.transpose(), " mm: its spacing of ", geometry.spacing_mm.transpose(),
               " is probably in ", is_tiny ? "metres" : "micrometres",
               ", not in mm; correct the header, or in an NRRD say so in 'space units'");
}

/// The volume that `series` names, from 1 on, of several over time; 0 for a file of one.
int VolumeNumber(const fs::path& path, const std::string& series) {
  const int count = NumVolumes(path);
  if (count == 1) return 0;
  const auto number = ParseFinite(series);
  ACUS_REQUIRE(number && *number >= 1.0 && *number <= count && *number == std::floor(*number),
               path.string(), ": holds ", count, " volumes over time",
               series.empty() ? "" : Message("; '", series, "' is none of them"),
               ". Choose one with --series 1 to ", count,
               " (/patient/series of a scenario), or give all of them to acus-breathing");
  return static_cast<int>(*number) - 1;
}

CtVolume CtFrom(const ScalarFile& file) {
  CtVolume ct(file.geometry);
  ForEach(file, [&](std::size_t i, auto value) { ct.voxels[i] = HuFrom(value); });
  return ct;
}

ScalarFile ReadAnyFile(const fs::path& path) {
  return path.extension() == ".vti" ? ReadVtiFile(path) : ReadScalarFile(path);
}

template <typename T>
ScalarFile FileFrom(const Grid<T>& grid, ScalarType type) {
  ACUS_REQUIRE(grid.voxels.size() == grid.geometry.num_voxels() && !grid.voxels.empty(),
               "a volume to be written has ", grid.voxels.size(), " voxels for a grid of ",
               grid.geometry.num_voxels());
  ScalarFile file;
  file.geometry = grid.geometry;
  file.type = type;
  file.bytes.resize(grid.voxels.size() * sizeof(T));
  std::memcpy(file.bytes.data(), grid.voxels.data(), file.bytes.size());
  return file;
}

std::map<Label, std::string> NamesFor(const LabelMap& labels,
                                      const std::map<Label, std::string>& given) {
  std::array<bool, 256> occurs{};
  for (const Label label : labels.voxels) occurs[label] = true;
  std::map<Label, std::string> names;
  for (std::size_t value = 1; value < occurs.size(); ++value) {
    if (!occurs[value]) continue;
    const auto label = static_cast<Label>(value);
    const auto found = given.find(label);
    if (found != given.end()) {
      names[label] = found->second;
    } else if (value < StandardLabels().size()) {
      names[label] = std::string(StandardLabels()[value].name);
    } else {
      names[label] = Message("label_", value);
    }
  }
  return names;
}

}  // namespace

CtVolume ReadCt(const fs::path& path, const std::string& series, const RunContext& context) {
  ACUS_REQUIRE(fs::exists(path), path.string(), ": no such file or folder");
  CtVolume ct;
  const bool may_be_dicom = !fs::is_directory(path) && !IsScalarFileName(path);
  if (may_be_dicom) RequireMultiFrameCt(path);
  if (fs::is_directory(path) || (may_be_dicom && ReadDicomHeader(path))) {
    ct = ReadDicomCt(path, series, context);
  } else {
    RequireCtBySidecar(path);
    context.Checkpoint("reading the CT", 0.0);
    const ScalarFile file = ReadVolumeOf(path, VolumeNumber(path, series));
    for (const std::string& note : file.notes) context.Warn(Message(path.string(), ": ", note));
    RequireSizeOfBody(file.geometry, path);
    RequireRangeOfCt(file, path);
    ct = CtFrom(file);
    RequireNoLabelMap(file, ct, path);
    if (!file.is_placed) {
      context.Warn(Message(path.string(),
                           ": its header (qform_code and sform_code of NIfTI, space of NRRD) does "
                           "not say how the patient lies; left and right may be swapped"));
    }
  }
  WarnIfNotHounsfield(ct, path, context);
  context.Checkpoint("reading the CT", 1.0);
  return ct;
}

LabelMap ReadLabelMap(const fs::path& path) {
  const ScalarFile file = ReadAnyFile(path);
  LabelMap labels(file.geometry);
  ForEach(file, [&](std::size_t i, auto value) {
    const std::int32_t label = IntegerFrom(value, path);
    ACUS_REQUIRE(label >= 0 && label <= 255, path.string(), ": label ", label,
                 " is outside 0 to 255; import it with a mapping (acus-segment --import)");
    labels.voxels[i] = static_cast<Label>(label);
  });
  labels.names = NamesFor(labels, NamesFromKeys(file.keys));
  return labels;
}

LabelMap ReadTissues(const fs::path& path) {
  LabelMap labels = ReadLabelMap(path);
  std::array<Label, 256> standard{};
  std::map<Label, std::string> names;
  for (const auto& [label, name] : labels.names) {
    const auto known = FindLabel(name);
    ACUS_REQUIRE(known || label >= StandardLabels().size(), path.string(), ": label ", int{label},
                 " is called '", name, "', which is no tissue of the models. Rename the ",
                 "segment (", StandardLabels()[label].name,
                 ", liver, ...), or bring the map in by "
                 "acus-segment --import with a mapping");
    standard[label] = known.value_or(label);
    names[standard[label]] = name;
  }
  for (Label& voxel : labels.voxels) voxel = standard[voxel];
  labels.names = std::move(names);
  return labels;
}

Grid<std::int32_t> ReadIntegerVolume(const fs::path& path,
                                     std::map<std::string, std::string>* keys) {
  const ScalarFile file = ReadAnyFile(path);
  if (keys != nullptr) *keys = file.keys;
  Grid<std::int32_t> grid(file.geometry);
  ForEach(file, [&](std::size_t i, auto value) { grid.voxels[i] = IntegerFrom(value, path); });
  return grid;
}

std::vector<Grid<std::int32_t>> ReadIntegerLayers(const fs::path& path, int layers,
                                                  std::map<std::string, std::string>& keys) {
  const ScalarFile file = ReadLayeredFile(path, layers);
  keys = file.keys;
  std::vector<Grid<std::int32_t>> grids(static_cast<std::size_t>(layers),
                                        Grid<std::int32_t>(file.geometry));
  ForEach(file, [&](std::size_t i, auto value) {
    grids[i % grids.size()].voxels[i / grids.size()] = IntegerFrom(value, path);
  });
  return grids;
}

void WriteCt(const fs::path& path, const CtVolume& volume) {
  const ScalarFile file = FileFrom(volume, ScalarType::kInt16);
  AtomicFile out(path);
  WriteScalarFile(out.path(), file);
  out.Commit();
}

void WriteLabelMap(const fs::path& path, const LabelMap& labels) {
  ACUS_REQUIRE(path.filename().string().ends_with(".nrrd"), path.string(),
               ": label maps are written as .seg.nrrd");
  ScalarFile file = FileFrom(labels, ScalarType::kUint8);
  file.keys = SegmentKeys(labels, NamesFor(labels, labels.names));
  AtomicFile out(path);
  WriteScalarFile(out.path(), file);
  out.Commit();
}

}  // namespace acus::volume
