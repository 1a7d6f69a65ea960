#include "acus/rig/camera/calibration.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <opencv2/calib3d.hpp>
#include <set>

#include "acus/base/config/json_file.h"
#include "acus/base/core/error.h"
#include "acus/base/core/text_table.h"
#include "acus/base/math/statistics.h"

namespace acus::camera {
namespace {

using nlohmann::json;

constexpr int kFieldsAcross = 8;
constexpr int kFieldsDown = 6;
constexpr double kLeastOutlierPx = 0.3;
constexpr double kLeastStrayPx = 1.0;
constexpr double kStrayMedians = 5.0;
constexpr double kMostStrays = 0.3;  ///< Share of a view's corners.

/// Corners of the images that are used, and which view each belongs to.
struct Corners {
  int width_px = 0;
  int height_px = 0;
  std::vector<std::vector<cv::Point3f>> on_board;
  std::vector<std::vector<cv::Point2f>> in_image;
  std::vector<std::size_t> view;

  void Remove(std::size_t i) {
    const auto at = static_cast<std::ptrdiff_t>(i);
    on_board.erase(on_board.begin() + at);
    in_image.erase(in_image.begin() + at);
    view.erase(view.begin() + at);
  }
};

Corners FindCorners(const std::vector<std::filesystem::path>& images, const CalibrationBoard& board,
                    const CalibrationSettings& settings, const RunContext& context,
                    std::vector<CalibrationView>& views) {
  const BoardViews found = FindBoardViews(images, board, settings.least_corners, context);
  const auto on_board = board.CornersMm();
  Corners all;
  all.width_px = found.width_px;
  all.height_px = found.height_px;
  for (std::size_t i = 0; i < images.size(); ++i) {
    const BoardView& seen = found.views[i];
    CalibrationView& view = views.emplace_back();
    view.file = seen.file;
    view.corners = static_cast<int>(seen.corners.size());
    view.misread = seen.misread;
    view.rejected = seen.rejected;
    if (!view.rejected.empty()) continue;
    std::vector<cv::Point3f>& from = all.on_board.emplace_back();
    std::vector<cv::Point2f>& to = all.in_image.emplace_back();
    for (const BoardCorner& corner : seen.corners) {
      const Eigen::Vector3f at = on_board[corner.number].cast<float>();
      from.emplace_back(at[0], at[1], at[2]);
      to.emplace_back(static_cast<float>(corner.pixel[0]), static_cast<float>(corner.pixel[1]));
    }
    all.view.push_back(i);
  }
  return all;
}

struct Solution {
  cv::Mat matrix, distortion, sigma, view_rms;
  std::vector<cv::Mat> turns, shifts;
  double rms_px = 0.0;
};

Solution Solve(const Corners& corners, bool fit_k3) {
  Solution s;
  cv::Mat ignored;
  try {
    s.rms_px =
        cv::calibrateCamera(corners.on_board, corners.in_image,
                            {corners.width_px, corners.height_px}, s.matrix, s.distortion, s.turns,
                            s.shifts, s.sigma, ignored, s.view_rms, fit_k3 ? 0 : cv::CALIB_FIX_K3,
                            {cv::TermCriteria::COUNT + cv::TermCriteria::EPS, 100, 1e-12});
  } catch (const cv::Exception& error) {
    throw NoAnswerError("the calibration failed (" + error.err +
                        "); take images of the board at more different angles");
  }
  return s;
}

void CheckCount(const Corners& corners, const CalibrationSettings& settings) {
  if (static_cast<int>(corners.view.size()) >= settings.least_views) return;
  throw NoAnswerError(Message(
      "only ", corners.view.size(), " images show enough of the board, ", settings.least_views,
      " are needed: take 15 to 25 sharp ones, with the board at different angles of 20 to 50 "
      "degrees, and in every corner of the image"));
}

/// Omits corners that the model, distortion included, puts elsewhere: stray reflections, or
/// markers misread by less than a square. True if there were any.
bool RejectBadCorners(const Solution& solution, Corners& corners,
                      const CalibrationSettings& settings, std::vector<CalibrationView>& views) {
  std::vector<std::vector<double>> off_px;
  std::vector<double> all_px;
  for (std::size_t i = 0; i < corners.view.size(); ++i) {
    std::vector<cv::Point2f> mapped;
    cv::projectPoints(corners.on_board[i], solution.turns[i], solution.shifts[i], solution.matrix,
                      solution.distortion, mapped);
    std::vector<double>& off = off_px.emplace_back();
    for (std::size_t k = 0; k < mapped.size(); ++k) {
      off.push_back(cv::norm(mapped[k] - corners.in_image[i][k]));
    }
    all_px.insert(all_px.end(), off.begin(), off.end());
  }
  const double limit_px = std::max(kLeastStrayPx, kStrayMedians * math::Median(all_px));
  bool any = false;
  for (std::size_t i = corners.view.size(); i-- > 0;) {
    const auto strays = std::ranges::count_if(off_px[i], [&](double px) { return px > limit_px; });
    // A view of which many corners are off is bad as a whole: RejectBadViews.
    if (static_cast<double>(strays) > kMostStrays * static_cast<double>(off_px[i].size())) continue;
    for (std::size_t k = off_px[i].size(); k-- > 0;) {
      if (off_px[i][k] <= limit_px) continue;
      corners.on_board[i].erase(corners.on_board[i].begin() + static_cast<std::ptrdiff_t>(k));
      corners.in_image[i].erase(corners.in_image[i].begin() + static_cast<std::ptrdiff_t>(k));
      any = true;
    }
    CalibrationView& view = views[corners.view[i]];
    view.corners = static_cast<int>(corners.in_image[i].size());
    if (view.corners >= settings.least_corners) continue;
    view.rejected = Message("only ", view.corners, " corners of the board fit the others");
    corners.Remove(i);
  }
  return any;
}

/// Omits views far worse than the rest. True if there were any.
bool RejectBadViews(const Solution& solution, Corners& corners,
                    std::vector<CalibrationView>& views) {
  std::vector<double> rms;
  for (int i = 0; i < solution.view_rms.rows; ++i) rms.push_back(solution.view_rms.at<double>(i));
  const double limit = std::max(kLeastOutlierPx, 3.0 * math::Median(rms));
  bool any = false;
  for (std::size_t i = rms.size(); i-- > 0;) {
    if (rms[i] <= limit) continue;
    views[corners.view[i]].rejected = Message("does not fit the others: ", FixedText(rms[i], 2),
                                              " px; blurred, or a bent board?");
    corners.Remove(i);
    any = true;
  }
  return any;
}

/// Refuses what is no calibration: before the model is made, since its numbers may be absurd.
void RequireFit(const Solution& solution, const Corners& corners,
                const CalibrationSettings& settings) {
  if (solution.rms_px <= settings.limit_px) return;
  throw NoAnswerError(Message(
      "the corners of the board are ", solution.rms_px, " px RMS from where the camera of ",
      corners.view.size(), " images puts them (allowed: ", settings.limit_px,
      " px, --limit-px): is the board flat and not blurred, are all images from one camera with "
      "fixed zoom and focus, and do columns, rows and dictionary of the board's file agree with "
      "the print?"));
}

/// Half of the 95 % interval with two digits; so that no interval reads as 0.
std::string IntervalText(double sigma) {
  return sigma > 0.0 && std::isfinite(sigma) ? RoundedText(1.96 * sigma, 2) : "unknown";
}

CameraModel ModelOf(const Solution& s, const Corners& corners) {
  CameraParameters p;
  p.name = "calibrated camera";
  p.description = Message("Calibrated with ", corners.view.size(), " images");
  p.width_px = corners.width_px;
  p.height_px = corners.height_px;
  p.focal_px = {s.matrix.at<double>(0, 0), s.matrix.at<double>(1, 1)};
  p.centre_px = {s.matrix.at<double>(0, 2), s.matrix.at<double>(1, 2)};
  const auto d = [&](int i) { return s.distortion.at<double>(i); };
  p.radial = {d(0), d(1), d(4)};
  p.tangential = {d(2), d(3)};
  p.reprojection_rms_px = s.rms_px;
  try {
    return CameraModel(p);
  } catch (const InputError& error) {
    throw NoAnswerError(std::string("the images do not determine the camera: ") + error.what());
  }
}

void DescribeViews(const Solution& s, const Corners& corners, std::vector<CalibrationView>& views) {
  for (std::size_t i = 0; i < corners.view.size(); ++i) {
    CalibrationView& view = views[corners.view[i]];
    view.rms_px = s.view_rms.at<double>(static_cast<int>(i));
    cv::Mat turn;
    cv::Rodrigues(s.turns[i], turn);
    view.tilt_deg =
        std::acos(std::min(1.0, std::abs(turn.at<double>(2, 2)))) * 180.0 / std::numbers::pi;
    view.distance_mm = cv::norm(s.shifts[i]);
  }
}

double CoveredShare(const Corners& corners, bool& all_corners) {
  std::set<int> fields;
  for (const auto& image : corners.in_image) {
    for (const cv::Point2f& at : image) {
      const int across =
          std::clamp(static_cast<int>(at.x * kFieldsAcross / static_cast<float>(corners.width_px)),
                     0, kFieldsAcross - 1);
      const int down =
          std::clamp(static_cast<int>(at.y * kFieldsDown / static_cast<float>(corners.height_px)),
                     0, kFieldsDown - 1);
      fields.insert(down * kFieldsAcross + across);
    }
  }
  all_corners = fields.contains(0) && fields.contains(kFieldsAcross - 1) &&
                fields.contains((kFieldsDown - 1) * kFieldsAcross) &&
                fields.contains(kFieldsDown * kFieldsAcross - 1);
  return static_cast<double>(fields.size()) / (kFieldsAcross * kFieldsDown);
}

void AddWarnings(const Corners& corners, Calibration& out) {
  bool all_corners = false;
  out.covered_share = CoveredShare(corners, all_corners);
  if (out.covered_share < 0.7 || !all_corners) {
    out.warnings.push_back(Message("the board covers ", std::lround(100.0 * out.covered_share),
                                   " % of the image",
                                   all_corners ? "" : ", and not all of its corners",
                                   ": there the lens is a guess; add images with the board there"));
  }
  double largest_tilt = 0.0;
  int rejected = 0, misread = 0;
  for (const CalibrationView& view : out.views) {
    if (view.rejected.empty()) largest_tilt = std::max(largest_tilt, view.tilt_deg);
    rejected += view.rejected.empty() ? 0 : 1;
    misread += view.misread;
  }
  if (largest_tilt < 20.0) {
    out.warnings.push_back(Message("the board was never tilted by more than ",
                                   std::lround(largest_tilt),
                                   " degrees: the focal length is not sure; tilt it by 20 to 50"));
  }
  const double focal = out.camera.parameters().focal_px.minCoeff();
  if (std::max(out.sigma[0], out.sigma[1]) > 0.005 * focal) {
    out.warnings.push_back(Message(
        "the focal length is known to ",
        FixedText(100.0 * std::max(out.sigma[0], out.sigma[1]) / focal, 1), " % only; add images"));
  }
  if (out.rms_px > 1.0) {
    out.warnings.push_back(
        Message("corners are off by ", FixedText(out.rms_px, 2),
                " px RMS: is the board flat, and its square as long as the file says?"));
  }
  if (misread > 0) {
    out.warnings.push_back(Message(misread, " markers were misread and omitted"));
  }
  if (rejected > 0) {
    out.warnings.push_back(Message(rejected, " of ", out.views.size(), " images were not used"));
  }
}

}  // namespace

Calibration CalibrateCamera(const std::vector<std::filesystem::path>& images,
                            const CalibrationBoard& board, const CalibrationSettings& settings,
                            const RunContext& context) {
  std::vector<CalibrationView> views;
  Corners corners = FindCorners(images, board, settings, context, views);
  CheckCount(corners, settings);
  Solution solution = Solve(corners, settings.fit_k3);
  if (RejectBadCorners(solution, corners, settings, views)) {
    CheckCount(corners, settings);
    solution = Solve(corners, settings.fit_k3);
  }
  if (RejectBadViews(solution, corners, views)) {
    CheckCount(corners, settings);
    solution = Solve(corners, settings.fit_k3);
  }
  RequireFit(solution, corners, settings);
  DescribeViews(solution, corners, views);
  Calibration out{.camera = ModelOf(solution, corners),
                  .rms_px = solution.rms_px,
                  .sigma = {},
                  .views = std::move(views),
                  .covered_share = 0.0,
                  .warnings = {}};
  // OpenCV's order: fx, fy, cx, cy, k1, k2, p1, p2, k3.
  constexpr std::array<int, 9> kOrder = {0, 1, 2, 3, 4, 5, 8, 6, 7};
  for (std::size_t i = 0; i < 9; ++i) out.sigma[i] = solution.sigma.at<double>(kOrder[i]);
  AddWarnings(corners, out);
  return out;
}

std::string TableText(const Calibration& calibration) {
  std::vector<std::vector<std::string>> rows;
  for (const CalibrationView& view : calibration.views) {
    const bool used = view.rejected.empty();
    rows.push_back({view.file, std::to_string(view.corners), used ? FixedText(view.rms_px, 3) : "-",
                    used ? FixedText(view.tilt_deg, 0) : "-",
                    used ? FixedText(view.distance_mm, 0) : "-", view.rejected});
  }
  const CameraParameters& p = calibration.camera.parameters();
  const auto with_sigma = [&](double value, std::size_t i, int decimals) {
    return FixedText(value, decimals) + " +- " + IntervalText(calibration.sigma[i]);
  };
  return TextTable({"image", "corners", "RMS px", "tilt deg", "distance mm", "not used because"},
                   rows) +
         Message("reprojection ", FixedText(calibration.rms_px, 3), " px RMS\n", "focal ",
                 with_sigma(p.focal_px[0], 0, 2), ", ", with_sigma(p.focal_px[1], 1, 2),
                 " px; centre ", with_sigma(p.centre_px[0], 2, 2), ", ",
                 with_sigma(p.centre_px[1], 3, 2), " px\nk1 ", with_sigma(p.radial[0], 4, 5),
                 ", k2 ", with_sigma(p.radial[1], 5, 5), ", p1 ", with_sigma(p.tangential[0], 7, 5),
                 ", p2 ", with_sigma(p.tangential[1], 8, 5), "\n",
                 std::lround(100.0 * calibration.covered_share),
                 " % of the image covered; 95 % intervals; ",
                 FixedText(calibration.camera.HorizontalAngleDeg(), 1), " degrees wide\n");
}

json ToJson(const Calibration& calibration) {
  json views = json::array();
  for (const CalibrationView& view : calibration.views) {
    views.push_back({{"file", view.file},
                     {"corners", view.corners},
                     {"misread_markers", view.misread},
                     {"rms_px", view.rms_px},
                     {"tilt_deg", view.tilt_deg},
                     {"distance_mm", view.distance_mm},
                     {"rejected", view.rejected}});
  }
  return {
      {"format", "acus-camera-calibration/1"},
      {"reprojection_rms_px", calibration.rms_px},
      {"sigma_fx_fy_cx_cy_px",
       {calibration.sigma[0], calibration.sigma[1], calibration.sigma[2], calibration.sigma[3]}},
      {"sigma_radial", {calibration.sigma[4], calibration.sigma[5], calibration.sigma[6]}},
      {"sigma_tangential", {calibration.sigma[7], calibration.sigma[8]}},
      {"covered_share", calibration.covered_share},
      {"horizontal_angle_deg", calibration.camera.HorizontalAngleDeg()},
      {"views", views},
      {"warnings", calibration.warnings}};
}

void WriteResult(const std::filesystem::path& folder, const Calibration& calibration,
                 const RunContext& context) {
  WriteCamera(folder / "camera.json", calibration.camera);
  config::WriteJson(folder / "calibration.json", ToJson(calibration));
  config::WriteJson(folder / "provenance.json", context.provenance.ToJson());
}

}  // namespace acus::camera
