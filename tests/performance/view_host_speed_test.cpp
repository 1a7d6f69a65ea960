// What an image on a graphics card costs the processor: the moment's description, without the
// driver.
#include <algorithm>
#include <cstdio>
#include <gtest/gtest.h>

#include "acus/base/core/cpu_time.h"
#include "acus/imaging/volume_rendering/patient_view.h"
#include "support/paired_times.h"
#include "support/trunk_ct.h"
#include "support/view_scenes.h"
#include "support/wound_sheet.h"

namespace acus::volume_rendering {
namespace {

constexpr int kVertices = 430'578;  // Fortmeier-2016, section 4.4.

/// Draws nothing.
class NullDevice final : public RayDevice {
 public:
  std::string name() const override { return "nothing"; }
  void Load(const VolumeScene&, const breathing::MotionField*) override {}
  void Render(const VolumeScene&, const DeviceImage& image, std::span<std::uint8_t>,
              std::span<std::uint8_t>) override {
    for (const Drawing& drawing : image.drawings) nodes += drawing.nodes_mm->cols();
  }
  std::uint64_t bytes_sent() const override { return 0; }

  Eigen::Index nodes = 0;
};

TEST(ViewHostSpeed, AnImageOnADeviceCostsTheProcessorLittle) {
  const auto field = testing_support::FieldOf(testing_support::DiaphragmMm, 128, 3, 400.0);
  PatientInView patient;
  patient.ct = testing_support::TrunkCt(256);
  patient.layers = {{"skin", 1.0}};
  patient.surfaces = {{"sheet", testing_support::WoundSheet(kVertices), {0.8F, 0.3F, 0.3F}, 0.5}};
  patient.field = &field;
  PatientView view(std::move(patient), {});
  auto device = std::make_unique<NullDevice>();
  const NullDevice& nothing = *device;
  view.UseDevice(std::move(device));
  const ImageSize size{1224, 1014};
  const Camera camera = LookAt(ViewFrom("oblique", view.box_in_ct_mm(), size), size);
  const acoustics::Probe probe = acoustics::DefaultProbe();
  ViewMoment moment;
  moment.needle = image::NeedleInImage{{0, 0, 0}, Eigen::Vector3d::UnitY(), 150.0, 0.6};
  moment.probe.emplace();
  moment.probe->probe = &probe;
  moment.probe->ct_from_probe.translation() << 10, -130, 20;
  ViewImage image;
  double best_ms = 1e9;
  int instant = 0;
  const auto measure = [&] {
    breathing::MotionWeights weights;
    for (int n = 0; n < 3; ++n) weights.Add(n, 0.3 + 0.001 * ++instant);
    const breathing::MotionMap motion(field, weights);
    moment.motion = &motion;
    const double begin_s = ThreadCpuSeconds();
    view.Render(camera, moment, image, 1);
    best_ms = std::min(best_ms, 1e3 * (ThreadCpuSeconds() - begin_s));
  };
  testing_support::MeasureUntil(5, 60, measure, [&] { return best_ms < 1.5; });
  std::printf("  %.2f ms of the processor per image\n", best_ms);
  EXPECT_GT(nothing.nodes, kVertices);
  EXPECT_LT(best_ms, 1.5);
}

}  // namespace
}  // namespace acus::volume_rendering
