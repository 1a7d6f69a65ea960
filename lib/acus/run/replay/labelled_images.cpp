#include "acus/run/replay/labelled_images.h"

#include <algorithm>
#include <array>

#include "acus/base/config/json_file.h"
#include "acus/base/config/pose_json.h"
#include "acus/base/core/atomic_file.h"
#include "acus/data/image/png.h"
#include "acus/data/transforms/landmarks.h"
#include "acus/data/volume/labels.h"
#include "acus/data/volume/volume_io.h"
#include "acus/run/replay/training_log.h"

namespace acus::replay {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

using Colour = std::array<std::uint8_t, 3>;

struct NamedValue {
  std::uint8_t value;
  const char* name;
  Colour colour;
};

constexpr NamedValue kBesidesTissue[] = {{simulation::kTargetInImage, "target", {255, 0, 255}},
                                         {simulation::kShaftInImage, "needle", {0, 255, 255}},
                                         {simulation::kTipInImage, "needle_tip", {255, 40, 40}},
                                         {simulation::kBeyondImage, "beyond_image", {0, 0, 0}}};

Colour ColourInImage(std::uint8_t value) {
  for (const NamedValue& named : kBesidesTissue) {
    if (named.value == value) return named.colour;
  }
  return volume::ColourOf(value);
}

/// The point `target` of the scenario's corridor.
std::optional<Eigen::Vector3d> CorridorTarget(const fs::path& corridor) {
  if (corridor.empty()) return std::nullopt;
  const transforms::Landmarks points = transforms::ReadLandmarks(corridor);
  const auto found = std::ranges::find(points.names, "target");
  if (found == points.names.end()) return std::nullopt;
  return Eigen::Vector3d(points.points_mm.col(found - points.names.begin()));
}

json ProbeFacts(const acoustics::Probe& probe) {
  return {{"name", probe.name},
          {"frequency_mhz", probe.frequency_mhz},
          {"depth_mm", probe.depth_mm},
          {"gain_db", probe.gain_db},
          {"tgc_db_per_cm", probe.tgc_db_per_cm},
          {"dynamic_range_db", probe.dynamic_range_db},
          {"slice_thickness_mm", probe.slice_thickness_mm}};
}

json ImageFacts(const image::ImageGeometry& image) {
  json rows = json::array();
  const Eigen::Matrix4d probe_from_image = image.probe_from_image().matrix();
  for (int r = 0; r < 4; ++r) {
    json row = json::array();
    for (int c = 0; c < 4; ++c) row.push_back(probe_from_image(r, c));
    rows.push_back(row);
  }
  return {{"width_px", image.width_px},
          {"height_px", image.height_px},
          {"lateral_mm_per_px", image.lateral_mm_per_px},
          {"axial_mm_per_px", image.axial_mm_per_px},
          {"depth_of_top_row_mm", image.depth_of_top_row_mm},
          {"probe_from_image", rows}};
}

}  // namespace

json ClassesOf(const volume::LabelMap& labels) {
  json classes = json::array();
  const auto add = [&classes](int value, const std::string& name, const Colour& colour) {
    classes.push_back(
        {{"value", value}, {"name", name}, {"colour", {colour[0], colour[1], colour[2]}}});
  };
  add(0, "outside", volume::ColourOf(0));
  for (const auto& [label, name] : labels.names) {
    if (label != 0) add(label, name, volume::ColourOf(label));
  }
  for (const NamedValue& named : kBesidesTissue) add(named.value, named.name, named.colour);
  return classes;
}

LabelSource LabelSourceOf(const scenario::Scenario& scenario, const simulation::Scene& scene,
                          const training::Exercise* exercise, RunContext& context) {
  LabelSource source{.labels = scene.labels, .settings = {}};
  if (!source.labels && !scenario.patient.labels.empty()) {
    context.provenance.AddInput(scenario.patient.labels);
    source.labels =
        std::make_shared<volume::LabelMap>(volume::ReadTissues(scenario.patient.labels));
  }
  if (exercise != nullptr) {
    source.settings.target_ct_mm = TargetInCtMm(*exercise, scenario);
    source.settings.target_radius_mm = exercise->target_radius_mm;
  } else {
    source.settings.target_ct_mm = CorridorTarget(scenario.patient.corridor);
  }
  return source;
}

