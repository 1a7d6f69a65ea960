#include "acus/data/session/session_import.h"

#include "acus/base/core/error.h"
#include "acus/base/core/words.h"
#include "acus/data/session/sequence_file.h"
#include "acus/data/session/session_io.h"
#include "acus/data/session/slicer_scene.h"
#include "acus/data/session/tool_stream.h"

namespace acus::session {
namespace {

namespace fs = std::filesystem;

// An image frame is told from a tool by its scale: nobody records 1 mm pixels.
constexpr double kRigidScaleTolerance = 0.02;

transforms::TransformGraph Calibrations(const ImportOptions& options) {
  transforms::TransformGraph graph;
  for (const auto& [text, matrix] : options.calibrations) {
    const auto name = transforms::ParseTransformName(text);
    ACUS_REQUIRE(name, "calibration '", text, "': a name such as ImageToProbe is needed");
    ACUS_REQUIRE(matrix.allFinite(), "calibration '", text, "': has a value that is not finite");
    graph.Set(*name, matrix, true);
  }
  return graph;
}

bool IsImage(const ToolStream& tool) {
  return (tool.scale - Eigen::Vector3d::Ones()).cwiseAbs().maxCoeff() > kRigidScaleTolerance;
}

/// Moves the origin of an image's pose from its corner to the transducer face.
void MoveToFace(ToolStream& tool, const Eigen::Vector2d& face_px) {
  const Eigen::Translation3d face_mm(face_px.x() * tool.scale.x(), face_px.y() * tool.scale.y(), 0);
  for (PoseSample& sample : tool.poses) {
    sample.reference_from_tool = sample.reference_from_tool.isometry() * face_mm;
  }
}

ImportedSession Assemble(const std::string& label, const ImportOptions& options,
                         std::optional<ToolStream> needle, std::optional<ToolStream> probe) {
  ImportedSession imported;
  imported.session.name = fs::path(label).filename().string();
  imported.session.reference_frame = options.reference_frame;
  if (needle) {
    ACUS_REQUIRE(!IsImage(*needle), label, ": the needle's frame ", needle->frame, " has axes of ",
                 needle->scale.transpose(), " mm; a tool's must be 1 mm");
    imported.needle_frame = needle->frame;
    imported.session.needle = std::move(needle->poses);
  }
  if (probe) {
    if (IsImage(*probe)) {
      imported.probe_mm_per_px = probe->scale.head<2>();
      if (options.face_px) MoveToFace(*probe, *options.face_px);
    }
    imported.probe_frame = probe->frame;
    imported.session.probe = std::move(probe->poses);
  }
  return imported;
}

[[noreturn]] void NothingFound(const std::string& label, const ImportOptions& options,
                               const std::string& transforms) {
  throw InputError(Message(label, ": none of the frames ", Joined(options.needle_frames), ", ",
                           Joined(options.probe_frames), " is connected with ",
                           options.reference_frame, "; its transforms are: ", transforms,
                           ". Name the frames that are the needle, the probe and the reference"));
}

std::vector<TimedTransforms> Instants(const SequenceFile& file, const std::string& label,
                                      const ImportOptions& options) {
  const transforms::TransformGraph calibrations = Calibrations(options);
  std::vector<TimedTransforms> instants(file.num_frames());
  for (std::size_t i = 0; i < instants.size(); ++i) {
    const auto time_ns = file.TimeNs(i);
    ACUS_REQUIRE(time_ns, label, ": frame ", i, ": has no Timestamp; it cannot be replayed");
    instants[i] = {*time_ns, file.Transforms(i)};
    instants[i].transforms.AddMissing(calibrations);
  }
  return instants;
}

fs::path SceneOf(const fs::path& folder) {
  std::vector<fs::path> scenes;
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(folder, error)) {
    if (entry.path().extension() == ".mrml") scenes.push_back(entry.path());
  }
  ACUS_REQUIRE(!error, folder.string(), ": cannot be read: ", error.message());
  ACUS_REQUIRE(!scenes.empty(), folder.string(),
               ": has neither session.json nor a Slicer scene "
               "(.mrml)");
  ACUS_REQUIRE(scenes.size() == 1, folder.string(), ": has ", scenes.size(),
               " Slicer scenes (.mrml); give the path of one");
  return scenes.front();
}

}  // namespace

ImportedSession ReadPlusSession(const fs::path& path, const ImportOptions& options,
                                const RunContext& context) {
  const std::string label = path.string();
  const SequenceFile file(path);
  const auto instants = Instants(file, label, options);
  auto needle =
      ExtractTool(instants, options.needle_frames, options.reference_frame, label, context);
  auto probe = ExtractTool(instants, options.probe_frames, options.reference_frame, label, context);
  if (!needle && !probe) NothingFound(label, options, instants.front().transforms.Names());
  return Assemble(label, options, std::move(needle), std::move(probe));
}

ImportedSession ReadSlicerSession(const fs::path& path, const ImportOptions& options,
                                  const RunContext& context) {
  const std::string label = path.string();
  SlicerScene scene = ReadSlicerScene(fs::is_directory(path) ? SceneOf(path) : path);
  scene.fixed.AddMissing(Calibrations(options));
  const auto extract = [&](const std::vector<std::string>& frames) -> std::optional<ToolStream> {
    for (const std::string& frame : frames) {
      const auto instants = InstantsFor(scene, frame, options.reference_frame);
      auto tool =
          ExtractTool(instants, std::span(&frame, 1), options.reference_frame, label, context);
      if (tool) return tool;
    }
    return {};
  };
  auto needle = extract(options.needle_frames);
  auto probe = extract(options.probe_frames);
  if (!needle && !probe) NothingFound(label, options, TransformNames(scene));
  return Assemble(label, options, std::move(needle), std::move(probe));
}

ImportedSession ReadAnySession(const fs::path& path, const ImportOptions& options,
                               const RunContext& context) {
  ACUS_REQUIRE(fs::exists(path), path.string(), ": there is no such file or folder");
  if (fs::is_directory(path) && fs::exists(path / "session.json")) {
    ImportedSession own;
    own.session = ReadSession(path, context);
    if (!own.session.needle.empty()) own.needle_frame = "needle";
    if (!own.session.probe.empty()) own.probe_frame = "probe";
    return own;
  }
  const std::string ending = path.extension().string();
  if (fs::is_directory(path) || ending == ".mrml" || ending == ".mrb") {
    return ReadSlicerSession(path, options, context);
  }
  ACUS_REQUIRE(ending == ".mha" || ending == ".mhd" || ending == ".nrrd", path.string(),
               ": is not a session; allowed: a session folder (with session.json), a PLUS sequence "
               "(.igs.mha, .igs.mhd, .igs.nrrd), a Slicer scene (.mrml, .mrb, or its folder)");
  return ReadPlusSession(path, options, context);
}

}  // namespace acus::session
