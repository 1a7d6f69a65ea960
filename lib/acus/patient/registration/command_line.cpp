#include "acus/patient/registration/command_line.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <memory>
#include <vector>

namespace acus::registration {
namespace {

using CLI::ExistingFile;
using CLI::ExistingPath;
using CLI::Range;

/// Everything that options write into.
struct Tasks {
  LandmarkTask landmarks = {};
  PivotTask pivot = {};
  TouchTask touch = {};
  HandEyeTask hand_eye = {};
  TemporalTask temporal = {};
  FacetTask facets = {};
  ProbeTask probe = {};
  TrackerTask tracker = {};
  SurfaceTask surface = {};
  WarpTask warp = {};
  std::filesystem::path folder = {};
  std::filesystem::path target = {};

  /// What is the same for every registration of points.
  void Share() {
    pivot.robust = landmarks.settings.leave_out_outliers;
    landmarks.target = touch.target = facets.target = surface.target = target;
    touch.settings = facets.settings = landmarks.settings;
    probe.settings.confidence = landmarks.settings.confidence;
  }
};

void AddLandmarks(CLI::App& app, Tasks& tasks) {
  LandmarkTask& task = tasks.landmarks;
  app.add_option("--from", task.from, "Landmarks in the tracker's or mannequin's frame")
      ->check(ExistingFile);
  app.add_option("--to", task.to, "The same in CT (.csv, .mrk.json, .fcsv)")->check(ExistingFile);
  app.add_option("--target", tasks.target, "Points in CT whose expected error is reported")
      ->check(ExistingFile);
  app.add_option("--fle-mm", task.settings.fle_rms_mm,
                 "Localisation error, RMS; else from the residuals")
      ->check(Range(1e-6, 1e3));
  app.add_option("--leave-out", task.leave_out, "Landmarks not to use, by name");
  app.add_flag("--robust", task.settings.leave_out_outliers, "Exclude points that do not fit");
  app.add_flag("--find-order", task.settings.find_order, "Find which point is which, of up to 40");
  app.add_option("--confidence", task.settings.confidence,
                 "Of the bound that is stated for the error at a target")
      ->check(Range(0.5, 0.9999));
  app.add_option("-o,--output", tasks.folder, "Folder to make")->required();
}

void AddTool(CLI::App& command, LogTool& tool) {
  command.add_option("--tool", tool.tool, "Name of the pointer in the recording");
  command.add_option("--reference", tool.reference, "Name of the reference in the recording");
}

CLI::App* AddPivot(CLI::App& app, PivotTask& task) {
  CLI::App* command = app.add_subcommand("pivot", "Find the tip of a pointer turned about it");
  command
      ->add_option("poses", task.poses,
                   "Folders or files of 4 x 4 numbers, .csv streams, or sequences")
      ->required()
      ->check(ExistingPath);
  AddTool(*command, task.tool);
  command->add_option("--limit-mm", task.limit_mm, "Larger residuals (RMS length) are an error")
      ->check(Range(0.001, 1000.0))
      ->capture_default_str();
  command->add_flag("--as-it-is", task.as_it_is,
                    "Accept a tip that seems to be in another unit than mm");
  return command;
}

CLI::App* AddTouch(CLI::App& app, TouchTask& task) {
  CLI::App* command = app.add_subcommand(
      "touch", "Register points that were touched one after the other with a pointer");
  command->add_option("log", task.pointer.log, "Recording of the pointer: .csv, session, sequence")
      ->required()
      ->check(ExistingPath);
  command->add_option("--known", task.known, "The points that were touched, in their order")
      ->required()
      ->check(ExistingFile);
  AddTool(*command, task.pointer);
  auto* tip = command->add_option("--tip-mm", task.tip_mm, "Tip in the pointer's frame: x,y,z")
                  ->delimiter(',');
  command->add_option("--pivot", task.pivot, "Or the registration.json of a pivot calibration")
      ->check(ExistingFile)
      ->excludes(tip);
  command->add_option("--still-mm", task.touches.still_mm, "How much the tip moves at rest")
      ->check(Range(0.01, 100.0));
  command->add_option("--least-s", task.touches.least_s, "How long it rests")
      ->check(Range(0.2, 60.0));
  command->add_option("--shaft-mm", task.touches.shaft_mm, "How much the shaft moves, if pivoted")
      ->check(Range(0.0, 500.0));
  command->add_option("--average-from-s", task.touches.average_from_s, "What of a rest is averaged")
      ->check(Range(0.0, 60.0));
  command->add_option("--average-to-s", task.touches.average_to_s, "Its end; default: all of it")
      ->check(Range(0.0, 60.0));
  return command;
}

CLI::App* AddHandEye(CLI::App& app, HandEyeTask& task) {
  CLI::App* command = app.add_subcommand(
      "hand-eye", "Find how a marker sits on a haptic handle, and where the tracker stands");
  command->add_option("--device", task.device.log, "Recording of the handle: .csv or session")
      ->required()
      ->check(ExistingPath);
  command->add_option("--tracker", task.tracker.log, "Recording of the marker on it")
      ->required()
      ->check(ExistingPath);
  command->add_option("--tool", task.tracker.tool, "Name of the marker in the tracker's recording");
  command->add_option("--reference", task.tracker.reference, "Name of the tracker's frame");
  command->add_option("--device-tool", task.device.tool,
                      "Name of the tool in the device's session");
  command->add_option("--delay-s", task.delay_s, "Added to the tracker's times")
      ->check(Range(-1e9, 1e9));
  command->add_option("--limit-mm", task.limit_mm, "Larger residuals (RMS) are an error")
      ->check(Range(0.001, 1000.0))
      ->capture_default_str();
  return command;
}

CLI::App* AddTemporal(CLI::App& app, TemporalTask& task) {
  CLI::App* command = app.add_subcommand(
      "temporal", "Find the lag between the clocks of two recordings of one motion");
  command
      ->add_option("--tracker", task.tracker.log, "Recording of a tool that moves back and forth")
      ->required()
      ->check(ExistingPath);
  command->add_option("--tool", task.tracker.tool, "Name of the tool in that recording");
  command->add_option("--reference", task.tracker.reference, "Name of its reference");
  auto* other = command->add_option("--other", task.other.log, "Another tracker's recording of it")
                    ->check(ExistingPath);
  command->add_option("--other-tool", task.other.tool, "Name of the tool in the other recording");
  command->add_option("--other-reference", task.other.reference, "Name of its reference");
  command
      ->add_option("--video", task.video,
                   "Or: a PLUS sequence of images in which a line moves (bottom of a water tank)")
      ->check(ExistingFile)
      ->excludes(other);
  command->add_option("--max-lag-s", task.settings.max_lag_s, "Lags up to this are searched")
      ->check(Range(0.001, 60.0))
      ->capture_default_str();
  command->add_option("--delay-s", task.delay_s, "Added to the other's times before the search")
      ->check(Range(-1e9, 1e9));
  command->callback([&task] {
    if (task.other.log.empty() && task.video.empty())
      throw CLI::RequiredError("--other or --video");
  });
  return command;
}

CLI::App* AddFacets(CLI::App& app, FacetTask& task) {
  CLI::App* command = app.add_subcommand(
      "facets", "Make one object of several facets of markers, and register it to CT");
  command->add_option("--points", task.points, "Points of each facet in its own frame (.csv)")
      ->required()
      ->check(ExistingFile);
  command->add_option("--poses", task.poses, "Poses of the facets over time (.csv)")
      ->required()
      ->check(ExistingFile);
  command->add_option("--ct", task.ct, "The same points in CT (.csv)")->check(ExistingFile);
  return command;
}

CLI::App* AddProbe(CLI::App& app, ProbeTask& task) {
  CLI::App* command = app.add_subcommand(
      "probe", "Find where the pixels of an ultrasound probe's images are on its marker");
  command
      ->add_option(
          "points", task.points,
          "Points in the images: time_s, u_px, v_px and wire, or tip_x_mm to tip_z_mm (.csv)")
      ->required()
      ->check(ExistingFile);
  command->add_option("--phantom", task.phantom, "Its N-wires: PLUS configuration (.xml) or .csv")
      ->check(ExistingFile);
  command
      ->add_option("--phantom-pose", task.phantom_pose,
                   "Phantom in the reference frame; default: PhantomToReference of --phantom")
      ->check(ExistingFile);
  command
      ->add_option("--log", task.probe.log,
                   "Recording of the probe's marker; default: poses beside the points")
      ->check(ExistingPath);
  command->add_option("--tool", task.probe.tool, "Name of the probe in the recording");
  command->add_option("--reference", task.probe.reference, "Name of the reference in it");
  command->add_option("--image-px", task.image_px, "Columns,rows of the images")
      ->delimiter(',')
      ->expected(2)
      ->check(Range(1.0, 1e5));
  command->add_option("--limit-mm", task.settings.limit_mm, "Larger residuals (RMS) are an error")
      ->check(Range(0.001, 1000.0))
      ->capture_default_str();
  return command;
}

CLI::App* AddTracker(CLI::App& app, TrackerTask& task) {
  CLI::App* command = app.add_subcommand(
      "tracker", "Measure jitter of tools that lie still, and accuracy over known places");
  command->add_option("log", task.log, "Recording of still tools: .csv, session, sequence")
      ->check(ExistingPath);
  command->add_option("--tool", task.tools, "Names of the tools; default: all");
  command->add_option("--reference", task.reference, "Frame of the poses in a sequence");
  command->add_option("--still-mm", task.still_mm, "How much a still tool may move")
      ->check(Range(0.01, 100.0));
  command->add_option("--measured", task.measured, "Places as the tracker gave them")
      ->check(ExistingFile);
  command->add_option("--known", task.known, "The same places as they are")->check(ExistingFile);
  return command;
}

CLI::App* AddSurface(CLI::App& app, SurfaceTask& task) {
  CLI::App* command =
      app.add_subcommand("surface", "Register points swept over the skin to the CT's skin");
  command->add_option("points", task.points, "Points, or a recording of the pointer")
      ->required()
      ->check(ExistingPath);
  command->add_option("--skin", task.surface, "The CT's skin (.stl, .ply, .obj, .vtp, .vtk)")
      ->required()
      ->check(ExistingFile);
  command->add_option("--start", task.start, "A rough ct_from_reference.tfm")->check(ExistingFile);
  AddTool(*command, task.pointer);
  command->add_option("--tip-mm", task.tip_mm, "Tip in the pointer's frame: x,y,z")->delimiter(',');
  command->add_option("--keep", task.settings.keep, "Share of the points, the nearest, that count")
      ->check(Range(0.1, 1.0));
  command->add_option("--starts", task.settings.num_starts, "How many poses are tried")
      ->check(Range(1, 10000));
  return command;
}

CLI::App* AddWarp(CLI::App& app, WarpTask& task) {
  CLI::App* command =
      app.add_subcommand("warp", "Give CT and labels the shape of a torso mannequin");
  command->add_option("--ct", task.ct, "CT: DICOM folder, .nii.gz, .nrrd, .mha")
      ->required()
      ->check(ExistingPath);
  command->add_option("--labels", task.labels, "Its tissues, as of acus-segment")
      ->required()
      ->check(ExistingFile);
  command->add_option("--skin", task.skin, "Its skin, as of acus-segment")
      ->required()
      ->check(ExistingFile);
  command->add_option("--mannequin", task.mannequin, "The mannequin's surface, or points on it")
      ->required()
      ->check(ExistingFile);
  command->add_option("--transform", task.transform, "The mannequin's ct_from_reference.tfm")
      ->check(ExistingFile);
  command->add_option("--lattice-mm", task.settings.lattice_mm, "Distance of the field's nodes")
      ->check(Range(2.0, 50.0));
  command->add_option("--bone", task.settings.bone_modulus, "Stiffness over that of soft tissue")
      ->check(Range(1.0, 1e5));
  command->add_option("--reach-mm", task.settings.reach_mm, "Farther points do not count")
      ->check(Range(1.0, 500.0));
  return command;
}

/// Options for landmarks may stand behind a subcommand; one that it would ignore is an error.
void RefuseIgnored(const CLI::App& app, const Command& command) {
  for (const char* name :
       {"from", "to", "target", "fle-mm", "leave-out", "robust", "find-order", "confidence"}) {
    const std::string option = std::string("--") + name;
    if (app.count(option) == 0 || std::ranges::count(command.shared_options, name) > 0) continue;
    throw CLI::ValidationError(option, "is not for " + command.app->get_name() + "; leave it out");
  }
}

}  // namespace

std::function<std::string(RunContext& context)> AddTasks(CLI::App& app,
                                                         const std::vector<Command>& others) {
  const auto tasks = std::make_shared<Tasks>();
  AddLandmarks(app, *tasks);
  const auto runner = [tasks](auto member) {
    return [tasks, member](const std::filesystem::path& folder, RunContext& context) {
      return Run((*tasks).*member, folder, context);
    };
  };
  const std::vector<std::string> of_points = {"target", "fle-mm", "robust", "find-order",
                                              "confidence"};
  std::vector<Command> commands = {
      {AddPivot(app, tasks->pivot), runner(&Tasks::pivot), {"robust"}},
      {AddTouch(app, tasks->touch), runner(&Tasks::touch), of_points},
      {AddHandEye(app, tasks->hand_eye), runner(&Tasks::hand_eye), {}},
      {AddTemporal(app, tasks->temporal), runner(&Tasks::temporal), {}},
      {AddFacets(app, tasks->facets), runner(&Tasks::facets), of_points},
      {AddProbe(app, tasks->probe), runner(&Tasks::probe), {"confidence"}},
      {AddTracker(app, tasks->tracker), runner(&Tasks::tracker), {}},
      {AddSurface(app, tasks->surface), runner(&Tasks::surface), {"target"}},
      {AddWarp(app, tasks->warp), runner(&Tasks::warp), {}}};
  commands.insert(commands.end(), others.begin(), others.end());
  for (const Command& command : commands) command.app->fallthrough();
  app.require_subcommand(0, 1);
  app.callback([tasks, commands, &app] {
    for (const Command& command : commands) {
      if (command.app->parsed()) RefuseIgnored(app, command);
    }
    const bool has_pairs = !tasks->landmarks.from.empty() && !tasks->landmarks.to.empty();
    if (app.get_subcommands().empty() && !has_pairs) throw CLI::RequiredError("--from and --to");
  });
  return [tasks, commands, landmarks = runner(&Tasks::landmarks)](RunContext& context) {
    tasks->Share();
    for (const Command& command : commands) {
      if (command.app->parsed()) return command.run(tasks->folder, context);
    }
    return landmarks(tasks->folder, context);
  };
}

}  // namespace acus::registration
