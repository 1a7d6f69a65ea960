#include "acus/data/session/session_import.h"

#include <algorithm>

#include "acus/base/core/error.h"
#include "acus/base/core/text_table.h"
#include "acus/base/core/words.h"
#include "acus/data/session/column_csv.h"
#include "acus/data/session/frame_guess.h"
#include "acus/data/session/integrity.h"
#include "acus/data/session/perk_buffer.h"
#include "acus/data/session/pose_csv.h"
#include "acus/data/session/recording_import.h"
#include "acus/data/session/sequence_file.h"
#include "acus/data/session/session_io.h"
#include "acus/data/session/slicer_scene.h"
#include "acus/data/session/tool_stream.h"

namespace acus::session {
namespace {

namespace fs = std::filesystem;

// An image frame is distinguished from a tool by its scale: no image has pixels of 1 mm.
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

/// Names a calibration of the image that is there, where the probe's pose is that of its marker.
void WarnIfCalibrationIsUnused(const std::optional<ToolStream>& probe,
                               const transforms::TransformGraph& transforms,
                               const ImportOptions& options, const std::string& label,
                               const RunContext& context) {
  constexpr const char* kImage = "Image";
  if (!probe || probe->frame == kImage || options.probe_frames != ImportOptions().probe_frames) {
    return;
  }
  const bool is_calibrated = transforms.HasFrame(kImage) && transforms.Find(kImage, probe->frame);
  if (!is_calibrated) return;
  context.Warn(Message(label, ": the probe's pose is that of the marker ", probe->frame,
                       ", not of the transducer, although the calibration ImageTo", probe->frame,
                       " is known. 'acus-import --probe Image --face-px COLUMN ROW' uses it; "
                       "--probe ",
                       probe->frame, " means the marker"));
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
                           transforms == "none"
                               ? ". It has no poses of tools: only images"
                               : ". Name the frames that are the needle, the probe and the "
                                 "reference: --needle, --probe and --reference of acus-import, or "
                                 "/session of a scenario"));
}

bool LacksTimes(const SequenceFile& file) {
  for (std::size_t i = 0; i < file.num_frames(); ++i) {
    if (!file.TimeNs(i)) return true;
  }
  return false;
}

/// Whether no frame was named: then frames of other names may be taken.
bool HasDefaultFrames(const ImportOptions& options) {
  const ImportOptions defaults;
  return options.needle_frames == defaults.needle_frames &&
         options.probe_frames == defaults.probe_frames &&
         options.reference_frame == defaults.reference_frame;
}

/// The options with frames that the recording has, and a warning that names them.
std::optional<ImportOptions> Guessed(const std::vector<transforms::TransformName>& names,
                                     const ImportOptions& options, const std::string& label,
                                     const RunContext& context) {
  const auto guess = HasDefaultFrames(options) ? GuessFrames(names) : std::nullopt;
  if (!guess) return {};
  ImportOptions guessed = options;
  guessed.reference_frame = guess->reference;
  guessed.needle_frames = guess->needle;
  guessed.probe_frames = guess->probe;
  if (HasDefaultFrames(guessed)) return {};  // They are there, but not connected.
  context.Warn(Message(label, ": no usual frame is connected with Reference; poses are taken in ",
                       guess->reference, ", the needle is ",
                       guess->needle.empty() ? "none" : guess->needle.front(), ", the probe ",
                       guess->probe.empty() ? "none" : guess->probe.front(),
                       "; --needle, --probe and --reference of acus-import choose others"));
  return guessed;
}

std::vector<transforms::TransformName> NamesOfFrames(const SequenceFile& file) {
  std::vector<transforms::TransformName> names;
  for (const std::string& field : file.header().frame_field_names()) {
    const auto name = transforms::ParseTransformName(field);
    const bool is_transform = name && !field.ends_with("Status") && name->from != name->to;
    if (is_transform) names.push_back(*name);
  }
  return names;
}