LabelledImages::LabelledImages(const simulation::Scene& scene, const LabelSource& source,
                               LabelFormat format, fs::path folder)
    : scene_(scene),
      source_(source),
      folder_(std::move(folder)),
      labeller_(scene, source.labels, source.settings) {
  fs::create_directories(folder_);
  stack_ = MakeImageStack(format, folder_, {labeller_.image(), labeller_.depth_mm()});
}

void LabelledImages::Write(const simulation::Snapshot& snapshot, const simulation::StepOutput* step,
                           const image::GrayImage& image) {
  const image::ImageGeometry& geometry = labeller_.image();
  ACUS_REQUIRE(image.width == geometry.width_px && image.height == geometry.height_px,
               "labels of images: the image has ", image.width, " x ", image.height,
               " pixels, its labels ", geometry.width_px, " x ", geometry.height_px);
  labeller_.Label(snapshot, truth_);
  table_.AddFrame(scene_, snapshot, step, truth_);
  stack_->Append(image, truth_.labels);
  KeepPreview(image);
}

/// The image next to a copy with its labels overlaid, where most of the needle is visible.
void LabelledImages::KeepPreview(const image::GrayImage& image) {
  const double seen_mm = truth_.inserted_mm * truth_.visible_share.value_or(0.0);
  if (seen_mm <= preview_mm_) return;
  preview_mm_ = seen_mm;
  preview_.Resize(2 * image.width, image.height);
  for (int r = 0; r < image.height; ++r) {
    for (int c = 0; c < image.width; ++c) {
      const std::uint8_t grey = image.At(c, r);
      const std::uint8_t value = truth_.labels.At(c, r);
      const Colour colour = ColourInImage(value);
      const bool mixed = value < simulation::kTargetInImage;
      const std::size_t row = static_cast<std::size_t>(r) * static_cast<std::size_t>(image.width);
      const std::size_t left = 3 * (2 * row + static_cast<std::size_t>(c));
      const std::size_t right = left + 3 * static_cast<std::size_t>(image.width);
      for (std::size_t channel = 0; channel < 3; ++channel) {
        preview_.rgb[left + channel] = grey;
        preview_.rgb[right + channel] =
            mixed ? static_cast<std::uint8_t>((grey + colour[channel]) / 2) : colour[channel];
      }
    }
  }
}

json LabelledImages::Document() const {
  json document = {{"format", "acus-labelled-images/1"},
                   {"frames", table_.num_rows()},
                   {"files", stack_->Files()},
                   {"classes", ClassesOf(*source_.labels)},
                   {"image", ImageFacts(labeller_.image())},
                   {"probe", ProbeFacts(*scene_.probe)},
                   {"tip_radius_mm", source_.settings.tip_radius_mm}};
  if (scene_.needle) {
    document["needle"] = {{"name", scene_.needle->name},
                          {"length_mm", scene_.needle->length_mm},
                          {"outer_diameter_mm", scene_.needle->beam.outer_diameter_mm}};
  }
  if (const auto& target = source_.settings.target_ct_mm) {
    document["target"] = {{"rest_ct_mm", config::Row(*target)},
                          {"radius_mm", source_.settings.target_radius_mm}};
  }
  return document;
}

void LabelledImages::Finish(const json& more) {
  stack_->Finish(table_);
  WriteTextFile(folder_ / "frames.csv", table_.CsvText());
  json document = Document();
  document.update(more);
  config::WriteJson(folder_ / "labelled.json", document);
  if (!preview_.rgb.empty()) image::WritePng(folder_ / "preview.png", preview_);
}

}  // namespace acus::replay
