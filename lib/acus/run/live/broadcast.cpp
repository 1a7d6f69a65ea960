#include "acus/run/live/broadcast.h"

#include <vector>

#include "acus/imaging/acoustics/probe.h"

namespace acus::live {
namespace {

/// Receivers use the axes right, anterior, superior.
Eigen::Isometry3d RasFromCt() {
  Eigen::Isometry3d ras_from_ct = Eigen::Isometry3d::Identity();
  ras_from_ct.linear().diagonal() << -1.0, -1.0, 1.0;
  return ras_from_ct;
}

template <typename Scalar>
tracking::VolumeView ViewOf(const volume::Grid<Scalar>& grid) {
  const auto& size = grid.geometry.size;
  return {.size = {size[0], size[1], size[2]},
          .voxels = std::span<const Scalar>(grid.voxels),
          .ras_from_voxel = RasFromCt().matrix() * grid.geometry.ct_from_index().matrix()};
}

tracking::PoseServerOptions OptionsOf(const SendOut& where) {
  tracking::PoseServerOptions options;
  options.host = where.host;
  options.port = where.port;
  return options;
}

}  // namespace

Broadcast::Broadcast(const SendOut& where, const simulation::Scene& scene,
                     const transforms::Landmarks& targets, bool has_probe)
    : scene_(scene), has_probe_(has_probe), server_(OptionsOf(where)) {
  const Eigen::Isometry3d ras_from_ct = RasFromCt();
  server_.KeepPose(
      {.name = "ReferenceToRas",
       .reference_from_tool = Eigen::Isometry3d(ras_from_ct * scene.ct_from_reference)});
  std::vector<tracking::NamedPoint> points;
  for (std::size_t i = 0; i < targets.names.size(); ++i) {
    points.push_back(
        {.name = targets.names[i],
         .ras_mm = ras_from_ct * targets.points_mm.col(static_cast<Eigen::Index>(i)).eval()});
  }
  if (!points.empty()) {
    server_.KeepPoints("Targets", points);
    server_.KeepPose(
        {.name = "TargetToRas",
         .reference_from_tool = Eigen::Isometry3d(Eigen::Translation3d(points.back().ras_mm))});
  }
  if (scene.ct) server_.KeepVolume("CT", ViewOf(*scene.ct));
  if (scene.labels) server_.KeepVolume("Labels", ViewOf<volume::Label>(*scene.labels));
  server_.Start();
}

void Broadcast::Send(const LiveImage& image) {
  if (server_.status().clients == 0) return;
  const Eigen::Isometry3d reference_from_ct = scene_.ct_from_reference.inverse();
  const simulation::Snapshot& moment = image.snapshot.moment;
  std::vector<tracking::NamedPose> poses;
  if (has_probe_) {
    poses.push_back(
        {.name = "ProbeToReference",
         .reference_from_tool = Eigen::Isometry3d(reference_from_ct * moment.ct_from_probe),
         .valid = moment.probe_valid});
  }
  if (moment.ct_from_needle) {
    poses.push_back(
        {.name = "NeedleToReference",
         .reference_from_tool = Eigen::Isometry3d(reference_from_ct * *moment.ct_from_needle),
         .valid = true});
  }
  server_.SendPoses(poses, image.snapshot.measured_ns);
  const image::GrayImage& b_mode = image.images.b_mode;
  if (b_mode.pixels.empty()) return;
  tracking::Image out{
      .width = b_mode.width, .height = b_mode.height, .channels = 1, .pixels = b_mode.pixels};
  out.reference_from_pixel = reference_from_ct.matrix() * moment.ct_from_probe.matrix() *
                             acoustics::ImageOf(*image.probe).probe_from_image().matrix();
  server_.SendImage("Ultrasound", out, image.snapshot.measured_ns);
}

void Broadcast::SetStatus(bool is_ok, const std::string& text) {
  const std::string status = (is_ok ? "ok " : "not ok ") + text;
  if (status == status_) return;
  status_ = status;
  server_.SetStatus(is_ok, text);
}

void RequirePortFree(const SendOut& where) {
  tracking::PoseServer(OptionsOf(where)).Start();
}

}  // namespace acus::live
