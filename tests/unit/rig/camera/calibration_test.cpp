#include "acus/rig/camera/calibration.h"

#include <gmock/gmock.h>

#include "acus/base/core/atomic_file.h"
#include "acus/base/core/error.h"
#include "acus/base/core/text_table.h"
#include "acus/rig/camera/stereo.h"
#include "support/facet_views.h"
#include "support/temporary_folder.h"

namespace acus::camera {
namespace {

using namespace testing_support;
using testing::HasSubstr;
using testing::ThrowsMessage;

class CalibrationTest : public testing::Test {
 protected:
  CameraModel truth_ = ReadCamera(ConfigPath("cameras/webcam_720p.json"));
  CalibrationBoard board_ = ReadBoard(ConfigPath("cameras/board_a4.json"));
  TemporaryFolder folder_;

  /// Board in all parts of the image, at angles up to `tilt_deg`.
  void TakeImages(int count, double tilt_deg, double reach = 1.0, int samples = 2) {
    for (int i = 0; i < count; ++i) {
      RandomStream random(21, "board", static_cast<std::uint64_t>(i));
      const double z = random.Uniform(350, 550);
      const Eigen::Vector3d at(reach * (0.4 * (i % 4) - 0.6) * 0.55 * z,
                               reach * (i / 4 % 3 - 1) * 0.2 * z, z);
      Take(i,
           FacingPose(at, random.Uniform(0.3 * tilt_deg, tilt_deg), random.Uniform(0, 360),
                      random.Uniform(-180, 180)),
           {.samples = samples});
    }
  }
  void Take(int number, const Eigen::Isometry3d& camera_from_board, ImageMaking making = {}) {
    making.colour = false;
    Image image;
    RenderBoard(truth_, board_, camera_from_board, making, static_cast<std::uint64_t>(number),
                image);
    WriteImage(folder_ / (std::to_string(100 + number) + ".png"), image);
  }
  Calibration Calibrate() {
    return CalibrateCamera(ImageFiles(folder_.path()), board_, {}, RunContext{});
  }
};

TEST_F(CalibrationTest, FindsTheBoardsCorners) {
  const Eigen::Isometry3d pose = FacingPose({30, -20, 500}, 30, 40, 20);
  Image image;
  RenderBoard(truth_, board_, pose, {.colour = false}, 1, image);
  MarkerDetector detector(board_.dictionary);
  const auto found = FindBoardCorners(image, board_, detector);
  const auto corners = board_.CornersMm();
  EXPECT_EQ(found.size(), corners.size());
  for (const BoardCorner& corner : found) {
    EXPECT_LT((*truth_.Project(pose * corners[corner.number]) - corner.pixel).norm(), 0.15)
        << corner.number;
  }
}

TEST_F(CalibrationTest, FindsTheCameraThatTookTheImages) {
  TakeImages(16, 40.0, 1.0, 4);
  const Calibration found = Calibrate();
  const CameraParameters& p = found.camera.parameters();
  const CameraParameters& t = truth_.parameters();
  std::cout << TableText(found);
  EXPECT_LT(found.rms_px, 0.1);
  EXPECT_NEAR(p.focal_px[0], t.focal_px[0], 0.002 * t.focal_px[0]);
  EXPECT_NEAR(p.focal_px[1], t.focal_px[1], 0.002 * t.focal_px[1]);
  EXPECT_LT((p.centre_px - t.centre_px).norm(), 2.0);
  // What matters: where it puts the lines of sight, up to a turn of the whole camera.
  double largest_px = 0.0;
  for (int row = 60; row < 720; row += 120) {
    for (int column = 60; column < 1280; column += 116) {
      const auto ray = found.camera.Ray(Eigen::Vector2d(column, row));
      ASSERT_TRUE(ray);
      largest_px = std::max(largest_px,
                            (*truth_.Project(1000.0 * *ray) - Eigen::Vector2d(column, row)).norm());
    }
  }
  std::cout << "lines of sight off by at most " << largest_px << " px\n";
  EXPECT_LT(largest_px, 2.0);
  EXPECT_TRUE(found.warnings.empty()) << found.warnings[0];
}

TEST_F(CalibrationTest, BadViewsAreExcludedAndNamed) {
  TakeImages(8, 40.0);
  // The first is of another camera.
  CameraParameters other = truth_.parameters();
  other.radial[0] += 0.3;
  Image foreign;
  RenderBoard(CameraModel(other), board_, FacingPose({-120, 60, 450}, 35.0, 30.0, 0.0),
              {.samples = 2, .colour = false}, 1, foreign);
  WriteImage(folder_ / "100.png", foreign);
  Image empty;
  empty.Resize(1280, 720, 1);
  std::fill(empty.pixels.begin(), empty.pixels.end(), std::uint8_t{90});
  WriteImage(folder_ / "200.png", empty);
  empty.Resize(640, 480, 1);
  WriteImage(folder_ / "201.png", empty);
  const Calibration found = Calibrate();
  ASSERT_EQ(found.views.size(), 10U);
  EXPECT_THAT(found.views[0].rejected, HasSubstr("does not fit the others"));
  for (std::size_t i = 1; i < 8; ++i) EXPECT_EQ(found.views[i].rejected, "") << i;
  EXPECT_THAT(found.views[8].rejected, HasSubstr("only 0 corners"));
  EXPECT_THAT(found.views[9].rejected, HasSubstr("640 x 480"));
  EXPECT_FALSE(found.warnings.empty());
}

TEST_F(CalibrationTest, SaysWhatIsMissing) {
  TakeImages(7, 8.0, 0.2);
  const Calibration found = Calibrate();
  std::string all;
  for (const std::string& warning : found.warnings) all += warning + "\n";
  EXPECT_NE(all.find("never tilted"), std::string::npos) << all;
  EXPECT_NE(all.find("of the image"), std::string::npos) << all;
}

TEST_F(CalibrationTest, SaysThatRowsAndColumnsAreSwapped) {
  TakeImages(7, 40.0);
  std::swap(board_.columns, board_.rows);
  EXPECT_THAT([&] { Calibrate(); },
              ThrowsMessage<NoAnswerError>(HasSubstr("rows and columns are swapped")));
}

TEST_F(CalibrationTest, SaysThatTheFirstSquareIsAnother) {
  board_.first_square = FirstSquare::kMarker;
  TakeImages(7, 40.0);
  board_.first_square = FirstSquare::kBlack;
  EXPECT_THAT([&] { Calibrate(); },
              ThrowsMessage<NoAnswerError>(HasSubstr(R"("first_square": "marker")")));
}

/// The markers of a board close to an endoscope, whose lens moves them by up to a third of their
/// side; every eighth is misread as another.
std::vector<DetectedMarker> ThroughAnEndoscope(const CalibrationBoard& board) {
  std::vector<DetectedMarker> seen;
  const auto markers = board.Markers();
  for (const Marker& marker : markers) {
    DetectedMarker& detected = seen.emplace_back();
    detected.id = marker.id;
    const auto corners = marker.CornersInObjectMm();
    for (std::size_t k = 0; k < 4; ++k) {
      const Eigen::Vector2d at = corners[k].head<2>() / 150.0;
      detected.corners_px[k] =
          Eigen::Vector2d(480, 270) + 800.0 * (1.0 - 0.12 * at.squaredNorm()) * at;
    }
  }
  for (std::size_t i = 0; i < seen.size(); i += 8) {
    seen[i].id = static_cast<int>((i + markers.size() / 2) % markers.size());
  }
  return seen;
}

TEST(BoardViews, MisreadMarkersAreLeftOutAndDistortionIsNoOtherLayout) {
  for (const FirstSquare first : {FirstSquare::kBlack, FirstSquare::kMarker}) {
    CalibrationBoard board = ReadBoard(ConfigPath("cameras/board_a4.json"));
    board.first_square = first;
    const auto seen = ThroughAnEndoscope(board);
    const auto read = WithoutMisread(seen, board);
    EXPECT_EQ(read.size(), seen.size() - (seen.size() + 7) / 8);
    const auto markers = board.Markers();
    const auto truth = ThroughAnEndoscope(board);
    for (const DetectedMarker& marker : read) {
      // Still at the place of its number.
      EXPECT_LT(
          (marker.corners_px[0] - truth[static_cast<std::size_t>(marker.id)].corners_px[0]).norm(),
          1e-9);
    }
    EXPECT_EQ(ExplainLayout({seen}, board), "");
    board.first_square = first == FirstSquare::kBlack ? FirstSquare::kMarker : FirstSquare::kBlack;
    EXPECT_THAT(ExplainLayout({seen}, board), HasSubstr("first_square"));
  }
}

TEST_F(CalibrationTest, FindsTheCameraWithABoardWhoseFirstSquareHoldsAMarker) {
  board_.first_square = FirstSquare::kMarker;
  TakeImages(12, 40.0, 1.0, 2);
  const Calibration found = Calibrate();
  EXPECT_LT(found.rms_px, 0.15);
  EXPECT_NEAR(found.camera.parameters().focal_px[0], truth_.parameters().focal_px[0],
              0.005 * truth_.parameters().focal_px[0]);
}

TEST_F(CalibrationTest, RefusesResidualsAboveTheLimit) {
  TakeImages(8, 40.0);
  EXPECT_THAT(
      [&] {
        CalibrateCamera(ImageFiles(folder_.path()), board_, {.limit_px = 0.01}, RunContext{});
      },
      ThrowsMessage<NoAnswerError>(HasSubstr("is the board flat")));
}

TEST_F(CalibrationTest, NoIntervalReadsAsZero) {
  TakeImages(8, 40.0);
  const Calibration found = Calibrate();
  const std::string text = TableText(found);
  const Eigen::Vector2d centre_px = found.camera.parameters().centre_px;
  EXPECT_THAT(text, testing::ContainsRegex(Message("centre ", FixedText(centre_px.x(), 2),
                                                   " .. [0-9.]+, ", FixedText(centre_px.y(), 2))));
  EXPECT_EQ(text.find("+- 0,"), std::string::npos) << text;
  EXPECT_EQ(text.find("+- 0.00 "), std::string::npos) << text;
  EXPECT_NE(text.find("95 % intervals"), std::string::npos) << text;
}

TEST_F(CalibrationTest, FindsAStereoPair) {
  const Eigen::Isometry3d right_from_left =
      Eigen::Translation3d(-80, 2, 5) * Eigen::AngleAxisd(0.1, Eigen::Vector3d::UnitY());
  const std::filesystem::path right_folder = folder_ / "right";
  std::filesystem::create_directory(right_folder);
  for (int i = 0; i < 8; ++i) {
    RandomStream random(5, "stereo", static_cast<std::uint64_t>(i));
    const auto pose = FacingPose({random.Uniform(-60, 60), random.Uniform(-40, 40), 550},
                                 random.Uniform(10, 35), 45.0 * i, random.Uniform(-90, 90));
    Take(i, pose);
    Image image;
    RenderBoard(truth_, board_, right_from_left * pose, {.samples = 2, .colour = false},
                static_cast<std::uint64_t>(50 + i), image);
    WriteImage(right_folder / (std::to_string(100 + i) + ".png"), image);
  }
  const auto left = FindBoardViews(ImageFiles(folder_.path()), board_, 12, RunContext{});
  auto right = FindBoardViews(ImageFiles(right_folder), board_, 12, RunContext{});
  const auto found = CalibrateStereo(left, right, board_, truth_, truth_, 1.5);
  EXPECT_LT((found.right_from_left.translation() - right_from_left.translation()).norm(), 0.5);
  EXPECT_LT(ErrorOf(found.right_from_left, right_from_left).angle_deg, 0.05);
  EXPECT_LT(found.rms_px, 0.15);
  std::ranges::rotate(right.views, right.views.begin() + 1);  // Of other moments.
  EXPECT_THAT([&] { CalibrateStereo(left, right, board_, truth_, truth_, 1.5); },
              ThrowsMessage<NoAnswerError>(HasSubstr("not of the same moments")));
}

TEST_F(CalibrationTest, TooFewImagesGiveNoCamera) {
  TakeImages(4, 40.0);
  EXPECT_THROW(Calibrate(), NoAnswerError);
  WriteTextFile(folder_ / "300.png", "no image");
  EXPECT_THROW(Calibrate(), InputError);
}

TEST(CalibrationBoard, RefusesWhatCannotBePrinted) {
  const TemporaryFolder folder;
  const auto refused = [&](const std::string& numbers) {
    WriteTextFile(folder / "b.json",
                  R"({"format": "acus-camera-board/1", "name": "b", )" + numbers + "}");
    EXPECT_THROW(ReadBoard(folder / "b.json"), InputError) << numbers;
  };
  refused(R"("dictionary": "aruco_4x4_50", "columns": 11, "rows": 11, "square_mm": 10)");
  refused(R"("dictionary": "aruco_4x4_50", "columns": 6, "rows": 9, "square_mm": 40)");
  refused(R"("dictionary": "aruco_4x4_50", "columns": 2, "rows": 9, "square_mm": 10)");
}

}  // namespace
}  // namespace acus::camera
