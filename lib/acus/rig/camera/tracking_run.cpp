#include "acus/rig/camera/tracking_run.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>

#include "acus/base/config/json_file.h"
#include "acus/base/core/error.h"
#include "acus/base/core/random.h"
#include "acus/base/core/text_table.h"
#include "acus/data/session/pose_csv.h"
#include "acus/rig/camera/mannequin_camera.h"
#include "acus/rig/camera/pair_pose.h"

namespace acus::camera {
namespace {

std::string ImageName(int number) {
  char name[32];
  std::snprintf(name, sizeof name, "%04d.png", number);
  return name;
}

std::int64_t TimeNs(std::size_t image, double rate_hz) {
  return std::llround(1e9 * static_cast<double>(image) / rate_hz);
}

std::string FolderOf(const std::string& name, std::size_t camera) {
  return camera == 0 ? name : name + "_right";
}

/// Each camera has noise of its own.
std::uint64_t NoiseOf(int image, std::size_t camera) {
  return static_cast<std::uint64_t>(image) + (std::uint64_t{camera} << 40);
}

Image ReadOfSize(const std::filesystem::path& file, const CameraModel& camera) {
  Image image = ReadImage(file);
  const CameraParameters& p = camera.parameters();
  ACUS_REQUIRE(image.width_px == p.width_px && image.height_px == p.height_px, file.string(),
               ": has ", image.width_px, " x ", image.height_px, " pixels, the camera's file says ",
               p.width_px, " x ", p.height_px, "; use the camera's own file");
  return image;
}

TrackingRun EmptyRun(const FacetSet& facets, double rate_hz) {
  ACUS_REQUIRE(rate_hz > 0.0 && rate_hz <= 10000.0, "images at ", rate_hz,
               " Hz; allowed is above 0 to 10000");
  TrackingRun run;
  run.rate_hz = rate_hz;
  for (const FacetObject& object : facets.objects) {
    run.objects.push_back({.name = object.name, .poses = {}});
  }
  return run;
}

/// The last pose that is clear.
std::optional<Eigen::Isometry3d> Before(const TrackedObject& object) {
  if (object.poses.empty() || !object.poses.back() || object.poses.back()->ambiguous) return {};
  return object.poses.back()->camera_from_object;
}

/// Seen from the camera: z of the object towards it, y up, tilted about an axis in the image.
Eigen::Isometry3d Facing(const Eigen::Vector3d& at_mm, double tilt_rad, double azimuth_rad) {
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  const Eigen::Vector3d axis(std::cos(azimuth_rad), std::sin(azimuth_rad), 0.0);
  pose.linear() = (Eigen::AngleAxisd(tilt_rad, axis) *
                   Eigen::AngleAxisd(std::numbers::pi, Eigen::Vector3d::UnitX()))
                      .toRotationMatrix();
  pose.translation() = at_mm;
  return pose;
}

void WriteMovingObjects(const std::filesystem::path& folder, std::span<const Viewpoint> cameras,
                        const FacetSet& facets, int count, const RunContext& context) {
  std::vector<BodyInView> bodies;
  if (facets.Find("Reference") != nullptr) {
    bodies.push_back({.object = "Reference", .surface = PlainTorso()});
  }
  std::vector<MannequinCamera> makers;
  for (const Viewpoint& view : cameras)
    makers.emplace_back(*view.camera, facets, bodies, ImageMaking{});
  std::vector<session::PoseStream> truth(facets.objects.size());
  Image image;
  for (int i = 0; i < count; ++i) {
    context.Checkpoint("Drawing", static_cast<double>(i) / count);
    std::vector<ObjectInView> shown;
    for (std::size_t o = 0; o < facets.objects.size(); ++o) {
      const FacetObject& object = facets.objects[o];
      // Each object's first facet towards the camera, side by side, swaying.
      const double phase = 2.0 * std::numbers::pi * i / 60.0 + static_cast<double>(o);
      const double place =
          static_cast<double>(o) - 0.5 * static_cast<double>(facets.objects.size() - 1);
      const Eigen::Vector3d at(280.0 * place + 20.0 * std::sin(phase), 15.0 * std::cos(phase),
                               1000.0);
      const Eigen::Isometry3d pose = Facing(at, 0.35 + 0.1 * std::sin(phase), 0.7 * phase) *
                                     object.markers[0].object_from_marker.inverse();
      shown.push_back({object.name, pose});
      session::PoseSample sample;
      sample.time_ns = TimeNs(static_cast<std::size_t>(i), 30.0);
      sample.valid = true;
      sample.reference_from_tool = transforms::Pose(pose);
      truth[o].push_back(sample);
    }
    for (std::size_t c = 0; c < cameras.size(); ++c) {
      std::vector<ObjectInView> here = shown;
      for (ObjectInView& object : here) {
        object.camera_from_object = cameras[c].here_from_first * object.camera_from_object;
      }
      makers[c].Render(here, NoiseOf(i, c) + context.seed, image);
      WriteImage(folder / FolderOf("facets", c) / ImageName(i), image);
    }
  }
  for (std::size_t o = 0; o < truth.size(); ++o) {
    session::WritePoseCsv(folder / "truth" / (facets.objects[o].name + ".csv"), truth[o]);
  }
}

void WriteBoards(const std::filesystem::path& folder, std::span<const Viewpoint> cameras,
                 const CalibrationBoard& board, int count, const RunContext& context) {
  Image image;
  // As far off as fills half of the image with it.
  const CameraParameters& p = cameras[0].camera->parameters();
  const double z = 2.0 * board.square_mm * board.rows * p.focal_px[1] / p.height_px * 0.6;
  for (int i = 0; i < count; ++i) {
    context.Checkpoint("Drawing", static_cast<double>(i) / count);
    RandomStream random(context.seed, "sample board", static_cast<std::uint64_t>(i));
    const Eigen::Vector3d at((0.4 * (i % 4) - 0.6) * 0.6 * z * p.width_px / p.focal_px[0],
                             (i / 4 % 3 - 1) * 0.3 * z * p.height_px / p.focal_px[1], z);
    const Eigen::Isometry3d pose =
        Facing(at, random.Uniform(0.2, 0.7), random.Uniform(0.0, 2.0 * std::numbers::pi)) *
        Eigen::AngleAxisd(random.Uniform(-std::numbers::pi, std::numbers::pi),
                          Eigen::Vector3d::UnitZ());
    for (std::size_t c = 0; c < cameras.size(); ++c) {
      RenderBoard(*cameras[c].camera, board, cameras[c].here_from_first * pose, {.colour = false},
                  NoiseOf(i, c), image);
      WriteImage(folder / FolderOf("board", c) / ImageName(i), image);
    }
  }
}

}  // namespace

int TrackedObject::Seen() const {
  return static_cast<int>(
      std::count_if(poses.begin(), poses.end(), [](const auto& pose) { return pose.has_value(); }));
}

double TrackedObject::JitterMm() const {
  if (Seen() < 2) return 0.0;
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (const auto& pose : poses) {
    if (pose) mean += pose->camera_from_object.translation() / Seen();
  }
  double sum = 0.0;
  for (const auto& pose : poses) {
    if (pose) sum += (pose->camera_from_object.translation() - mean).squaredNorm();
  }
  return std::sqrt(sum / Seen());
}

TrackingRun TrackImages(const std::vector<std::filesystem::path>& images, const CameraModel& camera,
                        const FacetSet& facets, double rate_hz, const RunContext& context) {
  TrackingRun run = EmptyRun(facets, rate_hz);
  MarkerDetector detector(facets.dictionary);
  for (std::size_t i = 0; i < images.size(); ++i) {
    context.Checkpoint("Tracking", static_cast<double>(i) / static_cast<double>(images.size()));
    run.files.push_back(images[i].filename().string());
    const auto seen = detector.Detect(ReadOfSize(images[i], camera), &camera);
    for (std::size_t o = 0; o < facets.objects.size(); ++o) {
      TrackedObject& object = run.objects[o];
      object.poses.push_back(LocateObject(facets.objects[o], seen, camera, {}, Before(object)));
    }
  }
  return run;
}

TrackingRun TrackPairs(const std::vector<std::filesystem::path>& left,
                       const std::vector<std::filesystem::path>& right, const StereoPair& pair,
                       const FacetSet& facets, double rate_hz, const RunContext& context) {
  ACUS_REQUIRE(left.size() == right.size(), "there are ", left.size(),
               " images of the left camera, but ", right.size(),
               " of the right; both need one of each moment, in the same order");
  TrackingRun run = EmptyRun(facets, rate_hz);
  MarkerDetector detector(facets.dictionary);
  PairAgreement agreement;
  for (std::size_t i = 0; i < left.size(); ++i) {
    context.Checkpoint("Tracking", static_cast<double>(i) / static_cast<double>(left.size()));
    run.files.push_back(left[i].filename().string());
    const auto in_left = detector.Detect(ReadOfSize(left[i], pair.left), &pair.left);
    const auto in_right = detector.Detect(ReadOfSize(right[i], pair.right), &pair.right);
    for (std::size_t o = 0; o < facets.objects.size(); ++o) {
      TrackedObject& object = run.objects[o];
      const auto found =
          LocateObjectInPair(facets.objects[o], in_left, in_right, pair, {}, Before(object));
      object.poses.push_back(found ? std::optional(found->pose) : std::nullopt);
      if (!found) continue;
      agreement.Count(found->use);
      object.by_pair += found->use == PairUse::kBoth ? 1 : 0;
    }
  }
  if (agreement.disagreed() > agreement.agreed()) throw NoAnswerError(agreement.Problem());
  return run;
}

std::string TableText(const TrackingRun& run) {
  std::vector<std::vector<std::string>> rows;
  for (const TrackedObject& object : run.objects) {
    double rms = 0.0, sigma_mm = 0.0, sigma_deg = 0.0;
    int ambiguous = 0;
    const int seen = std::max(1, object.Seen());
    for (const auto& pose : object.poses) {
      if (!pose) continue;
      rms += pose->rms_px * pose->rms_px / seen;
      sigma_mm += pose->PositionSigmaMm() / seen;
      sigma_deg += pose->AngleSigmaDeg() / seen;
      ambiguous += pose->ambiguous ? 1 : 0;
    }
    rows.push_back({object.name, std::to_string(object.Seen()), std::to_string(object.by_pair),
                    std::to_string(ambiguous), FixedText(std::sqrt(rms), 3), FixedText(sigma_mm, 3),
                    FixedText(sigma_deg, 3), FixedText(object.JitterMm(), 3)});
  }
  return TextTable({"object", "seen", "by pair", "ambiguous", "corners RMS px", "expected mm",
                    "expected deg", "about its mean, RMS mm"},
                   rows) +
         Message(run.files.size(), " images\n");
}

void WriteResult(const std::filesystem::path& folder, const TrackingRun& run,
                 const RunContext& context) {
  for (const TrackedObject& object : run.objects) {
    session::PoseStream stream;
    session::PoseSample sample;
    for (std::size_t i = 0; i < object.poses.size(); ++i) {
      sample.time_ns = TimeNs(i, run.rate_hz);
      const auto& pose = object.poses[i];
      sample.valid = pose && !pose->ambiguous;
      if (sample.valid) sample.reference_from_tool = transforms::Pose(pose->camera_from_object);
      stream.push_back(sample);
    }
    session::WritePoseCsv(folder / (object.name + ".csv"), stream);
  }
  config::WriteJson(folder / "provenance.json", context.provenance.ToJson());
}

void WriteSamples(const std::filesystem::path& folder, std::span<const Viewpoint> cameras,
                  const CalibrationBoard& board, const FacetSet& facets, int count,
                  const RunContext& context) {
  std::filesystem::create_directories(folder / "truth");
  for (std::size_t c = 0; c < cameras.size(); ++c) {
    for (const char* name : {"board", "facets"}) {
      std::filesystem::create_directories(folder / FolderOf(name, c));
    }
  }
  WriteBoards(folder, cameras, board, count, context);
  WriteMovingObjects(folder, cameras, facets, count, context);
  config::WriteJson(folder / "provenance.json", context.provenance.ToJson());
}

}  // namespace acus::camera
