// Images with ground truth, for training of networks: docs/reference/formats_labelled.md.
#pragma once

#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>

#include "acus/base/core/run_context.h"
#include "acus/run/replay/frame_table.h"
#include "acus/run/replay/image_stack.h"
#include "acus/run/training/exercise.h"
#include "acus/scene/scenario/scenario.h"
#include "acus/scene/simulation/image_labels.h"

namespace acus::replay {

/// The source of labels: the patient's tissues, also if no effect reads them, and the target.
struct LabelSource {
  std::shared_ptr<const volume::LabelMap> labels;
  simulation::ImageLabelSettings settings;
};

/// Takes the target from the exercise; without one, the point `target` of the scenario's corridor,
/// if there is such a point.
/// @throws InputError if the patient has no label map, or a file is not readable.
LabelSource LabelSourceOf(const scenario::Scenario& scenario, const simulation::Scene& scene,
                          const training::Exercise* exercise, RunContext& context);

/// Writes images, label images, frames.csv, labelled.json and preview.png into a folder.
class LabelledImages {
 public:
  /// Makes the folder. @param scene  Must outlive this. @pre format is not kNone.
  /// @throws InputError as simulation::ImageLabeller, or if the folder cannot be written to.
  LabelledImages(const simulation::Scene& scene, const LabelSource& source, LabelFormat format,
                 std::filesystem::path folder);

  /// Labels an image and writes both. @param step  At or before its time; may be null.
  /// @throws InputError if the image is not of the size of the scene's images.
  void Write(const simulation::Snapshot& snapshot, const simulation::StepOutput* step,
             const image::GrayImage& image);

  /// After the last image. @param more  Merged into labelled.json.
  void Finish(const nlohmann::json& more = nlohmann::json::object());

  const FrameTable& table() const { return table_; }
  std::map<std::string, std::string> Files() const { return stack_->Files(); }

 private:
  void KeepPreview(const image::GrayImage& image);
  nlohmann::json Document() const;

  const simulation::Scene& scene_;
  LabelSource source_;
  std::filesystem::path folder_;
  simulation::ImageLabeller labeller_;
  std::unique_ptr<ImageStack> stack_;
  FrameTable table_;
  simulation::ImageTruth truth_;
  double preview_mm_ = -1.0;  ///< Length of the needle in the preview.
  image::ColourImage preview_;
};

/// All values of label images of a label map: value, name, sRGB colour.
nlohmann::json ClassesOf(const volume::LabelMap& labels);

}  // namespace acus::replay
