#include "acus/window/volume_view.h"

#include <filesystem>
#include <gmock/gmock.h>
#include <set>
#include <sys/resource.h>

#include "acus/base/core/cpu_time.h"
#include "acus/base/core/error.h"
#include "support/window_scene.h"

namespace acus::window {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;
using volume_rendering::PatientInView;
using volume_rendering::PatientView;

const Eigen::Vector3d kBallMm{10.0, -5.0, 12.0};
constexpr Rectangle kPlace{.left = 0, .top = 0, .width = 180, .height = 140};

std::vector<VolumeLook> BallLooks() {
  PatientInView patient;
  patient.ct = testing_support::BallCt(kBallMm, 22.0);
  patient.layers = {{"skin", 1.0}};
  PatientInView nothing = patient;
  nothing.layers.clear();
  return {{"skin", patient}, {"nothing", nothing}};
}
Orbit BallOrbit() {
  return Orbit({kBallMm.array() - 40.0, kBallMm.array() + 40.0});
}
DisplayFrame FrameWithNeedle(double x_mm) {
  DisplayFrame frame;
  frame.needle.emplace();
  frame.needle->tip_in_ct_mm = kBallMm + Eigen::Vector3d(x_mm, -30.0, 0.0);
  frame.needle->axis_in_ct = Eigen::Vector3d::UnitY();
  frame.needle->length_mm = 60.0;
  frame.needle->radius_mm = 1.0;
  return frame;
}
VolumeMoment MomentAt(const Orbit& orbit, int width_px, int height_px) {
  VolumeMoment moment;
  moment.camera = orbit.CameraFor(width_px, height_px);
  return moment;
}

TEST(VolumeView, IsHalfAsFineWhileThingsMoveAndWholeWhenTheyAreStill) {
  const auto looks = BallLooks();
  VolumeView view(looks, {.in_background = false});
  const Orbit orbit = BallOrbit();
  for (int i = 0; i < 10; ++i) {
    view.Update(FrameWithNeedle(i), kPlace, orbit, {});
    EXPECT_EQ(view.image().width, kPlace.width / 2) << i;
    EXPECT_FALSE(view.readout()->whole);
  }
  int moments = 0;
  while (view.image().width < kPlace.width && ++moments < 20) {
    view.Update(FrameWithNeedle(9.0), kPlace, orbit, {});
  }
  EXPECT_EQ(moments, VolumeViewSettings().still_moments);
  EXPECT_EQ(view.image().height, kPlace.height);
  EXPECT_TRUE(view.readout()->whole);
  Orbit turned = orbit;
  turned.Turn(20.0, 0.0);
  view.Update(FrameWithNeedle(9.0), kPlace, turned, {});
  EXPECT_EQ(view.image().width, kPlace.width / 2);
  view.Update({}, {}, orbit, {});
  EXPECT_FALSE(view.readout().has_value()) << "not shown";
}

TEST(VolumeView, StillMomentsAreNotRenderedAgain) {
  const auto looks = BallLooks();
  VolumeView view(looks, {.in_background = false});
  const Orbit orbit = BallOrbit();
  for (int i = 0; i < 20; ++i) view.Update(FrameWithNeedle(0.0), kPlace, orbit, {});
  const double before_s = ThreadCpuSeconds();
  for (int i = 0; i < 1000; ++i) view.Update(FrameWithNeedle(0.0), kPlace, orbit, {});
  EXPECT_LT(ThreadCpuSeconds() - before_s, 0.1);
}

TEST(VolumeView, ALookThatCannotBeShownIsSaidAndTheNextOneIsThere) {
  const auto looks = BallLooks();
  VolumeView view(looks, {.in_background = false});
  const Orbit orbit = BallOrbit();
  VolumeChoice choice;
  choice.look = 1;
  view.Update({}, kPlace, orbit, choice);
  EXPECT_THAT(view.TitleDetail(choice), HasSubstr("nothing to show"));
  choice.look = 2;
  view.Update({}, kPlace, orbit, choice);
  EXPECT_EQ(view.TitleDetail(choice), "skin");
  EXPECT_FALSE(view.image().rgb.empty());
  choice.opacity = 0.4;
  choice.cut = VolumeCut::kAxial;
  view.Update({}, kPlace, orbit, choice);
  EXPECT_EQ(view.TitleDetail(choice), "skin 40 %, axial cut");
}

TEST(VolumeView, CutsTakeAwayTheSideOfTheEyeAndStayWhereTheyAre) {
  const Eigen::AlignedBox3d box(Eigen::Vector3d(-10, 0, 5), Eigen::Vector3d(30, 40, 25));
  EXPECT_THAT(CutsOf(VolumeCut::kNone, 3.0, box, Eigen::Vector3d::UnitX()), IsEmpty());
  const Eigen::Vector3d eye = Eigen::Vector3d(0.3, -0.8, 0.4).normalized();
  for (const auto& [cut, normal] : {std::pair{VolumeCut::kSagittal, Eigen::Vector3d::UnitX()},
                                    {VolumeCut::kCoronal, Eigen::Vector3d::UnitY()},
                                    {VolumeCut::kAxial, Eigen::Vector3d::UnitZ()}}) {
    const auto front = CutsOf(cut, 5.0, box, eye);
    const auto back = CutsOf(cut, 5.0, box, -eye);
    ASSERT_EQ(front.size(), 1U);
    EXPECT_GT(front[0].signedDistance(box.center() + 500.0 * eye), 0.0);
    EXPECT_NEAR(front[0].signedDistance(box.center() + 5.0 * normal), 0.0, 1e-9);
    EXPECT_LT((front[0].coeffs() + back[0].coeffs()).norm(), 1e-9) << "the same plane";
  }
  const auto facing = CutsOf(VolumeCut::kFacing, 7.0, box, eye);
  EXPECT_NEAR(facing[0].signedDistance(box.center()), 7.0, 1e-9) << "deeper";
}

TEST(VolumeRenderer, AGraphicsCardGivesTheImageOfTheProcessor) {
  const auto looks = BallLooks();
  VolumeRenderer processor(looks, false);
  VolumeRenderer card(looks, false, VolumeRays::kGraphics);
  image::ColourImage expected, image;
  processor.Ask(MomentAt(BallOrbit(), 120, 90), false);
  card.Ask(MomentAt(BallOrbit(), 120, 90), false);
  ASSERT_TRUE(processor.Take(expected));
  ASSERT_TRUE(card.Take(image));
  EXPECT_GT(testing_support::PsnrDb(image.rgb, expected.rgb), 40.0);
  EXPECT_NE(card.statistics().rays_on, "");
  EXPECT_EQ(card.statistics().card_trouble, "");
  EXPECT_EQ(processor.statistics().rays_on, "");
}

TEST(VolumeRenderer, InTheBackgroundItGivesTheSameBits) {
  const auto looks = BallLooks();
  const Orbit orbit = BallOrbit();
  const VolumeMoment moment = MomentAt(orbit, 157, 131);
  VolumeRenderer renderer(looks, /*in_background=*/true);
  renderer.Ask(moment, /*may_stop=*/true);
  renderer.Wait();
  image::ColourImage in_background;
  ASSERT_TRUE(renderer.Take(in_background));
  EXPECT_FALSE(renderer.Take(in_background)) << "once";
  VolumeRenderer here(looks, /*in_background=*/false);
  here.Ask(moment, false);
  image::ColourImage at_once;
  ASSERT_TRUE(here.Take(at_once));
  EXPECT_EQ(in_background.rgb, at_once.rgb);
}

TEST(VolumeRenderer, TheNewestMomentIsRenderedAndOthersAreCounted) {
  const auto looks = BallLooks();
  Orbit orbit = BallOrbit();
  VolumeRenderer renderer(looks, true);
  const double before_s = ThreadCpuSeconds();
  for (int i = 0; i < 50; ++i) {
    orbit.Turn(3.0, 1.0);
    renderer.Ask(MomentAt(orbit, 400, 300), false);
  }
  EXPECT_LT(ThreadCpuSeconds() - before_s, 0.05) << "who asks does not wait";
  renderer.Wait();
  image::ColourImage newest;
  ASSERT_TRUE(renderer.Take(newest));
  const VolumeStatistics counts = renderer.statistics();
  EXPECT_EQ(counts.images + counts.dropped, 50);
  EXPECT_GT(counts.dropped, 0);
  VolumeRenderer here(looks, false);
  here.Ask(MomentAt(orbit, 400, 300), false);
  image::ColourImage truth;
  here.Take(truth);
  EXPECT_EQ(newest.rgb, truth.rgb);
}

TEST(VolumeRenderer, AWholeImageIsStoppedWhenTheEyeTurns) {
  const auto looks = BallLooks();
  Orbit orbit = BallOrbit();
  VolumeRenderer renderer(looks, true);
  renderer.Ask(MomentAt(orbit, 2400, 2400), /*may_stop=*/true);
  for (int i = 0; i < 500 && renderer.statistics().images == 0; ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
    if (i == 20) {
      orbit.Turn(30.0, 0.0);
      renderer.Ask(MomentAt(orbit, 40, 30), false);
    }
  }
  renderer.Wait();
  image::ColourImage image;
  ASSERT_TRUE(renderer.Take(image));
  EXPECT_EQ(image.width, 40);
  EXPECT_EQ(renderer.statistics().images, 1);
}

std::set<id_t> ThreadsOfThisProcess() {
  std::set<id_t> threads;
  for (const auto& task : std::filesystem::directory_iterator("/proc/self/task")) {
    threads.insert(static_cast<id_t>(std::stoul(task.path().filename().string())));
  }
  return threads;
}

TEST(VolumeRenderer, ItsThreadHasTheLowestPriority) {
  const std::set<id_t> before = ThreadsOfThisProcess();
  const auto looks = BallLooks();
  VolumeRenderer renderer(looks, true);
  renderer.Ask(MomentAt(BallOrbit(), 64, 48), false);
  renderer.Wait();
  const int here = getpriority(PRIO_PROCESS, 0);
  int nicest = here;
  for (const id_t thread : ThreadsOfThisProcess()) {
    if (!before.contains(thread)) nicest = std::max(nicest, getpriority(PRIO_PROCESS, thread));
  }
  EXPECT_EQ(nicest, std::min(19, here + 5));
}

TEST_F(WindowTest, TheVolumeViewShowsABallWhereItIs) {
  PatientOnDisplay patient;
  patient.in_volume_view = BallLooks();
  WindowSettings settings = Settings();
  settings.views = {ViewKind::kVolume};
  settings.volume_in_background = false;
  Window window(patient, settings);
  for (int i = 0; i < 10; ++i) window.Show({});
  ASSERT_TRUE(window.volume().has_value());
  EXPECT_TRUE(window.volume()->whole);
  const Layout layout = window.layout();
  ASSERT_EQ(layout.views.size(), 1U);
  const Layout::View* view = layout.Find(ViewKind::kVolume);
  ASSERT_NE(view, nullptr);
  // The eye turns about the CT, where nothing else says where the patient is.
  const volume::Geometry& grid = patient.in_volume_view[0].patient.ct->geometry;
  Eigen::AlignedBox3d box;
  for (int n = 0; n < 8; ++n) {
    const Eigen::Array3i corner(n & 1, (n >> 1) & 1, n >> 2);
    box.extend(grid.ct_from_index() * (corner * (grid.size - 1)).cast<double>().matrix());
  }
  const Rectangle place = ImageRoom(ViewKind::kVolume, view->place, SizesFor(800));
  const auto camera = Orbit(box).CameraFor(place.width, place.height);
  const Eigen::Vector2d expected = camera.ProjectPx(kBallMm) + Eigen::Vector2d(0.5, 0.5) +
                                   Eigen::Vector2d(place.left, place.top);
  const Shot shot{window.Screenshot()};
  const Eigen::Vector2d seen = shot.MiddleNear(expected, 140, 75);
  EXPECT_LT((seen - expected).norm(), 3.0) << seen.transpose() << "; " << expected.transpose();
}

}  // namespace
}  // namespace acus::window
