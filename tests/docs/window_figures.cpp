// Images of the window of a live session, of a patient that acus-phantom made:
//   window_figures PATIENT OUT_FOLDER    under xvfb-run
// Writes window_*.png for docs/clinician_tutorial.md. With --rate it says how fast the window is
// instead.
#include <algorithm>
#include <cmath>
#include <ctime>
#include <fstream>
#include <iostream>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "acus/base/config/json_file.h"
#include "acus/base/config/pose_json.h"
#include "acus/base/core/csv.h"
#include "acus/base/core/run_context.h"
#include "acus/data/session/session_io.h"
#include "acus/data/volume/volume_io.h"
#include "acus/imaging/fluoroscopy/fluoroscope.h"
#include "acus/imaging/slicing/ct_slice.h"
#include "acus/imaging/ultrasound/aperture/aperture_renderer.h"
#include "acus/scene/effects/view_3d/patient_surfaces.h"
#include "acus/window/marks.h"
#include "acus/window/orbit.h"
#include "acus/window/volume_renderer.h"
#include "acus/window/window.h"
#include "support/window_input.h"

namespace acus {
namespace {

namespace fs = std::filesystem;

const fs::path kConfigs = fs::path(ACUS_SOURCE_DIR) / "configs";

struct Demo {
  volume::LabelMap labels;
  window::PatientOnDisplay patient;
  window::DisplayFrame frame;
};

Eigen::Isometry3d CtFromReference(const fs::path& patient) {
  return config::PoseFromRows(config::ReadJson(patient / "truth.json").at("reference_from_ct"))
      .inverse();
}

/// Needle and probe of the recorded session, at this share of the needle's way.
void PlaceTools(const fs::path& patient, double share, window::DisplayFrame& frame) {
  const fs::path folder = fs::directory_iterator(patient / "sessions")->path();
  const session::Session session = session::ReadSession(folder, RunContext());
  const Eigen::Isometry3d ct_from_reference = CtFromReference(patient);
  const Eigen::Vector3d start = session.needle.front().reference_from_tool.translation();
  const auto way_mm = [&](const session::PoseSample& sample) {
    return (sample.reference_from_tool.translation() - start).norm();
  };
  double longest_mm = 0.0;
  for (const auto& sample : session.needle) longest_mm = std::max(longest_mm, way_mm(sample));
  for (const auto& sample : session.needle) {
    if (!sample.valid || way_mm(sample) < share * longest_mm) continue;
    const Eigen::Isometry3d pose = ct_from_reference * sample.reference_from_tool;
    frame.needle.emplace();
    frame.needle->tip_in_ct_mm = pose.translation();
    frame.needle->axis_in_ct = pose.linear().col(2);
    frame.needle->length_mm = 150.0;
    frame.needle->radius_mm = 0.6;
    const auto seen =
        std::ranges::lower_bound(session.probe, sample.time_ns, {}, &session::PoseSample::time_ns);
    if (seen != session.probe.end()) {
      frame.ct_from_probe = ct_from_reference * seen->reference_from_tool;
    }
    return;
  }
}

std::vector<volume_rendering::SurfaceInView> Surfaces(const volume::LabelMap& labels) {
  effects::View3dSettings effect;
  effect.surface_grid_mm = 3.0;
  const auto add = [&](const char* tissue, double opacity) {
    effect.surfaces.push_back({.tissue = tissue, .opacity = opacity, .colour = std::nullopt});
  };
  for (const char* tissue : {"bone", "kidney", "vessel", "lesion"}) add(tissue, 1.0);
  add("liver", 0.55);
  effect.surfaces.push_back(
      {.tissue = "skin", .opacity = 0.38, .colour = Eigen::Array3f(0.96F, 0.82F, 0.72F)});
  return effects::SurfacesOf(effect, labels, RunContext());
}

/// A mannequin on a table, as a camera at its feet on the right side sees it.
void FilmMannequin(Demo& demo) {
  volume_rendering::PatientInView mannequin;
  mannequin.surfaces.push_back(demo.patient.in_teaching_view.back());
  mannequin.surfaces.back().opacity = 1.0;
  mannequin.surfaces.back().colour = {0.86F, 0.72F, 0.62F};
  volume_rendering::ViewSettings look;
  look.background_top = {0.44F, 0.47F, 0.50F};
  look.background_bottom = {0.30F, 0.36F, 0.40F};
  volume_rendering::PatientView view(mannequin, look);
  window::VideoImage& video = demo.frame.video.emplace();
  const Eigen::Vector3d middle = view.box_in_ct_mm().center();
  video.camera =
      volume_rendering::LookAt({.eye_in_ct_mm = middle + Eigen::Vector3d(-620, -560, 230),
                                .focus_in_ct_mm = middle + Eigen::Vector3d(-20, 0, 0),
                                .up_in_ct = Eigen::Vector3d(0.0, -1.0, 0.0),
                                .view_angle_deg = 34.0},
                               {.width_px = 640, .height_px = 480});
  volume_rendering::ViewImage image;
  volume_rendering::ViewMoment moment;
  moment.needle = demo.frame.needle;
  moment.probe.emplace();
  moment.probe->ct_from_probe = *demo.frame.ct_from_probe;
  moment.probe->probe = demo.frame.ultrasound.probe.get();
  moment.probe->plane = false;
  view.Render(video.camera, moment, image, 2);
  video.image = std::move(image.colour);
  video.pose_valid = true;
}

Demo Load(const fs::path& patient) {
  Demo demo;
  auto ct = std::make_shared<volume::CtVolume>(volume::ReadCt(patient / "ct.nrrd", "", {}));
  demo.labels = volume::ReadTissues(patient / "labels.seg.nrrd");
  PlaceTools(patient, 0.8, demo.frame);
  const CsvTable target(patient / "target_ct.csv");
  demo.frame.target_in_ct_mm = Eigen::Vector3d(target.Numbers("x_mm")[0], target.Numbers("y_mm")[0],
                                               target.Numbers("z_mm")[0]);
  const acoustics::Probe probe = acoustics::ReadProbe(kConfigs / "probes/curvilinear_c5_2.json");
  const auto table = acoustics::ReadTissueAcoustics(kConfigs / "acoustics/tissues.json");
  window::DisplayFrame& frame = demo.frame;
  frame.tip_to_target_mm = window::ImagedTipToTargetMm(frame);
  ultrasound::ApertureRenderer({.labels = &demo.labels, .acoustics = &table}, probe, {})
      .Render(*frame.ct_from_probe, frame.needle, frame.ultrasound.image, 2);
  frame.ultrasound.probe = std::make_shared<acoustics::Probe>(probe);
  slicing::CtSliceRenderer(*ct, acoustics::ImageOf(probe), 1.0)
      .Render(*frame.ct_from_probe, frame.needle, frame.ct_slice);
  fluoroscopy::CArmPose c_arm;
  c_arm.isocentre_in_ct_mm = *frame.target_in_ct_mm;
  fluoroscopy::Fluoroscope(*ct, fluoroscopy::ReadCArm(kConfigs / "c_arms/mobile.json"), c_arm)
      .Render(frame.needle, frame.effects.emplace_back("fluoroscopy", "Fluoroscopy").pixels.gray,
              2);
  demo.patient.in_teaching_view = Surfaces(demo.labels);
  demo.patient.in_overlay.ct = ct;
  demo.patient.in_overlay.layers = {{"bone", 1.0}, {"soft_tissue", 0.6}};
  FilmMannequin(demo);
  volume_rendering::PatientInView with_organs = demo.patient.in_overlay;
  with_organs.layers = {{"bone", 1.0}};
  for (const auto& surface : demo.patient.in_teaching_view) {
    if (surface.name != "bone") with_organs.surfaces.push_back(surface);
  }
  demo.patient.in_volume_view.push_back({"bone and organs", with_organs});
  for (const char* preset : {"skin", "bone", "soft_tissue", "vessels"}) {
    volume_rendering::PatientInView look = demo.patient.in_overlay;
    look.layers = {{preset, 1.0}};
    demo.patient.in_volume_view.push_back({preset, look});
  }
  frame.session_s = 83.4;
  frame.force = {.needle_n = 1.24, .probe_n = 3.1, .limit_n = 5.0};
  frame.latency = {.device_to_force_ms = 0.31,
                   .tracker_to_image_ms = 48.0,
                   .images_per_s = 30.0,
                   .missed_steps = 0};
  frame.status = {{window::Severity::kGood, "Needle and probe are seen. Forces are on."},
                  {window::Severity::kNote, "Recording: liver biopsy, trainee T07."}};
  return demo;
}

/// Smaller than on the screen: photographs in the text, not measurements.
void Save(const image::ColourImage& image, const fs::path& path) {
  const cv::Mat rgb(image.height, image.width, CV_8UC3,
                    const_cast<std::uint8_t*>(image.rgb.data()));
  cv::Mat bgr;
  cv::cvtColor(rgb, bgr, cv::COLOR_RGB2BGR);
  cv::resize(bgr, bgr, {}, 0.75, 0.75, cv::INTER_AREA);
  cv::imwrite(path.string(), bgr, {cv::IMWRITE_PNG_COMPRESSION, 9});
}

void Settle(window::Window& window, const window::DisplayFrame& frame) {
  for (int i = 0; i < 4; ++i) window.Show(frame);
}

void MakeFigures(Demo& demo, const fs::path& out) {
  window::WindowSettings settings;
  settings.overlay_in_background = false;
  settings.overlay_scale = 1.0;
  settings.max_triangles = 60000;
  settings.volume_in_background = false;
  window::Window window(demo.patient, settings);
  testing_support::WindowInput input;
  const auto save = [&](const char* name) {
    Settle(window, demo.frame);
    Save(window.Screenshot(), out / (std::string("window_") + name + ".png"));
  };
  save("all");
  for (const char* name : {"video", "ultrasound", "3d", "ct", "fluoroscopy"}) {
    input.Key("v");
    // From the patient's right, where the tools are.
    if (std::string(name) == "3d") input.Key("4");
    save(name);
  }
  input.Key("v");
  input.Key("m");
  Settle(window, demo.frame);  // The next key counts the views that are there.
  input.Key("7");
  for (int i = 0; i < 4; ++i) input.Key("v");
  input.Key("c");
  input.Key("c");
  for (int i = 0; i < 12; ++i) window.Show(demo.frame);
  save("volume");
  input.Key("m");
  input.Key("7");
  input.Key("a");
  input.Key("h");
  save("help");
  input.Key("h");
  demo.frame.ultrasound.frozen = true;
  demo.frame.force.needle_n = 4.97;
  demo.frame.status = {
      {window::Severity::kFault,
       "The tracker does not see the needle: forces are off. Turn it towards the camera."},
      {window::Severity::kWarning, "Forces were limited to 5 N."},
      {window::Severity::kNote, "Recording: liver biopsy, trainee T07."}};
  save("fault");
  demo.frame.ultrasound.frozen = false;
  input.Key("s");
  input.Key("v");
  input.Key("v");
  input.Key("v");
  save("stereo");
  input.Key("s");
  save("red_cyan");
}

/// CPU time of an image of the volume view, for each look, in two sizes.
void MeasureVolume(const Demo& demo) {
  const window::Orbit orbit({Eigen::Vector3d(-170, -120, -150), Eigen::Vector3d(170, 120, 150)});
  for (std::size_t look = 0; look < demo.patient.in_volume_view.size(); ++look) {
    window::VolumeRenderer renderer(demo.patient.in_volume_view, /*in_background=*/false);
    std::cout << "volume, " << demo.patient.in_volume_view[look].name << ":";
    for (const int height_px : {150, 150, 300, 600}) {  // The first one makes the look.
      window::VolumeMoment moment;
      moment.camera = orbit.CameraFor(height_px * 4 / 3, height_px);
      moment.look = look;
      moment.needle = demo.frame.needle;
      renderer.Ask(moment, false);
      std::cout << ' ' << moment.camera.width_px << " x " << height_px << ' '
                << renderer.statistics().cpu_ms << " ms";
    }
    std::cout << '\n';
  }
}

double Seconds(clockid_t clock) {
  timespec now{};
  clock_gettime(clock, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

/// What each view costs alone.
void MeasureViews(const Demo& demo) {
  window::Window window(demo.patient, window::WindowSettings());
  testing_support::WindowInput input;
  constexpr int kFrames = 60;
  for (const char* what : {"all", "video", "ultrasound", "3D", "CT", "fluoroscopy"}) {
    Settle(window, demo.frame);
    const double all = Seconds(CLOCK_PROCESS_CPUTIME_ID);
    for (int i = 0; i < kFrames; ++i) window.Show(demo.frame);
    std::cout << what << ": " << 1e3 * (Seconds(CLOCK_PROCESS_CPUTIME_ID) - all) / kFrames
              << " ms of all threads\n";
    input.Key("v");
  }
}

/// Everything moves: needle, probe, camera, images.
void MeasureRate(const Demo& demo) {
  window::Window window(demo.patient, window::WindowSettings());
  testing_support::WindowInput input;
  window::DisplayFrame frame = demo.frame;
  constexpr int kFrames = 150;
  Settle(window, frame);
  for (const char* what : {"still", "tools move", "camera moves too"}) {
    const double wall = Seconds(CLOCK_MONOTONIC);
    const double thread = Seconds(CLOCK_THREAD_CPUTIME_ID);
    const double all = Seconds(CLOCK_PROCESS_CPUTIME_ID);
    const long overlays = window.num_overlays();
    for (int i = 0; i < kFrames; ++i) {
      const double phase = 0.05 * i;
      if (std::string(what) != "still") {
        frame.needle->tip_in_ct_mm[0] = demo.frame.needle->tip_in_ct_mm[0] + 5.0 * std::sin(phase);
        frame.ct_from_probe = *demo.frame.ct_from_probe *
                              Eigen::AngleAxisd(0.1 * std::sin(phase), Eigen::Vector3d::UnitY());
        std::ranges::rotate(frame.ultrasound.image.pixels,
                            frame.ultrasound.image.pixels.begin() + 512);
      }
      if (std::string(what) == "camera moves too") {
        frame.video->camera.camera_from_ct =
            demo.frame.video->camera.camera_from_ct *
            Eigen::AngleAxisd(0.02 * std::sin(phase), Eigen::Vector3d::UnitZ());
      }
      window.Show(frame);
    }
    const auto per_frame = [&](double since, clockid_t clock) {
      return 1e3 * (Seconds(clock) - since) / kFrames;
    };
    std::cout << what << ": " << 1e3 / per_frame(wall, CLOCK_MONOTONIC) << " images/s, "
              << per_frame(thread, CLOCK_THREAD_CPUTIME_ID) << " ms of the window's thread, "
              << per_frame(all, CLOCK_PROCESS_CPUTIME_ID) << " ms of all threads, "
              << window.num_overlays() - overlays << " overlays\n";
  }
}

}  // namespace
}  // namespace acus

int main(int argc, char** argv) {
  if (argc != 3) {
    std::cerr << "usage: window_figures PATIENT OUT_FOLDER|--rate\n";
    return 2;
  }
  try {
    acus::Demo demo = acus::Load(argv[1]);
    if (std::string(argv[2]) == "--rate") {
      acus::MeasureVolume(demo);
      acus::MeasureViews(demo);
      acus::MeasureRate(demo);
    } else {
      acus::MakeFigures(demo, argv[2]);
    }
  } catch (const std::exception& error) {
    std::cerr << "window_figures: " << error.what() << '\n';
    return 1;
  }
  return 0;
}
