#include "acus/patient/phantom/anatomy/phantom_config.h"

#include <cmath>
#include <map>
#include <set>

#include "acus/base/config/json_file.h"
#include "acus/base/math/angles.h"
#include "acus/data/volume/labels.h"

namespace acus::phantom {
namespace {

using Eigen::Vector3d;
using Json = nlohmann::json;

double Number(const Json& object, const char* key) {
  return object.at(key).get<double>();
}
double Angle(const Json& object, const char* key) {
  return math::kRadPerDegree * Number(object, key);
}

Vector3d Vector(const Json& object, const char* key) {
  const Json& v = object.at(key);
  return {v.at(0).get<double>(), v.at(1).get<double>(), v.at(2).get<double>()};
}

volume::Geometry ReadGrid(const Json& grid, const std::string& file) {
  volume::Geometry g;
  g.origin_mm = Vector(grid, "first_voxel_mm");
  g.spacing_mm = Vector(grid, "spacing_mm").array();
  for (int axis = 0; axis < 3; ++axis) g.size[axis] = grid.at("size").at(axis).get<int>();
  constexpr std::size_t kMaxVoxels = 120'000'000;
  ACUS_REQUIRE(g.num_voxels() <= kMaxVoxels, file, ": /grid/size: ", g.num_voxels(),
               " voxels; at most ", kMaxVoxels, " are allowed");
  return g;
}

BodySettings ReadBody(const Json& body) {
  BodySettings b;
  b.scale = Number(body, "scale");
  b.variation_percent = Number(body, "variation_percent");
  b.skin_mm = Number(body, "skin_mm");
  b.subcutaneous_fat_mm = Number(body, "subcutaneous_fat_mm");
  b.interlaminar_gap_mm = Number(body, "interlaminar_gap_mm");
  b.cortical_bone_mm = Number(body, "cortical_bone_mm");
  b.lesion_centre_mm = Vector(body, "lesion_centre_mm");
  b.lesion_radius_mm = Number(body, "lesion_radius_mm");
  b.bile_duct_mm = Number(body, "bile_duct_mm");
  b.liver_cyst_mm = Number(body, "liver_cyst_mm");
  b.renal_pelvis_mm = Number(body, "renal_pelvis_mm");
  if (body.at("region") == "shoulder") b.region = BodySettings::Region::kShoulder;
  const Json& shoulder = body.at("shoulder");
  b.shoulder = {Number(shoulder, "deltoid_mm"), Number(shoulder, "bursa_mm"),
                Number(shoulder, "calcification_mm"), Number(shoulder, "tear_mm")};
  return b;
}

ScannerSettings ReadScanner(const Json& scanner) {
  ScannerSettings s;
  s.supersampling = scanner.at("supersampling").get<int>();
  s.psf_sigma_mm = Number(scanner, "psf_sigma_mm");
  s.noise_sd_hu = Number(scanner, "noise_sd_hu");
  for (int m = 0; m < kNumMaterials; ++m) {
    s.hu[m] = scanner.at("hu").at(std::string(Materials()[m].name)).get<double>();
  }
  return s;
}

MarkerSettings ReadMarkers(const Json& markers) {
  MarkerSettings m;
  m.count = markers.at("count").get<int>();
  m.radius_mm = Number(markers, "radius_mm");
  m.fle_mm = Number(markers, "fle_mm");
  const Json& pose = markers.at("reference_from_ct");
  const Vector3d turn = math::kRadPerDegree * Vector(pose, "rotation_deg");
  m.reference_from_ct.linear() = (Eigen::AngleAxisd(turn.z(), Vector3d::UnitZ()) *
                                  Eigen::AngleAxisd(turn.y(), Vector3d::UnitY()) *
                                  Eigen::AngleAxisd(turn.x(), Vector3d::UnitX()))
                                     .toRotationMatrix();
  m.reference_from_ct.translation() = Vector(pose, "translation_mm");
  return m;
}

PlanSettings ReadInsertion(const Json& insertion, const std::string& file) {
  PlanSettings p;
  p.target = insertion.at("target").get<std::string>();
  p.offset_mm = Vector(insertion, "offset_mm");
  const Vector3d approach = Vector(insertion, "approach");
  ACUS_REQUIRE(approach.norm() > 0.01, file,
               ": /insertion/approach: a direction is needed, not (0, 0, 0)");
  p.approach = approach.normalized();
  p.image_axis = Vector(insertion, "image_axis");
  p.cone_rad = Angle(insertion, "cone_deg");
  for (const Json& name : insertion.at("avoid"))
    p.avoid.push_back(volume::LabelOf(name.get<std::string>()));
  p.clearance_mm = Number(insertion, "clearance_mm");
  p.min_length_mm = Number(insertion, "min_length_mm");
  p.max_length_mm = Number(insertion, "max_length_mm");
  ACUS_REQUIRE(p.min_length_mm <= p.max_length_mm, file, ": /insertion: min_length_mm ",
               p.min_length_mm, " is above max_length_mm ", p.max_length_mm);
  return p;
}

NeedleMove ReadMove(const Json& move) {
  static const std::map<std::string, NeedleMove::To> kTo = {{"start", NeedleMove::To::kStart},
                                                            {"skin", NeedleMove::To::kSkin},
                                                            {"bone", NeedleMove::To::kBone},
                                                            {"target", NeedleMove::To::kTarget},
                                                            {"depth", NeedleMove::To::kDepth}};
  return {kTo.at(move.at("to").get<std::string>()), Number(move, "depth_mm"),
          move.at("aim") == "bone" ? NeedleMove::Aim::kBone : NeedleMove::Aim::kTarget,
          Number(move, "speed_mm_per_s"), Number(move, "hold_s")};
}

SessionSettings ReadSession(const Json& session, const std::string& file) {
  SessionSettings s;
  s.name = session.at("name").get<std::string>();
  s.standoff_mm = Number(session, "standoff_mm");
  s.bone_press_mm = Number(session, "bone_press_mm");
  s.turn_rad_per_s = Angle(session, "turn_deg_per_s");
  for (const Json& move : session.at("needle")) s.needle.push_back(ReadMove(move));
  for (const Json& demonstration : session.at("demonstrations")) {
    s.demonstrations.push_back({demonstration.at("exercise").get<std::string>(),
                                Number(demonstration, "plunger_n"),
                                Number(demonstration, "hold_s")});
  }
  const Json& probe = session.at("probe");
  s.probe = {Number(probe, "lift_mm"), Number(probe, "land_s"),         Number(probe, "sweep_mm"),
             Number(probe, "sweep_s"), Number(probe, "ahead_mm"),       Angle(probe, "toe_deg"),
             Number(probe, "gap_mm"),  Number(probe, "out_of_plane_mm")};
  const Json& tremor = session.at("tremor");
  s.tremor = {Number(tremor, "needle_mm"),      Angle(tremor, "needle_deg"),
              Number(tremor, "tissue_damping"), Number(tremor, "probe_mm"),
              Angle(tremor, "probe_deg"),       Number(tremor, "low_hz"),
              Number(tremor, "high_hz"),        Number(tremor, "wander_mm")};
  ACUS_REQUIRE(s.tremor.low_hz < s.tremor.high_hz, file, ": /session/tremor: low_hz ",
               s.tremor.low_hz, " must be below high_hz ", s.tremor.high_hz);
  return s;
}

ForceCurveSettings ReadForceCurve(const Json& curve) {
  ForceCurveSettings c;
  c.name = curve.at("name").get<std::string>();
  c.count = curve.at("count").get<int>();
  c.spread_percent = Number(curve, "spread_percent");
  c.noise_n = Number(curve, "noise_n");
  forces::CurveParameters& p = c.parameters;
  p.contact_depth_mm = Number(curve, "contact_depth_mm");
  p.a1_n_per_mm = Number(curve, "a1_n_per_mm");
  p.a2_n_per_mm2 = Number(curve, "a2_n_per_mm2");
  p.puncture_depth_mm = Number(curve, "puncture_depth_mm");
  p.plateau_n = Number(curve, "plateau_n");
  p.plateau_slope_n_per_mm = Number(curve, "plateau_slope_n_per_mm");
  p.friction_n_per_mm = Number(curve, "friction_n_per_mm");
  p.relaxation_fraction = Number(curve, "relaxation_fraction");
  p.relaxation_time_s = Number(curve, "relaxation_time_s");
  p.offset_n = Number(curve, "offset_n");
  c.drive.rate_hz = Number(curve, "rate_hz");
  c.drive.advance_mm_per_s = Number(curve, "advance_mm_per_s");
  c.drive.retract_mm_per_s = Number(curve, "retract_mm_per_s");
  c.drive.end_depth_mm = Number(curve, "end_depth_mm");
  c.drive.hold_s = Number(curve, "hold_s");
  return c;
}

}  // namespace

PhantomConfig ReadPhantomConfig(const std::filesystem::path& path) {
  PhantomConfig config;
  config.document = config::ReadConfig(path, "acus-phantom");
  const Json& d = config.document;
  const std::string file = path.string();
  config.grid = ReadGrid(d.at("grid"), file);
  config.body = ReadBody(d.at("body"));
  config.scanner = ReadScanner(d.at("scanner"));
  config.markers = ReadMarkers(d.at("markers"));
  config.insertion = ReadInsertion(d.at("insertion"), file);
  config.session = ReadSession(d.at("session"), file);
  std::set<std::string> names;
  for (const Json& curve : d.at("force_curves")) {
    config.force_curves.push_back(ReadForceCurve(curve));
    const std::string& name = config.force_curves.back().name;
    ACUS_REQUIRE(names.insert(name).second, file, ": /force_curves: two are named '", name,
                 "'; each needs a name of its own, it becomes the file's");
  }
  return config;
}

}  // namespace acus::phantom
