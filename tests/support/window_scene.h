// A window of a patient made of balls, in a virtual X server, and what is seen in it.
#pragma once

#include <algorithm>
#include <chrono>
#include <cmath>
#include <gtest/gtest.h>
#include <limits>
#include <memory>
#include <thread>

#include "acus/window/marks.h"
#include "acus/window/window.h"
#include "support/view_scenes.h"
#include "support/virtual_display.h"

namespace acus::window {

inline constexpr const char* kTitle = "Acus window test";

/// A screenshot with places in it.
struct Shot {
  image::ColourImage image;

  Eigen::Array3i At(int column, int row) const {
    const auto at = 3 * static_cast<std::size_t>(row * image.width + column);
    return {image.rgb[at], image.rgb[at + 1], image.rgb[at + 2]};
  }
  /// Number of pixels for which test(r, g, b).
  template <typename Test>
  int Count(const Rectangle& place, const Test& test) const {
    int count = 0;
    for (int row = place.top; row < place.top + place.height; ++row) {
      for (int column = place.left; column < place.left + place.width; ++column) {
        const Eigen::Array3i c = At(column, row);
        count += test(c[0], c[1], c[2]) ? 1 : 0;
      }
    }
    return count;
  }
  /// Middle of what is brighter than a level, within some pixels of a place. How bright does not
  /// count: light falls on a ball from one side.
  Eigen::Vector2d MiddleNear(const Eigen::Vector2d& place, int reach, int level) const {
    Eigen::Vector2d sum = Eigen::Vector2d::Zero();
    double weights = 0.0;
    const Eigen::Vector2i at = place.array().round().cast<int>();
    for (int row = at[1] - reach; row <= at[1] + reach; ++row) {
      for (int column = at[0] - reach; column <= at[0] + reach; ++column) {
        if (column < 0 || row < 0 || column >= image.width || row >= image.height) continue;
        const double weight = At(column, row).maxCoeff() > level ? 1.0 : 0.0;
        sum += weight * Eigen::Vector2d(column + 0.5, row + 0.5);
        weights += weight;
      }
    }
    return weights > 0.0 ? Eigen::Vector2d(sum / weights)
                         : Eigen::Vector2d::Constant(std::numeric_limits<double>::quiet_NaN());
  }
};

inline bool IsYellow(int r, int g, int b) {
  return r > 200 && g > 160 && b < 140 && r - b > 90;
}
inline bool IsCyan(int r, int g, int b) {
  return g > 160 && b > 170 && r < 150;
}
inline bool IsRed(int r, int g, int b) {
  return r > 190 && g < 130 && b < 120;
}

inline image::GrayImage Grey(int width, int height, int level) {
  image::GrayImage image;
  image.Resize(width, height);
  std::ranges::fill(image.pixels, static_cast<std::uint8_t>(level));
  return image;
}

inline acoustics::Probe Linear() {
  acoustics::Probe probe = acoustics::DefaultProbe();
  probe.name = "test probe";
  probe.kind = acoustics::ProbeKind::kLinear;
  probe.frequency_mhz = 7.5;
  probe.width_mm = 40.0;
  probe.depth_mm = 50.0;
  probe.image_width_px = probe.image_height_px = 200;
  return probe;
}

class WindowTest : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    display_ = std::make_unique<testing_support::VirtualDisplay>(1280, 800);
  }
  static void TearDownTestSuite() { display_.reset(); }

  /// A ball of a patient, a probe over it, a needle towards the target.
  static PatientOnDisplay Patient() {
    PatientOnDisplay patient;
    const auto add = [&](const char* name, double radius, Eigen::Array3f colour, double opacity) {
      patient.in_teaching_view.push_back(
          {.name = name,
           .surface = testing_support::BallSurface({0, 0, 0}, radius, 24),
           .colour = colour,
           .opacity = opacity});
    };
    add("skin", 100.0, {0.8F, 0.6F, 0.5F}, 0.3);
    add("bone", 40.0, {0.9F, 0.9F, 0.8F}, 1.0);
    return patient;
  }
  static DisplayFrame Frame() {
    DisplayFrame frame;
    const auto probe = std::make_shared<acoustics::Probe>(Linear());
    const auto image = acoustics::ImageOf(*probe);
    frame.ultrasound.image = Grey(image.width_px, image.height_px, 60);
    frame.ultrasound.probe = probe;
    frame.ct_slice = Grey(image.width_px, image.height_px, 120);
    frame.effects = {{"fluoroscopy", "Fluoroscopy", {Grey(128, 128, 180), {}}}};
    frame.ct_from_probe = Eigen::Isometry3d(Eigen::Translation3d(0.0, -100.0, 0.0));
    frame.target_in_ct_mm = Eigen::Vector3d(5.0, -75.0, 0.0);
    frame.needle.emplace();
    frame.needle->tip_in_ct_mm = {-8.0, -85.0, 0.0};
    frame.needle->axis_in_ct = Eigen::Vector3d(13.0, 10.0, 0.0).normalized();
    frame.needle->length_mm = 120.0;
    frame.needle->radius_mm = 0.5;
    frame.video = Video();
    frame.status = {{.severity = Severity::kGood, .text = "All tools are seen."}};
    return frame;
  }
  static VideoImage Video() {
    VideoImage video;
    video.image.Resize(640, 480);
    std::ranges::fill(video.image.rgb, std::uint8_t{0});
    video.camera = volume_rendering::LookAt({.eye_in_ct_mm = {60.0, -480.0, 90.0},
                                             .focus_in_ct_mm = {0.0, 0.0, 0.0},
                                             .up_in_ct = {0.0, 0.0, 1.0},
                                             .view_angle_deg = 30.0},
                                            {.width_px = 640, .height_px = 480});
    video.camera.focal_px[1] *= 1.03;  // As of a real camera: not square, not in the middle.
    video.camera.centre_px += Eigen::Vector2d(17.0, -11.0);
    video.pose_valid = true;
    return video;
  }
  static WindowSettings Settings() {
    WindowSettings settings;
    settings.title = kTitle;
    settings.overlay_in_background = false;
    settings.overlay_scale = 1.0;
    return settings;
  }
  static Shot ShotOf(Window& window, const DisplayFrame& frame) {
    window.Show(frame);
    window.Show(frame);
    return {window.Screenshot()};
  }
  /// Sends what `act` does and shows images until `done`, some seconds at most.
  template <typename Done>
  static bool ShowUntil(Window& window, const DisplayFrame& frame, const Done& done) {
    for (int i = 0; i < 200; ++i) {
      window.Show(frame);
      if (done()) return true;
      std::this_thread::sleep_for(std::chrono::milliseconds(20));
    }
    return false;
  }
  static Rectangle VideoPlace(const Window& window) {
    const Layout layout = window.layout();
    const TextSizes sizes = SizesFor(layout.status.top + layout.status.height);
    return Fit(ImageRoom(ViewKind::kVideo, layout.Find(ViewKind::kVideo)->place, sizes), 640, 480);
  }
  /// From a pixel of the video to one of the window; centres of the window's are at halves.
  static Eigen::Vector2d OnScreen(const Rectangle& place, const Eigen::Vector2d& pixel) {
    return {place.left + (pixel[0] + 0.5) * place.width / 640.0,
            place.top + (pixel[1] + 0.5) * place.height / 480.0};
  }

  static inline std::unique_ptr<testing_support::VirtualDisplay> display_;
};

}  // namespace acus::window