std::vector<TimedTransforms> Instants(const SequenceFile& file, const std::string& label,
                                      const ImportOptions& options, double frame_rate_hz) {
  const transforms::TransformGraph calibrations = Calibrations(options);
  std::vector<TimedTransforms> instants(file.num_frames());
  const bool makes_up = frame_rate_hz > 0.0 && LacksTimes(file);
  for (std::size_t i = 0; i < instants.size(); ++i) {
    const auto time_ns =
        makes_up ? std::llround(1e9 * static_cast<double>(i) / frame_rate_hz) : file.TimeNs(i);
    ACUS_REQUIRE(time_ns, label, ": frame ", i,
                 ": has no Timestamp; 'acus-import --frame-rate-hz' makes time stamps of a rate");
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

namespace {

/// Omits frames that are earlier than one before them, or all from the first such on.
void DropTimeGoingBack(std::vector<TimedTransforms>& instants, TimeGoingBack what,
                       const std::string& label, const RunContext& context) {
  if (what == TimeGoingBack::kRefuse || instants.empty()) return;
  const std::size_t before = instants.size();
  std::int64_t latest_ns = instants.front().time_ns;
  if (what == TimeGoingBack::kCut) {
    const auto back = std::ranges::adjacent_find(
        instants, [](const auto& a, const auto& b) { return b.time_ns < a.time_ns; });
    if (back != instants.end()) instants.erase(back + 1, instants.end());
  } else {
    std::erase_if(instants, [&](const TimedTransforms& instant) {
      if (instant.time_ns < latest_ns) return true;
      latest_ns = instant.time_ns;
      return false;
    });
  }
  if (instants.size() == before) return;
  context.Warn(Message(label, ": ", before - instants.size(), " of ", before, " frames ",
                       what == TimeGoingBack::kCut ? "from where time goes back on are omitted"
                                                   : "are earlier than one before them and are "
                                                     "omitted"));
}

ImportedSession ReadSequenceSession(const fs::path& path, const RecordingOptions& recording,
                                    const RunContext& context) {
  const ImportOptions& options = recording.frames;
  const std::string label = path.string();
  const SequenceFile file(path);
  auto instants = Instants(file, label, options, recording.frame_rate_hz);
  DropTimeGoingBack(instants, recording.time_going_back, label, context);
  auto needle =
      ExtractTool(instants, options.needle_frames, options.reference_frame, label, context);
  auto probe = ExtractTool(instants, options.probe_frames, options.reference_frame, label, context);
  if (!needle && !probe) {
    const auto guessed = Guessed(NamesOfFrames(file), options, label, context);
    if (guessed) {
      RecordingOptions with_guess = recording;
      with_guess.frames = *guessed;
      return ReadSequenceSession(path, with_guess, context);
    }
    NothingFound(label, options, instants.front().transforms.Names());
  }
  WarnIfCalibrationIsUnused(probe, instants.front().transforms, options, label, context);
  return Assemble(label, options, std::move(needle), std::move(probe));
}

ImportedSession SessionOfScene(SlicerScene scene, const std::string& label,
                               const ImportOptions& options, const RunContext& context) {
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
  if (!needle && !probe) {
    std::vector<transforms::TransformName> names;
    for (const auto& [name, entries] : scene.sequences) {
      names.push_back(*transforms::ParseTransformName(name));
    }
    const auto guessed = Guessed(names, options, label, context);
    if (guessed) return SessionOfScene(std::move(scene), label, *guessed, context);
    NothingFound(label, options, TransformNames(scene));
  }
  if (probe) {
    const auto instants = InstantsFor(scene, "Image", options.reference_frame);
    if (!instants.empty()) {
      WarnIfCalibrationIsUnused(probe, instants.front().transforms, options, label, context);
    }
  }
  return Assemble(label, options, std::move(needle), std::move(probe));
}

std::string ToolReport(const std::string& tool, const std::string& frame, const PoseStream& stream,
                       const std::string& option) {
  if (stream.empty()) {
    return Message(tool, ": none; a scenario with effects of the ", tool,
                   " needs it: name its "
                   "frame with ",
                   option, ", or leave these effects out\n");
  }
  const IntegrityReport report = CheckIntegrity(stream);
  const auto seen = report.num_samples - report.num_invalid;
  std::string text = Message(
      tool, ": frame ", frame, ", ", report.num_samples, " samples in ",
      RoundedText(report.duration_s, 4), " s (",
      report.median_interval_s > 0.0 ? RoundedText(1.0 / report.median_interval_s, 3) : "-",
      " Hz), seen in ",
      std::lround(100.0 * static_cast<double>(seen) / static_cast<double>(report.num_samples)),
      " %\n");
  for (const std::string& sentence : Describe(report, tool)) text += "  " + sentence + "\n";
  return text;
}

}  // namespace

ImportedSession ReadPlusSession(const fs::path& path, const ImportOptions& options,
                                const RunContext& context) {
  return ReadSequenceSession(path, {.frames = options}, context);
}

ImportedSession ReadSlicerSession(const fs::path& path, const ImportOptions& options,
                                  const RunContext& context) {
  return SessionOfScene(ReadSlicerScene(fs::is_directory(path) ? SceneOf(path) : path),
                        path.string(), options, context);
}

std::string WithoutCommonTime(const Session& session) {
  if (session.needle.empty() || session.probe.empty()) return {};
  const bool meet = session.needle.front().time_ns <= session.probe.back().time_ns &&
                    session.probe.front().time_ns <= session.needle.back().time_ns;
  if (meet) return {};
  const auto range = [](const PoseStream& stream) {
    return SecondsText(stream.front().time_ns) + " to " + SecondsText(stream.back().time_ns) + " s";
  };
  return "needle and probe have no common time: the needle's is " + range(session.needle) +
         ", the probe's " + range(session.probe) +
         "; were they recorded by two clocks? 'acus-register temporal' finds the lag between two "
         "recordings of one motion";
}

ImportedSession ReadAnySession(const fs::path& path, const ImportOptions& options,
                               const RunContext& context) {
  ImportedSession imported = ImportRecording(path, {.frames = options}, context);
  const std::string trouble = WithoutCommonTime(imported.session);
  ACUS_REQUIRE(trouble.empty(), path.string(), ": ", trouble);
  return imported;
}

ImportedSession ImportRecording(const fs::path& path, const RecordingOptions& recording,
                                const RunContext& context) {
  const ImportOptions& options = recording.frames;
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
  if (ending == ".xml") {
    return SessionOfScene(ReadPerkBuffer(path), path.string(), options, context);
  }
  if (ending == ".csv" || ending == ".txt" || ending == ".tsv" || ending == ".dat" ||
      ending == ".tum") {
    ACUS_REQUIRE(
        !recording.columns.empty(), path.string(),
        ": 'acus-import --columns MAPPING' reads it; a mapping (acus-columns/1) says which "
        "columns hold what, such as columns/optitrack_motive.json or columns/tum.json");
    ImportedSession imported;
    imported.session = ReadColumnCsv(path, recording.columns, recording.as_it_is, context);
    if (!imported.session.needle.empty()) imported.needle_frame = "of the mapping";
    if (!imported.session.probe.empty()) imported.probe_frame = "of the mapping";
    return imported;
  }
  ACUS_REQUIRE(
      ending == ".mha" || ending == ".mhd" || ending == ".nrrd", path.string(),
      ": is not a session; allowed: a session folder (with session.json), a PLUS sequence "
      "(.igs.mha, .igs.mhd, .igs.nrrd), a Slicer scene (.mrml, .mrb, or its folder), a transform "
      "buffer of Perk Tutor (.xml); with acus-import also a tracker's .csv or .txt");
  return ReadSequenceSession(path, recording, context);
}

std::string ImportReport(const ImportedSession& imported) {
  const Session& session = imported.session;
  const std::string trouble = WithoutCommonTime(session);
  std::string text = Message("reference: ", session.reference_frame, "\n") +
                     ToolReport("needle", imported.needle_frame, session.needle, "--needle") +
                     ToolReport("probe", imported.probe_frame, session.probe, "--probe");
  if (!trouble.empty()) text += "warning: " + trouble + "\n";
  if (imported.probe_mm_per_px) {
    text += Message("  an image of ", imported.probe_mm_per_px->transpose(),
                    " mm per pixel: --face-px moves the probe's origin to its transducer\n");
  }
  return text;
}

}  // namespace acus::session
