#include "acus/scene/effects/view_3d/camera_path.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>

#include "acus/base/config/json_file.h"
#include "acus/base/core/error.h"

namespace acus::effects {
namespace {

using nlohmann::json;

constexpr double kRadPerDeg = std::numbers::pi / 180.0;

Eigen::Array3d TripleOf(const json& values) {
  return {values[0].get<double>(), values[1].get<double>(), values[2].get<double>()};
}

}  // namespace

CameraPath CameraPath::Read(const std::filesystem::path& path) {
  const json object = config::ReadConfig(path, "acus-camera-path");
  CameraPath out;
  out.repeat_ = object.at("repeat");
  out.around_ = object.at("keys").front().contains("azimuth_deg");
  for (const json& key : object.at("keys")) {
    const std::string where = Message(path.string(), ": /keys/", out.keys_.size());
    const bool has_eye = key.contains("eye_mm") && key.contains("focus_mm");
    const bool has_part = key.contains("eye_mm") || key.contains("focus_mm");
    ACUS_REQUIRE(key.contains("azimuth_deg") ? !has_part : has_eye, where,
                 ": give eye_mm and focus_mm, or azimuth_deg, and not both");
    ACUS_REQUIRE(key.contains("azimuth_deg") == out.around_, where, ": the first key has ",
                 out.around_ ? "azimuth_deg" : "eye_mm and focus_mm",
                 "; all keys of a path have the same");
    Key read{.time_s = key.at("time_s")};
    ACUS_REQUIRE(out.keys_.empty() || read.time_s > out.keys_.back().time_s, where,
                 "/time_s: ", read.time_s, " s is not after the key before it; times must rise");
    if (out.around_) {
      read.values.head<3>() << key.at("azimuth_deg").get<double>(),
          key.at("elevation_deg").get<double>(), key.at("distance").get<double>();
    } else {
      read.values << TripleOf(key.at("eye_mm")), TripleOf(key.at("focus_mm")),
          TripleOf(key.at("up")), 0.0;
    }
    read.values[kNumValues - 1] = key.at("view_angle_deg");
    out.keys_.push_back(read);
  }
  return out;
}

CameraPath::Values CameraPath::SlopeAt(std::size_t key) const {
  const std::size_t before = key == 0 ? 0 : key - 1;
  const std::size_t after = std::min(key + 1, keys_.size() - 1);
  return (keys_[after].values - keys_[before].values) /
         (keys_[after].time_s - keys_[before].time_s);
}

CameraPath::Values CameraPath::ValuesAt(double time_s) const {
  const double first_s = keys_.front().time_s;
  const double span_s = keys_.back().time_s - first_s;
  if (repeat_ && span_s > 0.0 && time_s > first_s) {
    time_s = first_s + std::fmod(time_s - first_s, span_s);
  }
  if (!(time_s > first_s)) return keys_.front().values;
  if (time_s >= keys_.back().time_s) return keys_.back().values;
  const auto next = std::ranges::upper_bound(keys_, time_s, {}, &Key::time_s);
  const auto n = static_cast<std::size_t>(next - keys_.begin());
  const Key& a = keys_[n - 1];
  const Key& b = keys_[n];
  const double piece_s = b.time_s - a.time_s;
  const double t = (time_s - a.time_s) / piece_s;
  const double t2 = t * t;
  const double t3 = t2 * t;
  return (2.0 * t3 - 3.0 * t2 + 1.0) * a.values + (t3 - 2.0 * t2 + t) * piece_s * SlopeAt(n - 1) +
         (3.0 * t2 - 2.0 * t3) * b.values + (t3 - t2) * piece_s * SlopeAt(n);
}

volume_rendering::Viewpoint CameraPath::At(double session_s,
                                           const Eigen::AlignedBox3d& box_in_ct_mm,
                                           const volume_rendering::ImageSize& size) const {
  const Values values = ValuesAt(session_s);
  volume_rendering::Viewpoint out;
  // A cubic curve may overshoot its keys.
  out.view_angle_deg = std::clamp(values[kNumValues - 1], 1.0, 120.0);
  if (!around_) {
    out.eye_in_ct_mm = values.segment<3>(0);
    out.focus_in_ct_mm = values.segment<3>(3);
    out.up_in_ct = values.segment<3>(6);
    return out;
  }
  const double azimuth = kRadPerDeg * values[0];
  const double elevation = kRadPerDeg * std::clamp(values[1], -89.0, 89.0);
  const double half_height = std::tan(0.5 * kRadPerDeg * out.view_angle_deg);
  const double half_width = half_height * size.width_px / size.height_px;
  const double half_angle = std::atan(std::min(half_height, half_width));
  const double distance_mm =
      std::max(0.05, values[2]) * 0.5 * box_in_ct_mm.diagonal().norm() / std::sin(half_angle);
  out.focus_in_ct_mm = box_in_ct_mm.center();
  out.eye_in_ct_mm =
      out.focus_in_ct_mm + distance_mm * Eigen::Vector3d(std::cos(elevation) * std::sin(azimuth),
                                                         -std::cos(elevation) * std::cos(azimuth),
                                                         std::sin(elevation));
  return out;
}

}  // namespace acus::effects
