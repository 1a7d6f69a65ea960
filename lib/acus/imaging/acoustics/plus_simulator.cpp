#include "acus/imaging/acoustics/plus_simulator.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <numbers>
#include <optional>

#include "acus/base/core/atomic_file.h"
#include "acus/base/core/error.h"
#include "acus/base/core/xml_scan.h"
#include "acus/data/session/sequence_header.h"
#include "acus/data/volume/labels.h"

namespace acus::acoustics {
namespace {

using core::XmlElement;

/// PLUS's own default.
constexpr double kDefaultFrequencyMhz = 2.5;
constexpr int kFirstFreeLabel = 128;
constexpr int kMaxPx = 4096;

struct Range {
  double min;
  double max;
};

class PlusReader {
 public:
  explicit PlusReader(const std::filesystem::path& path)
      : label_(path.string()), elements_(core::ScanXml(ReadTextFile(path), label_)) {
    ACUS_REQUIRE(elements_.front().name == "PlusConfiguration", label_,
                 ": is not a PLUS configuration; its first element is '", elements_.front().name,
                 "'; give an acus preset (*.json) or a PlusDeviceSet file");
  }

  const std::string& label() const { return label_; }
  const std::vector<XmlElement>& elements() const { return elements_; }

  /// The first element of that name; null if there is none.
  const XmlElement* Find(std::string_view name) const {
    const auto found = std::ranges::find(elements_, name, &XmlElement::name);
    return found == elements_.end() ? nullptr : &*found;
  }

  /// An attribute of `count` numbers in the range; nothing if it is not there.
  std::optional<std::vector<double>> Numbers(const XmlElement& element, const char* key,
                                             std::size_t count, Range range) const {
    const auto text = element.Attribute(key);
    if (!text) return {};
    const auto numbers = session::NumbersOf(*text);
    const bool fits =
        numbers && numbers->size() == count &&
        std::ranges::all_of(*numbers, [&](double v) { return v >= range.min && v <= range.max; });
    ACUS_REQUIRE(fits, label_, ": ", element.name, ": ", key, "=\"", *text, "\": give ", count,
                 count == 1 ? " number from " : " numbers from ", range.min, " to ", range.max);
    return numbers;
  }

  double Number(const XmlElement& element, const char* key, Range range) const {
    const auto number = Numbers(element, key, 1, range);
    ACUS_REQUIRE(number.has_value(), label_, ": ", element.name, ": has no ", key,
                 "; give a number from ", range.min, " to ", range.max);
    return number->front();
  }

  double NumberOr(const XmlElement& element, const char* key, Range range, double fallback) const {
    const auto number = Numbers(element, key, 1, range);
    return number ? number->front() : fallback;
  }

