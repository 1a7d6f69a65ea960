#include "acus/rig/camera/camera_tracker.h"

#include <chrono>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <thread>

#include "acus/base/core/atomic_file.h"
#include "acus/base/core/error.h"
#include "acus/data/image/film.h"
#include "acus/rig/tracking/pose_server.h"
#include "support/facet_views.h"
#include "support/temporary_folder.h"

namespace acus::camera {
namespace {

using namespace testing_support;

/// Waits for something that a thread does; the machine may be busy.
bool Eventually(const std::function<bool()>& done) {
  for (int i = 0; i < 3000; ++i) {
    if (done()) return true;
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  return false;
}

class Tracker : public testing::Test {
 protected:
  CameraModel camera_ = ReadCamera(ConfigPath("cameras/micron_tracker_2010.json"));
  FacetSet set_ = ReadFacets(ConfigPath("facets/training.json"));
  TemporaryFolder folder_;
  Eigen::Isometry3d mannequin_ = FacingPose({0, -140, 900}, 20, 0, 0);
  Eigen::Isometry3d probe_ = FacingPose({0, -60, 600}, 15, 20, 10) *
                             Eigen::AngleAxisd(std::numbers::pi, Eigen::Vector3d::UnitX()) *
                             Eigen::Translation3d(0, 110, 0);

  Image Take(bool with_probe, std::uint64_t index) {
    MannequinCamera maker(camera_, set_, {}, {.colour = false});
    std::vector<ObjectInView> shown = {{"Reference", mannequin_}};
    if (with_probe) shown.push_back({"Probe", probe_});
    Image image;
    maker.Render(shown, index, image);
    return image;
  }
  CameraTrackerOptions Options(const std::string& place) {
    CameraTrackerOptions options;
    options.place = place;
    options.tools = {{.tool = "probe", .object = "Probe"}};
    return options;
  }
  void ExpectProbeIsRight(const tracking::TrackedPose& pose) {
    EXPECT_TRUE(pose.valid);
    const PoseError error = ErrorOf(pose.reference_from_tool, mannequin_.inverse() * probe_);
    EXPECT_LT(error.position_mm, 0.5);
    EXPECT_LT(error.angle_deg, 0.5);
  }
};

TEST_F(Tracker, GivesAToolInTheMannequinsFrame) {
  WriteImage(folder_ / "0.png", Take(true, 0));
  WriteImage(folder_ / "1.png", Take(false, 1));
  WriteTextFile(folder_ / "2.png", "no image");
  CameraTrackerOptions options = Options("folder:" + folder_.path().string());
  options.journal_capacity = 16;
  CameraTracker tracker(camera_, set_, options);
  EXPECT_EQ(tracker.board().Latest(0).number, 0U);
  tracker.Start();
  ASSERT_TRUE(Eventually([&] { return tracker.status().counts.fell_silent == 1; }));
  tracker.Stop();
  std::array<tracking::ToolReading, 16> readings;
  ASSERT_EQ(tracker.board().TakeReadings(readings), 3U);
  ExpectProbeIsRight(readings[0].pose);
  EXPECT_FALSE(readings[1].pose.valid);  // Not in the image.
  EXPECT_FALSE(readings[2].pose.valid);  // No image came any more.
  const auto status = tracker.status();
  EXPECT_EQ(status.state, tracking::SourceState::kStopped);
  EXPECT_EQ(status.counts.messages, 2U);
  EXPECT_EQ(status.counts.not_seen, 1U);
  EXPECT_EQ(status.counts.readings, 3U);
  EXPECT_NE(status.last_error.find("2.png"), std::string::npos) << status.last_error;
  const auto view = tracker.Latest();
  ASSERT_NE(view, nullptr);
  EXPECT_EQ(view->number, 2U);
  ASSERT_TRUE(view->camera_from_reference);
  EXPECT_LT(ErrorOf(*view->camera_from_reference, mannequin_).position_mm, 0.5);
}

class TrackerOfAPair : public Tracker {
 protected:
  StereoPair pair_ = ReadStereo(ConfigPath("cameras/micron_pair_2010.json"));

  /// Ten pairs of images. @param beside  Where the right camera is, seen from the left one.
  CameraTrackerOptions Recorded(const Eigen::Isometry3d& right_from_left, int count) {
    MannequinCamera left(pair_.left, set_, {}, {.colour = false});
    MannequinCamera right(pair_.right, set_, {}, {.colour = false});
    for (const char* name : {"left", "right"}) std::filesystem::create_directory(folder_ / name);
    Image image;
    for (int i = 0; i < count; ++i) {
      const std::string file = std::to_string(100 + i) + ".png";
      const auto number = static_cast<std::uint64_t>(i);
      const ObjectInView in_left[] = {{"Reference", mannequin_}, {"Probe", probe_}};
      left.Render(in_left, number, image);
      WriteImage(folder_ / "left" / file, image);
      const ObjectInView in_right[] = {{"Reference", right_from_left * mannequin_},
                                       {"Probe", right_from_left * probe_}};
      right.Render(in_right, 1000 + number, image);
      WriteImage(folder_ / "right" / file, image);
    }
    CameraTrackerOptions options = Options("folder:" + (folder_ / "left").string());
    options.second =
        SecondCameraOptions{.place = "folder:" + (folder_ / "right").string(), .pair = pair_};
    options.journal_capacity = 64;
    return options;
  }
};

TEST_F(TrackerOfAPair, BothCamerasAgree) {
  CameraTracker tracker(pair_.left, set_, Recorded(pair_.right_from_left, 2));
  tracker.Start();
  ASSERT_TRUE(Eventually([&] { return tracker.status().counts.messages == 2; }));
  tracker.Stop();
  ExpectProbeIsRight(tracker.board().Latest(0));
  const auto view = tracker.Latest();
  ASSERT_NE(view, nullptr);
  EXPECT_EQ(view->by_pair, 2);
  EXPECT_EQ(tracker.status().last_error.find("camera"), std::string::npos)
      << tracker.status().last_error;
}

TEST_F(TrackerOfAPair, APairThatNeverAgreesIsRefused) {
  const Eigen::Isometry3d elsewhere =
      Eigen::AngleAxisd(0.02, Eigen::Vector3d::UnitY()) * pair_.right_from_left;
  CameraTracker tracker(pair_.left, set_, Recorded(elsewhere, 10));
  tracker.Start();
  ASSERT_TRUE(Eventually([&] { return tracker.status().counts.messages == 10; }));
  tracker.Stop();
  EXPECT_FALSE(tracker.board().Latest(0).valid);
  EXPECT_NE(tracker.status().last_error.find("put the facets in different places"),
            std::string::npos)
      << tracker.status().last_error;
}

TEST_F(TrackerOfAPair, WithoutItsSecondCameraOneTracks) {
  CameraTrackerOptions options = Recorded(pair_.right_from_left, 2);
  options.second->place = "device:" + (folder_ / "video77").string();
  CameraTracker tracker(pair_.left, set_, options);
  tracker.Start();
  ASSERT_TRUE(Eventually([&] { return tracker.status().counts.messages == 2; }));
  tracker.Stop();
  std::array<tracking::ToolReading, 16> readings;
  ASSERT_GE(tracker.board().TakeReadings(readings), 2U);
  ExpectProbeIsRight(readings[1].pose);
  EXPECT_EQ(tracker.Latest()->by_pair, 0);
}

TEST_F(TrackerOfAPair, ImagesComeOverTheNetwork) {
  const CameraTrackerOptions recorded = Recorded(pair_.right_from_left, 1);
  const auto sent = [&](const char* name) {
    const Image image = ReadImage(folder_ / name / "100.png");
    return tracking::Image{.width = image.width_px,
                           .height = image.height_px,
                           .channels = image.channels,
                           .pixels = image.pixels};
  };
  const tracking::Image left = sent("left"), right = sent("right");
  tracking::PoseServer server({.host = "127.0.0.1", .port = 0});
  server.Start();
  const std::string place = "igtl:127.0.0.1:" + std::to_string(server.port());
  CameraTrackerOptions options = recorded;
  options.place = place + "/Video";
  options.second->place = place + "/VideoRight";
  options.second->apart_ms = 10000;  // The machine may be busy.
  CameraTracker tracker(pair_.left, set_, options);
  tracker.Start();
  std::int64_t number = 0;
  EXPECT_TRUE(Eventually([&] {
    server.SendImage("Video", left, ++number);
    server.SendImage("VideoRight", right, number);
    const auto view = tracker.Latest();
    return view != nullptr && view->by_pair == 2;
  }));
}

TEST_F(TrackerOfAPair, AFileOfAnotherPairIsRefused) {
  CameraTrackerOptions options = Recorded(pair_.right_from_left, 1);
  CameraParameters other = pair_.left.parameters();
  other.focal_px *= 1.05;
  EXPECT_THROW(CameraTracker(CameraModel(other), set_, options), InputError);
}

TEST_F(Tracker, ACameraThatIsNotThereIsSaidAndWaitedFor) {
  CameraTracker tracker(camera_, set_, Options("device:" + (folder_ / "video77").string()));
  tracker.Start();
  ASSERT_TRUE(Eventually([&] { return !tracker.status().last_error.empty(); }));
  EXPECT_EQ(tracker.status().state, tracking::SourceState::kConnecting);
  EXPECT_NE(tracker.status().last_error.find("there is no camera"), std::string::npos);
  // And one that is there but is no camera.
  WriteTextFile(folder_ / "video77", "no camera");
  ASSERT_TRUE(Eventually([&] {
    return tracker.status().last_error.find("cannot be opened") != std::string::npos;
  })) << tracker.status().last_error;
}

TEST_F(Tracker, ImagesComeBackAfterThePlugWasPulled) {
  const auto pipe = folder_ / "camera.pipe";
  ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
  const Image image = Take(true, 0);  // First: on a slow machine it takes longer than a silence.
  CameraTracker tracker(camera_, set_, Options("pipe:" + pipe.string()));
  tracker.Start();
  const auto send = [&](std::size_t bytes_of_second) {
    std::FILE* file = std::fopen(pipe.c_str(), "wb");
    ASSERT_NE(file, nullptr);
    for (const std::size_t bytes : {image.pixels.size(), bytes_of_second}) {
      std::fprintf(file, "P5\n%d %d\n255\n", image.width_px, image.height_px);
      std::fwrite(image.pixels.data(), 1, bytes, file);
    }
    std::fclose(file);
  };
  send(1000);  // The second image is torn off.
  ASSERT_TRUE(Eventually([&] { return tracker.status().counts.fell_silent == 1; }));
  EXPECT_EQ(tracker.status().counts.messages, 1U);
  EXPECT_FALSE(tracker.board().Latest(0).valid);
  EXPECT_EQ(tracker.status().state, tracking::SourceState::kConnecting);
  send(image.pixels.size());
  ASSERT_TRUE(Eventually([&] { return tracker.status().counts.messages == 3; }));
  EXPECT_EQ(tracker.status().counts.connects, 2U);
}

TEST_F(Tracker, ImagesComeOverTheNetwork) {
  tracking::PoseServer server({.host = "127.0.0.1", .port = 0});
  server.Start();
  CameraTracker tracker(camera_, set_,
                        Options("igtl:127.0.0.1:" + std::to_string(server.port()) + "/Camera"));
  tracker.Start();
  const Image image = Take(true, 0);
  tracking::Image sent;
  sent.width = image.width_px;
  sent.height = image.height_px;
  sent.channels = image.channels;
  sent.pixels = image.pixels;
  ASSERT_TRUE(Eventually([&] {
    server.SendImage("Camera", sent, 1);
    return tracker.status().counts.messages > 0;
  }));
  tracker.Stop();
  EXPECT_EQ(tracker.Latest()->image.pixels, image.pixels);
  EXPECT_LT(ErrorOf(*tracker.Latest()->camera_from_reference, mannequin_).position_mm, 0.5);
}

TEST_F(Tracker, ImagesOfAnotherSizeAreRefusedInWords) {
  Image small = Take(true, 0);
  small.Resize(320, 240, 1);
  WriteImage(folder_ / "0.png", small);
  CameraTracker tracker(camera_, set_, Options("folder-loop:" + folder_.path().string()));
  tracker.Start();
  ASSERT_TRUE(Eventually([&] { return tracker.status().counts.bad_messages > 2; }));
  EXPECT_NE(tracker.status().last_error.find("320 x 240"), std::string::npos);
  EXPECT_EQ(tracker.Latest(), nullptr);
}

TEST_F(Tracker, RefusesWhatCanNeverWork) {
  const auto refused = [&](const CameraTrackerOptions& options) {
    EXPECT_THROW(CameraTracker(camera_, set_, options), InputError) << options.place;
  };
  refused(Options("0"));
  refused(Options("device:"));
  refused(Options("webcam:0"));
  refused(Options("video:" + (folder_ / "none.mp4").string()));
  refused(Options("film:" + (folder_ / "none.mp4").string()));  // The older word.
  refused(Options("folder:" + folder_.path().string()));
  refused(Options("igtl:localhost"));
  refused(Options("igtl:localhost:0"));
  refused(Options("igtl:localhost:99999"));
  CameraTrackerOptions options = Options("device:0");
  options.tools[0].object = "Scalpel";
  refused(options);
  options = Options("device:0");
  options.tools.push_back(options.tools[0]);
  refused(options);
}

TEST(FrameSource, AVideoGivesItsImagesAndSaysThatItIsOver) {
  const TemporaryFolder folder;
  const std::string file = (folder / "film.mp4").string();
  image::FilmWriter film(file, 64, 48, {});
  image::GrayImage grey;
  grey.Resize(64, 48);
  for (int n = 0; n < 3; ++n) film.Add(grey);
  film.Finish();
  const auto source = OpenFrameSource("video:" + file);
  EXPECT_EQ(source->status().text, "video " + file);
  EXPECT_TRUE(source->status().connected);
  Image out;
  while (!source->finished()) {
    if (!source->Next(out, 1000)) continue;
    EXPECT_EQ(out.width_px, 64);
  }
  EXPECT_EQ(source->status().received, 3U);
  EXPECT_EQ(source->status().text, "the video " + file + " is over");
}

TEST(FrameSource, AFileOfImagesSurvivesInvalidData) {
  const TemporaryFolder folder;
  const std::string image = "P5 4 2 255\n" + std::string(8, 'a');
  const std::string colour = "P6\n1 1\n255\n" + std::string(3, 'P');
  WriteTextFile(folder / "f", "xxPP5 0 3 255\n" + image + "P5 99999999 1 255\n" + image + colour +
                                  "P7" + image + "P5 4 2 255\nab");
  const auto source = OpenFrameSource("pipe:" + (folder / "f").string());
  Image out;
  int grey = 0;
  int coloured = 0;
  while (!source->finished()) {
    if (!source->Next(out, 10)) continue;
    (out.channels == 1 ? grey : coloured) += 1;
    EXPECT_EQ(out.pixels,
              std::vector<std::uint8_t>(out.channels == 1 ? 8 : 3, out.channels == 1 ? 'a' : 'P'));
  }
  EXPECT_EQ(grey, 3);
  EXPECT_EQ(coloured, 1);
  EXPECT_EQ(source->status().bad, 4U);  // Three stretches of rubbish, one torn image.
}

}  // namespace
}  // namespace acus::camera
