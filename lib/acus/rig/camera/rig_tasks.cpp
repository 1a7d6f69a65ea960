#include "acus/rig/camera/rig_tasks.h"

#include <CLI/CLI.hpp>
#include <memory>

#include "acus/base/config/json_file.h"
#include "acus/base/config/pose_json.h"
#include "acus/base/core/error.h"
#include "acus/base/core/text_table.h"
#include "acus/data/session/pose_csv.h"
#include "acus/data/transforms/transform_file.h"
#include "acus/rig/camera/calibration.h"
#include "acus/rig/camera/camera_hand_eye.h"
#include "acus/rig/camera/stereo.h"
#include "acus/rig/camera/stereo_pair.h"

namespace acus::camera {
namespace {

namespace fs = std::filesystem;
using Eigen::Isometry3d;
using nlohmann::json;

constexpr int kLeastCorners = 12;

struct HandEyeOptions {
  fs::path images, poses, camera;
  bool standing = false;
  double limit_mm = 5.0;
};

struct StereoOptions {
  fs::path left, right, left_camera, right_camera;
  double limit_px = 1.5;
};

std::vector<fs::path> ImagesOf(const fs::path& folder, RunContext& context) {
  auto files = ImageFiles(folder);
  for (const fs::path& file : files) context.provenance.AddInput(file);
  return files;
}

/// The board in each image in which it is seen, with the body's pose of that image.
struct PosePairs {
  std::vector<Isometry3d> reference_from_body, camera_from_board;
};

PosePairs PairsOf(const HandEyeOptions& options, const CalibrationBoard& board,
                  RunContext& context) {
  const CameraModel camera = ReadCamera(options.camera);
  context.provenance.AddInput(options.camera);
  const auto poses = session::ReadPoseCsv(options.poses, context);
  context.provenance.AddInput(options.poses);
  const auto files = ImagesOf(options.images, context);
  ACUS_REQUIRE(files.size() == poses.size(), options.poses.string(), ": has ", poses.size(),
               " poses, ", options.images.string(), " has ", files.size(),
               " images; each image, in order of its name, needs one row");
  const BoardViews found = FindBoardViews(files, board, kLeastCorners, context);
  const CameraParameters& p = camera.parameters();
  ACUS_REQUIRE(found.width_px == p.width_px && found.height_px == p.height_px,
               options.images.string(), ": its images have ", found.width_px, " x ",
               found.height_px, " pixels, the camera's file says ", p.width_px, " x ", p.height_px);
  PosePairs pairs;
  for (std::size_t i = 0; i < files.size(); ++i) {
    const BoardView& view = found.views[i];
    if (!view.rejected.empty()) context.Warn(view.file + ": " + view.rejected);
    if (!view.rejected.empty() || !poses[i].valid) continue;
    pairs.reference_from_body.push_back(poses[i].reference_from_tool.isometry());
    pairs.camera_from_board.push_back(BoardPose(view.corners, board, camera));
  }
  return pairs;
}

std::string Run(const HandEyeOptions& options, const CalibrationBoard& board,
                const fs::path& folder, RunContext& context) {
  const PosePairs pairs = PairsOf(options, board, context);
  const auto mount = options.standing ? CameraMount::kStanding : CameraMount::kOnBody;
  const CameraHandEye result = CalibrateCameraHandEye(
      pairs.reference_from_body, pairs.camera_from_board, mount, options.limit_mm);
  const std::string camera_name = options.standing ? "reference_from_camera" : "body_from_camera";
  const std::string board_name = options.standing ? "body_from_board" : "reference_from_board";
  config::WriteJson(folder / "hand_eye.json",
                    {{"format", "acus-camera-hand-eye/1"},
                     {camera_name, config::MatrixRows(result.base_from_camera)},
                     {board_name, config::MatrixRows(result.other_from_board)},
                     {"rms_mm", result.rms_mm},
                     {"rms_deg", result.rms_deg},
                     {"turn_deg", result.turn_deg},
                     {"residual_mm", result.residual_mm}});
  transforms::WriteTransform(folder / (camera_name + ".tfm"), result.base_from_camera,
                             camera_name + ": takes points of the camera's frame there (mm)");
  const Eigen::Vector3d at = result.base_from_camera.translation();
  return Message(camera_name, "  ", FixedText(at.x(), 3), "  ", FixedText(at.y(), 3), "  ",
                 FixedText(at.z(), 3), " mm\nwhat remains  ", FixedText(result.rms_mm, 3), " mm, ",
                 FixedText(result.rms_deg, 3), " deg RMS over ", result.residual_mm.size(),
                 " images\nturned by  ", FixedText(result.turn_deg, 1),
                 " deg RMS beside the main axis\n");
}

/// From its file, or calibrated with the images.
CameraModel CalibratedOrRead(const fs::path& file, const std::vector<fs::path>& images,
                             const CalibrationBoard& board, const fs::path& written,
                             RunContext& context) {
  if (!file.empty()) {
    context.provenance.AddInput(file);
    return ReadCamera(file);
  }
  const Calibration result = CalibrateCamera(images, board, {}, context);
  for (const std::string& warning : result.warnings) context.Warn(warning);
  WriteCamera(written, result.camera);
  return result.camera;
}

std::string Run(const StereoOptions& options, const CalibrationBoard& board, const fs::path& folder,
                RunContext& context) {
  const auto left = ImagesOf(options.left, context);
  const auto right = ImagesOf(options.right, context);
  const CameraModel left_camera =
      CalibratedOrRead(options.left_camera, left, board, folder / "left.json", context);
  const CameraModel right_camera =
      CalibratedOrRead(options.right_camera, right, board, folder / "right.json", context);
  const auto result = CalibrateStereo(FindBoardViews(left, board, kLeastCorners, context),
                                      FindBoardViews(right, board, kLeastCorners, context), board,
                                      left_camera, right_camera, options.limit_px);
  json views = json::array();
  std::vector<std::vector<std::string>> rows;
  for (const StereoView& view : result.views) {
    views.push_back({{"left", view.left},
                     {"right", view.right},
                     {"corners", view.corners},
                     {"rms_px", view.rms_px},
                     {"rejected", view.rejected}});
    rows.push_back({view.left, view.right, std::to_string(view.corners),
                    view.rejected.empty() ? FixedText(view.rms_px, 3) : "-", view.rejected});
  }
  json document = ToJson(StereoPair{.left = left_camera,
                                    .right = right_camera,
                                    .right_from_left = result.right_from_left,
                                    .reprojection_rms_px = result.rms_px});
  document["views"] = views;
  config::WriteJson(folder / "stereo.json", document);
  transforms::WriteTransform(
      folder / "right_from_left.tfm", result.right_from_left,
      "right_from_left: takes points of the left camera's frame to the right one's (mm)");
  return TextTable({"left", "right", "corners", "RMS px", "not used because"}, rows) +
         Message("reprojection ", FixedText(result.rms_px, 3), " px RMS; baseline ",
                 FixedText(result.baseline_mm, 3), " mm\n");
}

}  // namespace

RigTasks AddRigTasks(CLI::App& app) {
  const auto eye = std::make_shared<HandEyeOptions>();
  const auto pair = std::make_shared<StereoOptions>();
  CLI::App* hand_eye = app.add_subcommand(
      "hand-eye", "Find where a camera sits on a tracked body, from images of the board");
  hand_eye->fallthrough()
      ->add_option("images", eye->images, "Folder of images of the board")
      ->required()
      ->check(CLI::ExistingDirectory);
  hand_eye->add_option("--poses", eye->poses, "Poses of the body (.csv), one row for each image")
      ->required()
      ->check(CLI::ExistingFile);
  hand_eye->add_option("--camera-file", eye->camera, "camera.json of 'calibrate'")
      ->required()
      ->check(CLI::ExistingFile);
  hand_eye->add_flag("--standing", eye->standing,
                     "The camera stands still, the board is on the tracked body");
  hand_eye->add_option("--limit-mm", eye->limit_mm, "Larger residuals (RMS) are an error")
      ->check(CLI::Range(0.001, 1000.0))
      ->capture_default_str();
  CLI::App* stereo = app.add_subcommand(
      "stereo", "Find how two cameras stand to each other, from pairs of images");
  stereo->fallthrough()
      ->add_option("left", pair->left, "Folder of images of the left camera")
      ->required()
      ->check(CLI::ExistingDirectory);
  stereo->add_option("right", pair->right, "Folder of the right camera's, of the same moments")
      ->required()
      ->check(CLI::ExistingDirectory);
  stereo->add_option("--left-camera", pair->left_camera, "camera.json; else from the images")
      ->check(CLI::ExistingFile);
  stereo->add_option("--right-camera", pair->right_camera, "camera.json; else from the images")
      ->check(CLI::ExistingFile);
  stereo->add_option("--limit-px", pair->limit_px, "Larger reprojection errors are an error")
      ->check(CLI::Range(0.01, 100.0))
      ->capture_default_str();
  return
      [=](const fs::path& board_name, const fs::path& folder, RunContext& context) -> std::string {
        if (!hand_eye->parsed() && !stereo->parsed()) return {};
        const fs::path file = config::FindConfig(board_name, fs::current_path());
        context.provenance.AddInput(file);
        const CalibrationBoard board = ReadBoard(file);
        std::string text = hand_eye->parsed() ? Run(*eye, board, folder, context)
                                              : Run(*pair, board, folder, context);
        config::WriteJson(folder / "provenance.json", context.provenance.ToJson());
        return text;
      };
}

}  // namespace acus::camera
