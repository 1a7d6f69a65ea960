#include "acus/run/live/slicer_files.h"

#include <nlohmann/json.hpp>
#include <string>

#include "acus/base/config/json_file.h"
#include "acus/base/core/atomic_file.h"
#include "acus/base/core/error.h"
#include "acus/run/replay/markups.h"

namespace acus::live {
namespace {

namespace fs = std::filesystem;

constexpr const char* kNeedleLineFile = "needle.mrk.json";
constexpr double kShaftMm = 150.0;       ///< Length of the line that is displayed.
constexpr int kReslicePlaneOfImage = 6;  ///< MODE_TRANSVERSE of SlicerIGT's VolumeResliceDriver.

std::string Escaped(const std::string& text) {
  std::string out;
  for (const char c : text) {
    switch (c) {
      case '&':
        out += "&amp;";
        break;
      case '<':
        out += "&lt;";
        break;
      case '"':
        out += "&quot;";
        break;
      default:
        out += c;
    }
  }
  return out;
}

/// The shaft in the needle's frame: the tip is its origin, +z its direction.
void WriteNeedleLine(const fs::path& path) {
  const auto point = [](const char* id, double z_mm) {
    return nlohmann::json{
        {"id", id}, {"label", ""}, {"position", {0.0, 0.0, z_mm}}, {"positionStatus", "defined"}};
  };
  // "RAS": numbers are not converted, for the frame is the needle's and not the patient's.
  config::WriteJson(path, {{"markups",
                            {{{"type", "Line"},
                              {"coordinateSystem", "RAS"},
                              {"coordinateUnits", "mm"},
                              {"controlPoints", {point("1", 0.0), point("2", -kShaftMm)}}}}}});
}

std::string TransformNode(const char* id, const char* name, const char* parent) {
  const std::string references = *parent == '\0' ? "" : Message("transform:", parent, ";");
  return Message(" <LinearTransform id=\"", id, "\" name=\"", name, "\" references=\"", references,
                 "\"></LinearTransform>\n");
}

/// @param transform  The parent transform; may be empty.
std::string VolumeNode(int number, const char* name, const char* colour, int window, int level,
                       const char* transform) {
  const std::string display = Message("vtkMRMLScalarVolumeDisplayNode", number);
  const std::string parent = *transform == '\0' ? "" : Message("transform:", transform, ";");
  return Message(" <VolumeDisplay id=\"", display, "\" name=\"", name,
                 "Display\" references=\"color:", colour, ";\" colorNodeID=\"", colour,
                 "\" window=\"", window, "\" level=\"", level,
                 "\" autoWindowLevel=\"0\" interpolate=\"1\"></VolumeDisplay>\n",
                 " <Volume id=\"vtkMRMLScalarVolumeNode", number, "\" name=\"", name,
                 "\" references=\"display:", display, ";", parent, "\"></Volume>\n");
}

std::string MarkupsNode(const char* kind, const char* id, const char* name, const char* file,
                        const char* transform) {
  const std::string storage = Message(id, "Storage");
  const std::string display = Message(id, "Display");
  const std::string parent = *transform == '\0' ? "" : Message("transform:", transform, ";");
  return Message(" <MarkupsDisplay id=\"", display, "\" name=\"", name,
                 "Display\" color=\"1 0.2 0.2\" selectedColor=\"1 0.2 0.2\"></MarkupsDisplay>\n",
                 " <MarkupsJsonStorage id=\"", storage, "\" name=\"", name, "Storage\" fileName=\"",
                 file, "\"></MarkupsJsonStorage>\n", " <", kind, " id=\"", id, "\" name=\"", name,
                 "\" references=\"display:", display, ";storage:", storage, ";", parent, "\"></",
                 kind, ">\n");
}

/// A view that shows the ultrasound, if it has that node, over the CT.
std::string SliceNodes(const char* colour, const char* orientation, bool follows_image) {
  const std::string driver = Message("VolumeResliceDriver.Driver:vtkMRMLScalarVolumeNode3;",
                                     "VolumeResliceDriver.Mode:", kReslicePlaneOfImage);
  const std::string attributes =
      follows_image ? Message("\" attributes=\"", driver) : std::string();
  return Message(" <Slice id=\"vtkMRMLSliceNode", colour, "\" name=\"", colour,
                 "\" singletonTag=\"", colour, "\" layoutName=\"", colour, "\" orientation=\"",
                 orientation, "\" sliceVisibility=\"", follows_image ? "true" : "false", attributes,
                 "\"></Slice>\n", " <SliceComposite id=\"vtkMRMLSliceCompositeNode", colour,
                 "\" name=\"SliceComposite\" singletonTag=\"", colour, "\" layoutName=\"", colour,
                 "\" backgroundVolumeID=\"vtkMRMLScalarVolumeNode1\" foregroundVolumeID=\"",
                 "vtkMRMLScalarVolumeNode3\" foregroundOpacity=\"0.6\"></SliceComposite>\n");
}

}  // namespace

void WriteSlicerScene(const fs::path& folder, const std::string& host, int port,
                      const transforms::Landmarks& targets) {
  const std::string server = Escaped(host.empty() ? "localhost" : host);
  constexpr const char* kReference = "vtkMRMLLinearTransformNode1";
  constexpr const char* kNeedle = "vtkMRMLLinearTransformNode3";
  std::string scene =
      "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<MRML version=\"Slicer5.6.2\" userTags=\"\">\n";
  scene += Message(
      " <IGTLConnector id=\"vtkMRMLIGTLConnectorNode1\" name=\"Acus\" connectorType=\"CLIENT\" ",
      "serverHostname=\"", server, "\" serverPort=\"", port,
      "\" restrictDeviceName=\"0\" persistent=\"1\" checkCRC=\"1\" state=\"1\">",
      "</IGTLConnector>\n");
  scene += TransformNode(kReference, "ReferenceToRas", "");
  scene += TransformNode("vtkMRMLLinearTransformNode2", "ProbeToReference", kReference);
  scene += TransformNode(kNeedle, "NeedleToReference", kReference);
  scene += TransformNode("vtkMRMLLinearTransformNode4", "TargetToRas", "");
  scene += VolumeNode(1, "CT", "vtkMRMLColorTableNodeGrey", 400, 40, "");
  scene += VolumeNode(2, "Labels", "vtkMRMLColorTableNodeRandom", 256, 128, "");
  scene += VolumeNode(3, "Ultrasound", "vtkMRMLColorTableNodeGrey", 255, 128, kReference);
  scene +=
      MarkupsNode("MarkupsLine", "vtkMRMLMarkupsLineNode1", "Needle", kNeedleLineFile, kNeedle);
  if (!targets.names.empty()) {
    scene += MarkupsNode("MarkupsFiducial", "vtkMRMLMarkupsFiducialNode1", "Targets",
                         replay::kTargetMarkups, "");
  }
  scene += SliceNodes("Red", "Reformat", true) + SliceNodes("Yellow", "Sagittal", false) +
           SliceNodes("Green", "Coronal", false) + "</MRML>\n";
  WriteTextFile(folder / "slicer.mrml", scene);
  WriteNeedleLine(folder / kNeedleLineFile);
}

}  // namespace acus::live