 private:
  std::string label_;
  std::vector<XmlElement> elements_;
};

/// The image as PLUS lays it out: TransducerCenterPixel is the middle of the face.
image::ImageGeometry PlusImage(const PlusReader& reader, const XmlElement& scan) {
  const auto need = [&](const char* key, Range range) {
    const auto numbers = reader.Numbers(scan, key, 2, range);
    ACUS_REQUIRE(numbers.has_value(), reader.label(), ": ScanConversion: has no ", key,
                 "; give two numbers from ", range.min, " to ", range.max);
    return *numbers;
  };
  const auto size_px = need("OutputImageSizePixel", {16, kMaxPx});
  const auto spacing_mm = need("OutputImageSpacingMmPerPixel", {0.001, 10});
  const auto centre_px = need("TransducerCenterPixel", {-kMaxPx, kMaxPx});
  ACUS_REQUIRE(std::abs(centre_px[0] - 0.5 * size_px[0]) <= 1.0, reader.label(),
               ": ScanConversion: TransducerCenterPixel is at column ", centre_px[0],
               "; only images with the probe in the middle are made: give ", 0.5 * size_px[0]);
  ACUS_REQUIRE(centre_px[1] >= 0.0 && centre_px[1] < size_px[1], reader.label(),
               ": ScanConversion: TransducerCenterPixel is at row ", centre_px[1],
               "; the face of the probe must be in the image: give 0 to ", size_px[1] - 1.0);
  return {.width_px = static_cast<int>(size_px[0]),
          .height_px = static_cast<int>(size_px[1]),
          .lateral_mm_per_px = spacing_mm[0],
          .axial_mm_per_px = spacing_mm[1],
          .depth_of_top_row_mm = -std::floor(centre_px[1]) * spacing_mm[1]};
}

void ReadShape(const PlusReader& reader, const XmlElement& scan, Probe& probe) {
  const std::string geometry = scan.Attribute("TransducerGeometry").value_or("");
  if (geometry == "LINEAR") {
    probe.kind = ProbeKind::kLinear;
    probe.width_mm = reader.Number(scan, "TransducerWidthMm", {1, 300});
    probe.depth_mm = reader.Number(scan, "ImagingDepthMm", {5, 300});
    return;
  }
  ACUS_REQUIRE(geometry == "CURVILINEAR", reader.label(),
               ": ScanConversion: TransducerGeometry is '", geometry,
               "'; allowed: LINEAR, CURVILINEAR");
  probe.kind = ProbeKind::kCurvilinear;
  probe.radius_mm = reader.Number(scan, "RadiusStartMm", {1, 200});
  const double stop_mm = reader.Number(scan, "RadiusStopMm", {1, 500});
  probe.depth_mm = stop_mm - probe.radius_mm;
  ACUS_REQUIRE(probe.depth_mm >= 5.0 && probe.depth_mm <= 300.0, reader.label(),
               ": ScanConversion: RadiusStopMm - RadiusStartMm is ", probe.depth_mm,
               " mm; it is the depth of the image: 5 to 300 mm");
  const double start_deg = reader.Number(scan, "ThetaStartDeg", {-80, 80});
  const double stop_deg = reader.Number(scan, "ThetaStopDeg", {-80, 80});
  const double angle_deg = stop_deg - start_deg;
  ACUS_REQUIRE(angle_deg >= 5.0 && std::abs(start_deg + stop_deg) < 0.5, reader.label(),
               ": ScanConversion: the fan is from ", start_deg, " to ", stop_deg,
               " degrees; give one that is 5 degrees wide or more and the same to both sides");
  probe.field_of_view_rad = angle_deg * std::numbers::pi / 180.0;
}

Probe ProbeFrom(const PlusReader& reader) {
  const XmlElement* scan = reader.Find("ScanConversion");
  ACUS_REQUIRE(scan != nullptr, reader.label(),
               ": has no ScanConversion element, which says what the probe is; give the "
               "configuration of an ultrasound simulator, or a preset of configs/probes");
  const XmlElement* algorithm = reader.Find("vtkPlusUsSimulatorAlgo");
  if (algorithm == nullptr) algorithm = scan;
  Probe probe = DefaultProbe();
  probe.name = scan->Attribute("TransducerName").value_or("PLUS probe");
  ReadShape(reader, *scan, probe);
  probe.image = PlusImage(reader, *scan);
  probe.image_width_px = probe.image->width_px;
  probe.image_height_px = probe.image->height_px;
  probe.frequency_mhz =
      reader.NumberOr(*algorithm, "FrequencyMhz", {0.5, 50}, kDefaultFrequencyMhz);
  double lines = reader.NumberOr(*scan, "NumberOfScanLines", {16, kMaxPx}, probe.scan_lines);
  lines = reader.NumberOr(*algorithm, "NumberOfScanlines", {16, kMaxPx}, lines);
  double samples =
      reader.NumberOr(*scan, "NumberOfSamplesPerScanLine", {64, 8192}, probe.samples_per_line);
  samples = reader.NumberOr(*algorithm, "NumberOfSamplesPerScanline", {64, 8192}, samples);
  probe.scan_lines = static_cast<int>(lines);
  probe.samples_per_line = static_cast<int>(samples);
  return probe;
}

std::string TissueName(const std::string& plus_name) {
  std::string name;
  for (const char c : plus_name) {
    const auto byte = static_cast<unsigned char>(c);
    name += std::isalnum(byte) != 0 ? static_cast<char>(std::tolower(byte)) : '_';
  }
  return name;
}

TissueAcoustics TissueOf(const PlusReader& reader, const XmlElement& model, double frequency_mhz) {
  TissueAcoustics tissue;
  tissue.speed_m_per_s = reader.Number(model, "SoundVelocityMPerSec", {100, 10000});
  const double density = reader.Number(model, "DensityKgPerM3", {0.1, 30000});
  tissue.impedance_mrayl = density * tissue.speed_m_per_s * 1e-6;
  tissue.attenuation_db_per_cm_mhz =
      reader.Number(model, "AttenuationCoefficientDbPerCmMhz", {0, 200});
  tissue.attenuation_along_fibres_db_per_cm_mhz = tissue.attenuation_db_per_cm_mhz;
  const double share =
      reader.NumberOr(model, "BackscatterDiffuseReflectionCoefficient", {0, 1}, 0.0);
  const double lost_per_mm =
      0.1 * tissue.attenuation_db_per_cm_mhz * frequency_mhz * std::numbers::ln10 / 10.0;
  tissue.backscatter_db = 10.0 * std::log10(std::max(1e-20, std::min(1.0, share * lost_per_mm)));
  if (share == 0.0) tissue.scatterers_per_mm3 = 0.0;
  return tissue;
}

}  // namespace

bool IsPlusConfiguration(const std::filesystem::path& path) {
  return path.extension() == ".xml";
}

Probe ReadPlusProbe(const std::filesystem::path& path) {
  return ProbeFrom(PlusReader(path));
}

PlusSimulator ReadPlusSimulator(const std::filesystem::path& path) {
  const PlusReader reader(path);
  PlusSimulator out;
  out.probe = ProbeFrom(reader);
  out.acoustics.name = path.stem().string();
  out.acoustics.file = reader.label();
  const XmlElement* algorithm = reader.Find("vtkPlusUsSimulatorAlgo");
  out.reference_frame = "Reference";
  if (algorithm != nullptr) {
    out.reference_frame = algorithm->Attribute("ReferenceCoordinateFrame").value_or("Reference");
  }
  int place = 0;
  for (const XmlElement& element : reader.elements()) {
    if (element.name != "SpatialModel") continue;
    const std::string given = element.Attribute("Name").value_or("");
    ACUS_REQUIRE(!given.empty(), reader.label(), ": SpatialModel number ", place + 1,
                 " has no Name; give it one");
    const std::string name = TissueName(given);
    ACUS_REQUIRE(!out.acoustics.tissues.contains(name), reader.label(), ": SpatialModel '", given,
                 "': there is one of that name before it; rename one of the two");
    ACUS_REQUIRE(place < 256 - kFirstFreeLabel, reader.label(), ": more than ",
                 256 - kFirstFreeLabel, " spatial models");
    const TissueAcoustics tissue = TissueOf(reader, element, out.probe.frequency_mhz);
    out.acoustics.tissues[name] = tissue;
    const auto file = element.Attribute("ModelFile");
    if (!file || file->empty()) {
      out.acoustics.tissues.try_emplace("outside", tissue);
      if (out.acoustics.by_hu.empty()) out.acoustics.by_hu.push_back({0.0, name});
    } else {
      PlusSurface surface{.tissue = name,
                          .label = volume::FindLabel(name).value_or(
                              static_cast<volume::Label>(kFirstFreeLabel + place)),
                          .object_frame = element.Attribute("ObjectCoordinateFrame").value_or(""),
                          .file = *file};
      if (const auto matrix = reader.Numbers(element, "ModelToObjectTransform", 16, {-1e6, 1e6})) {
        surface.object_from_model =
            Eigen::Map<const Eigen::Matrix<double, 4, 4, Eigen::RowMajor>>(matrix->data());
      }
      out.surfaces.push_back(std::move(surface));
    }
    ++place;
  }
  ACUS_REQUIRE(place > 0, reader.label(),
               ": has no SpatialModel element, so no tissues; give the configuration of an "
               "ultrasound simulator, or a preset of configs/acoustics");
  if (out.acoustics.by_hu.empty()) {
    out.acoustics.by_hu.push_back({0.0, out.acoustics.tissues.begin()->first});
  }
  return out;
}

}  // namespace acus::acoustics
