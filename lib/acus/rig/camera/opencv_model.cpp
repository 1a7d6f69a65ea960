#include "acus/rig/camera/opencv_model.h"

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <nlohmann/json.hpp>
#include <opencv2/core.hpp>
#include <stdexcept>
#include <string>
#include <vector>

#include "acus/base/config/json_from_child.h"
#include "acus/base/core/atomic_file.h"
#include "acus/base/core/error.h"
#include "acus/base/core/input_file.h"
#include "acus/base/core/xml_scan.h"

namespace acus::camera {
namespace {

constexpr std::uintmax_t kMostFileBytes = 1U << 20U;
constexpr std::size_t kMostCoefficients = 14;
constexpr double kReadTimeOfCameraS = 10.0;  ///< A whole file takes a millisecond.
constexpr double kLeastFocalShare =
    0.1;  // Focal length over width: 157 degrees. A wider lens is no pinhole.

/// The first node of these names.
cv::FileNode NodeOf(const cv::FileStorage& file, std::initializer_list<const char*> names,
                    const std::string& label) {
  for (const char* name : names) {
    if (const cv::FileNode node = file[name]; !node.empty()) return node;
  }
  throw InputError(
      Message(label, ": has no ", *names.begin(), "; a calibration of OpenCV or ROS is needed"));
}

/// The numbers of a matrix, or of a list.
std::vector<double> NumbersOf(const cv::FileNode& node, const std::string& what) {
  const cv::FileNode data = node.isMap() ? node["data"] : node;
  std::vector<double> numbers;
  ACUS_REQUIRE(data.isSeq() && data.size() <= 16, what, ": is no matrix of up to 16 numbers");
  for (const cv::FileNode& number : data) {
    ACUS_REQUIRE((number.isReal() || number.isInt()) && std::isfinite(number.real()), what,
                 ": holds something else than finite numbers");
    numbers.push_back(number.real());
  }
  return numbers;
}

int SizeOf(const cv::FileNode& node, const std::string& what) {
  ACUS_REQUIRE(node.isInt(), what, ": must be a whole number of pixels");
  return static_cast<int>(node);
}

CameraParameters ParametersFrom(const cv::FileStorage& file, const std::string& label) {
  CameraParameters p;
  p.name = label;
  p.width_px =
      SizeOf(NodeOf(file, {"image_width", "image_Width", "width"}, label), label + ": image_width");
  p.height_px = SizeOf(NodeOf(file, {"image_height", "image_Height", "height"}, label),
                       label + ": image_height");
  const auto matrix =
      NumbersOf(NodeOf(file, {"camera_matrix", "Camera_Matrix", "cameraMatrix", "K"}, label),
                label + ": camera_matrix");
  const bool has_form = matrix.size() == 9 && matrix[1] == 0.0 && matrix[3] == 0.0 &&
                        matrix[6] == 0.0 && matrix[7] == 0.0 && matrix[8] == 1.0;
  ACUS_REQUIRE(has_form, label, ": camera_matrix is not [fx 0 cx; 0 fy cy; 0 0 1]");
  ACUS_REQUIRE(std::min(matrix[0], matrix[4]) >= kLeastFocalShare * p.width_px, label,
               ": camera_matrix has focal lengths of ", matrix[0], " and ", matrix[4],
               " for an image of ", p.width_px, " pixels; they are needed in pixels");
  p.focal_px = {matrix[0], matrix[4]};
  p.centre_px = {matrix[2], matrix[5]};
  const auto lens = NumbersOf(NodeOf(file,
                                     {"distortion_coefficients", "Distortion_Coefficients",
                                      "distCoeffs", "dist_coeffs", "D"},
                                     label),
                              label + ": distortion_coefficients");
  ACUS_REQUIRE(lens.size() >= 4 && lens.size() <= kMostCoefficients, label,
               ": distortion_coefficients are ", lens.size(), "; 4, 5 or more are needed");
  for (std::size_t i = 5; i < lens.size(); ++i) {
    ACUS_REQUIRE(lens[i] == 0.0, label, ": distortion_coefficients: coefficient ", i + 1, " is ",
                 lens[i], "; lenses of five coefficients (k1 k2 p1 p2 k3) are modelled");
  }
  p.radial = {lens[0], lens[1], lens.size() > 4 ? lens[4] : 0.0};
  p.tangential = {lens[2], lens[3]};
  const cv::FileNode fisheye = file["fisheye_model"];
  ACUS_REQUIRE(fisheye.empty() || (fisheye.isInt() && static_cast<int>(fisheye) == 0), label,
               ": fisheye_model is set; lenses of five coefficients (k1 k2 p1 p2 k3) are modelled");
  const cv::FileNode model = file["distortion_model"];
  ACUS_REQUIRE(model.empty() || (model.isString() && model.string() == "plumb_bob"), label,
               ": distortion_model is ", model.isString() ? model.string() : "no word",
               "; plumb_bob is read");
  return p;
}

/// OpenCV's parser descends into elements, and needs its own root.
void RequireShallowXml(const std::string& text, const std::string& label) {
  constexpr int kMostDepth = 20;
  const auto elements = core::ScanXml(text, label);
  ACUS_REQUIRE(elements.front().name == "opencv_storage", label, ": the root is <",
               elements.front().name, ">; <opencv_storage> of OpenCV's FileStorage is read");
  for (const core::XmlElement& element : elements) {
    ACUS_REQUIRE(element.depth <= kMostDepth, label, ": more than ", kMostDepth,
                 " elements within each other");
  }
}

/// The numbers of a calibration: size, focal lengths, centre and lens, in this order.
std::vector<double> NumbersOfCamera(const std::string& text, bool is_xml,
                                    const std::string& label) {
  const char* format = is_xml ? "XML" : "YAML";
  try {
    const cv::FileStorage file(
        text, cv::FileStorage::READ | cv::FileStorage::MEMORY |
                  (is_xml ? cv::FileStorage::FORMAT_XML : cv::FileStorage::FORMAT_YAML));
    ACUS_REQUIRE(file.isOpened(), label, ": is no ", format);
    const CameraParameters p = ParametersFrom(file, label);
    return {static_cast<double>(p.width_px),
            static_cast<double>(p.height_px),
            p.focal_px[0],
            p.focal_px[1],
            p.centre_px[0],
            p.centre_px[1],
            p.radial[0],
            p.radial[1],
            p.radial[2],
            p.tangential[0],
            p.tangential[1]};
  } catch (const cv::Exception& error) {
    throw InputError(Message(label, ": is no ", format, " of OpenCV: ", error.err));
  } catch (const std::length_error&) {  // OpenCV's parser throws it at a key without a name.
    throw InputError(Message(label, ": is no ", format, " of OpenCV: a key has no name"));
  }
}

/// In a separate process: OpenCV's parser does not end on some broken files.
CameraParameters ParametersInChild(const std::string& text, bool is_xml, const std::string& label) {
  core::ChildLimits limits;
  limits.time_s = kReadTimeOfCameraS;
  limits.memory_bytes = 1e9;
  const auto n =
      config::JsonFromChild(limits, label + ": OpenCV cannot read it; the file is broken", [&] {
        return nlohmann::json(NumbersOfCamera(text, is_xml, label));
      }).get<std::vector<double>>();
  CameraParameters p;
  p.width_px = static_cast<int>(n[0]);
  p.height_px = static_cast<int>(n[1]);
  p.focal_px = {n[2], n[3]};
  p.centre_px = {n[4], n[5]};
  p.radial = {n[6], n[7], n[8]};
  p.tangential = {n[9], n[10]};
  return p;
}

}  // namespace

CameraModel ReadOpenCvCamera(const std::filesystem::path& path) {
  const std::string label = path.string();
  RequireInputFile(path, kMostFileBytes);
  std::string text = ReadTextFile(path);
  const bool is_xml = path.extension() == ".xml";
  if (is_xml) RequireShallowXml(text, label);
  RequireJsonDepth(text, label);  // Its parser of YAML descends into braces, too.
  if (!is_xml && !text.starts_with("%YAML")) text = "%YAML:1.0\n---\n" + text;
  CameraParameters parameters = ParametersInChild(text, is_xml, label);
  parameters.name = path.stem().string();
  try {
    return CameraModel(parameters);
  } catch (const InputError& error) {
    throw InputError(label + ": " + error.what());
  }
}

cv::Mat MatrixOf(const CameraModel& camera) {
  const CameraParameters& p = camera.parameters();
  return (cv::Mat_<double>(3, 3) << p.focal_px[0], 0, p.centre_px[0], 0, p.focal_px[1],
          p.centre_px[1], 0, 0, 1);
}

cv::Mat DistortionOf(const CameraModel& camera) {
  const CameraParameters& p = camera.parameters();
  return (cv::Mat_<double>(1, 5) << p.radial[0], p.radial[1], p.tangential[0], p.tangential[1],
          p.radial[2]);
}

cv::Mat TurnOf(const Eigen::Isometry3d& pose) {
  cv::Mat turn(3, 3, CV_64F);
  for (int i = 0; i < 9; ++i) turn.at<double>(i / 3, i % 3) = pose.linear()(i / 3, i % 3);
  return turn;
}

cv::Mat ShiftOf(const Eigen::Isometry3d& pose) {
  cv::Mat shift(3, 1, CV_64F);
  for (int i = 0; i < 3; ++i) shift.at<double>(i) = pose.translation()[i];
  return shift;
}

Eigen::Isometry3d PoseFrom(const cv::Mat& turn, const cv::Mat& shift) {
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  for (int i = 0; i < 9; ++i) pose.linear()(i / 3, i % 3) = turn.at<double>(i / 3, i % 3);
  for (int i = 0; i < 3; ++i) pose.translation()[i] = shift.at<double>(i);
  return pose;
}

}  // namespace acus::camera
