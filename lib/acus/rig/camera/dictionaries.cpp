#include <array>
#include <opencv2/aruco/dictionary.hpp>
#include <string_view>

#include "acus/base/core/error.h"
#include "acus/rig/camera/facets.h"
#include "acus/rig/camera/opencv_image.h"

namespace acus::camera {
namespace {

struct Name {
  std::string_view name;
  int opencv;
};

constexpr std::array<Name, 21> kNames = {{{"aruco_4x4_50", cv::aruco::DICT_4X4_50},
                                          {"aruco_4x4_100", cv::aruco::DICT_4X4_100},
                                          {"aruco_4x4_250", cv::aruco::DICT_4X4_250},
                                          {"aruco_4x4_1000", cv::aruco::DICT_4X4_1000},
                                          {"aruco_5x5_50", cv::aruco::DICT_5X5_50},
                                          {"aruco_5x5_100", cv::aruco::DICT_5X5_100},
                                          {"aruco_5x5_250", cv::aruco::DICT_5X5_250},
                                          {"aruco_5x5_1000", cv::aruco::DICT_5X5_1000},
                                          {"aruco_6x6_50", cv::aruco::DICT_6X6_50},
                                          {"aruco_6x6_100", cv::aruco::DICT_6X6_100},
                                          {"aruco_6x6_250", cv::aruco::DICT_6X6_250},
                                          {"aruco_6x6_1000", cv::aruco::DICT_6X6_1000},
                                          {"aruco_7x7_50", cv::aruco::DICT_7X7_50},
                                          {"aruco_7x7_100", cv::aruco::DICT_7X7_100},
                                          {"aruco_7x7_250", cv::aruco::DICT_7X7_250},
                                          {"aruco_7x7_1000", cv::aruco::DICT_7X7_1000},
                                          {"aruco_original", cv::aruco::DICT_ARUCO_ORIGINAL},
                                          {"apriltag_16h5", cv::aruco::DICT_APRILTAG_16h5},
                                          {"apriltag_25h9", cv::aruco::DICT_APRILTAG_25h9},
                                          {"apriltag_36h10", cv::aruco::DICT_APRILTAG_36h10},
                                          {"apriltag_36h11", cv::aruco::DICT_APRILTAG_36h11}}};

}  // namespace

int OpenCvDictionary(const std::string& name) {
  for (const Name& known : kNames) {
    if (known.name == name) return known.opencv;
  }
  std::string all;
  for (const Name& known : kNames) all += (all.empty() ? "" : ", ") + std::string(known.name);
  throw InputError("marker dictionary '" + name + "' does not exist; there are " + all);
}

int DictionarySize(const std::string& name) {
  return cv::aruco::getPredefinedDictionary(OpenCvDictionary(name))->bytesList.rows;
}

std::vector<std::vector<bool>> MarkerBits(const std::string& dictionary, int id) {
  const int size = DictionarySize(dictionary);
  ACUS_REQUIRE(id >= 0 && id < size, "marker ", id, " is not in ", dictionary, ", which has 0 to ",
               size - 1);
  const auto codes = cv::aruco::getPredefinedDictionary(OpenCvDictionary(dictionary));
  const cv::Mat bits = cv::aruco::Dictionary::getBitsFromByteList(
      codes->bytesList.rowRange(id, id + 1), codes->markerSize);
  std::vector<std::vector<bool>> out;
  for (int r = 0; r < bits.rows; ++r) {
    std::vector<bool>& row = out.emplace_back();
    for (int c = 0; c < bits.cols; ++c) row.push_back(bits.at<unsigned char>(r, c) != 0);
  }
  return out;
}

}  // namespace acus::camera
