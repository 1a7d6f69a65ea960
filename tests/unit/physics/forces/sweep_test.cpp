// A fast hand or a low rate meets what a slow hand meets: every layer, in order, where it is.
#include <cstring>
#include <gmock/gmock.h>

#include "acus/physics/forces/models/force_model.h"
#include "layered_body.h"
#include "support/force_scenes.h"

namespace acus::forces {
namespace {

using testing_support::Trocar18G;
using volume::LabelOf;

/// Layers across z in voxels of 0.5 mm, 10 mm of air in front, 80 mm of tissue; and the same as HU.
struct SweptBody {
  struct Layer {
    double from_mm;
    const char* tissue;
    std::int16_t hu;
  };
  explicit SweptBody(const std::vector<Layer>& layers) {
    volume::Geometry geometry;
    geometry.size = {41, 41, 181};
    geometry.spacing_mm = {0.5, 0.5, 0.5};
    geometry.origin_mm = {-10.0, -10.0, -9.75};  // Voxels end at multiples of 0.5 mm.
    labels = volume::LabelMap(geometry, 0);
    ct = volume::CtVolume(geometry, -1000);
    for (int k = 0; k < geometry.size[2]; ++k) {
      const double z_mm = geometry.origin_mm[2] + 0.5 * k;
      for (const Layer& layer : layers) {
        if (z_mm < layer.from_mm) continue;
        const std::size_t slice = labels.geometry.Index(0, 0, k);
        const std::size_t size = 41 * 41;
        std::fill_n(labels.voxels.begin() + static_cast<std::ptrdiff_t>(slice), size,
                    LabelOf(layer.tissue));
        std::fill_n(ct.voxels.begin() + static_cast<std::ptrdiff_t>(slice), size, layer.hu);
      }
    }
  }
  volume::LabelMap labels;
  volume::CtVolume ct;
};

/// Skin, fat, a sheet of 0.5 mm as a membrane, muscle, a vessel with a wall, liver, a thin plate of
/// bone, lung.
SweptBody ThinLayers() {
  return SweptBody({{0.0, "skin", 50},
                    {2.0, "fat", -100},
                    {12.0, "spleen", 60},
                    {12.5, "fat", -100},
                    {26.0, "vessel", 200},
                    {26.5, "lesion", 60},
                    {29.0, "vessel", 200},
                    {29.5, "fat", -100},
                    {45.0, "bone", 900},
                    {46.0, "lung", -700}});
}

/// Tissues that do not relax: a slow needle punctures them where a fast one does.
ForceTable Table(const char* name = "bovine_2021.json") {
  return ReadForceTable(kConfigs / "forces" / name);
}

struct Driver {
  explicit Driver(const ForceModel& of_model, const volume::LabelMap& labels)
      : model(of_model), lookup(labels), state(of_model.NewState()) {}

  NeedleForce To(double z_mm, double time_s) {
    const Eigen::Vector3d tip_mm(0.0, 0.0, z_mm);
    const NeedleForce force =
        model.StepAlong(state, {time_s, tip_mm, Eigen::Vector3d::UnitZ(), lookup.At(tip_mm), true},
                        {&lookup}, passed);
    for (int i = 0; i < passed.num; ++i) all.push_back(passed.event[static_cast<std::size_t>(i)]);
    return force;
  }
  /// From 3 mm in front of the skin to `end_mm` and out again.
  void InAndOut(double end_mm, double speed_mm_per_s, double dt_s) {
    const int steps = static_cast<int>(std::ceil((end_mm + 3.0) / (speed_mm_per_s * dt_s)));
    const double step_mm = (end_mm + 3.0) / steps;
    double t = 0.0;
    To(-3.0, t);
    for (int i = 1; i <= steps; ++i) To(-3.0 + i * step_mm, t += dt_s);
    for (int i = steps - 1; i >= 0; --i) To(-3.0 + i * step_mm, t += dt_s);
  }

  const ForceModel& model;
  TissueLookup lookup;
  ForceState state;
  PassedEvents passed;
  std::vector<PassedEvent> all;
};

std::string Told(const std::vector<PassedEvent>& events) {
  std::string text;
  for (const PassedEvent& event : events) {
    char line[80];
    std::snprintf(line, sizeof line, "%s(%d) %.2f; ", std::string(NameOf(event.event)).c_str(),
                  event.tissue, event.depth_mm);
    text += line;
  }
  return text;
}

void ExpectSameEvents(const std::vector<PassedEvent>& slow, const std::vector<PassedEvent>& fast,
                      double within_mm) {
  ASSERT_EQ(fast.size(), slow.size()) << "slow: " << Told(slow) << "\nfast: " << Told(fast);
  for (std::size_t i = 0; i < slow.size(); ++i) {
    EXPECT_EQ(static_cast<int>(fast[i].event), static_cast<int>(slow[i].event))
        << i << "\nslow: " << Told(slow) << "\nfast: " << Told(fast);
    EXPECT_NEAR(fast[i].depth_mm, slow[i].depth_mm, within_mm)
        << i << ", " << NameOf(slow[i].event) << "\nslow: " << Told(slow)
        << "\nfast: " << Told(fast);
  }
}

class Swept : public testing::TestWithParam<const char*> {
 protected:
  ForceModel Model(const SweptBody& body) {
    const std::string name = GetParam();
    if (name == "alamilla") return ForceModel(AlamillaModel(Table("alamilla.json"), Trocar18G()));
    if (name == "vidal") {
      field_.emplace(body.ct);
      return ForceModel(VidalModel(Table("vidal.json"), Trocar18G(), *field_));
    }
    return ForceModel(NeedleForceModel(Table(), Trocar18G()));
  }

 private:
  std::optional<CtField> field_;
};

TEST_P(Swept, AFastHandMeetsWhatASlowOneMeetsInOrderAndWhereItIs) {
  const SweptBody body = ThinLayers();
  const ForceModel model = Model(body);
  Driver slow(model, body.labels);
  slow.InAndOut(60.0, 10.0, 0.001);  // 0.01 mm a step.
  ASSERT_GT(slow.all.size(), 6u) << Told(slow.all);
  for (const double dt_s : {0.0001, 0.001, 0.01}) {
    SCOPED_TRACE(dt_s);
    Driver fast(model, body.labels);
    fast.InAndOut(60.0, 1000.0, dt_s);
    ExpectSameEvents(slow.all, fast.all, 0.05);
  }
}

TEST_P(Swept, ASlowHandGetsTheBitsOfTheModelsStep) {
  const SweptBody body = ThinLayers();
  const ForceModel model = Model(body);
  Driver driver(model, body.labels);
  ForceState state = model.NewState();
  for (int i = 0; i < 60000; ++i) {
    const double phase = 0.00025 * i;
    const double z_mm = -1.0 + 60.0 * (0.5 - 0.5 * std::cos(phase));
    const Eigen::Vector3d tip_mm(0.0, 0.0, z_mm);
    const double t = 0.001 * i;
    const NeedleForce swept = driver.To(z_mm, t);
    const NeedleForce plain =
        model.Step(state, {t, tip_mm, Eigen::Vector3d::UnitZ(), driver.lookup.At(tip_mm), true});
    ASSERT_EQ(std::memcmp(&swept.force_in_ct_n, &plain.force_in_ct_n, sizeof plain.force_in_ct_n),
              0)
        << i;
    ASSERT_EQ(swept.event, plain.event);
  }
}

TEST_P(Swept, RepeatsAndStaysBounded) {
  const SweptBody body = ThinLayers();
  const ForceModel model = Model(body);
  Driver first(model, body.labels);
  Driver second(model, body.labels);
  first.all.reserve(1000);
  second.all.reserve(1000);
  for (int i = 0; i < 400; ++i) {
    const double z_mm = 30.0 + 35.0 * std::sin(0.7 * i);
    const NeedleForce a = first.To(z_mm, 0.01 * i);
    const NeedleForce b = second.To(z_mm, 0.01 * i);
    ASSERT_EQ(std::memcmp(&a.force_in_ct_n, &b.force_in_ct_n, sizeof a.force_in_ct_n), 0);
    ASSERT_TRUE(a.force_in_ct_n.allFinite());
    ASSERT_LE(a.force_in_ct_n.norm(), model.table().settings.largest_force_n * (1.0 + 1e-9));
  }
}

INSTANTIATE_TEST_SUITE_P(Models, Swept, testing::Values("layered", "alamilla", "vidal"));

TEST(SweptLayers, TheSkinAndTheCapsuleAreWhereTheyAreAndArePuncturedAfterTheirIndentation) {
  const SweptBody body({{0.0, "skin", 50}, {2.0, "fat", -100}, {21.0, "liver", 60}});
  const ForceTable table = Table();
  const ForceModel model(NeedleForceModel(table, Trocar18G()));
  const auto indentation_mm = [&](const char* tissue) {  // Of eq. 2, where it is its threshold.
    const PuncturePolynomial& law = model.table().tissue[LabelOf(tissue)].membrane;
    const double a1 = law.a1_n_per_mm;
    const double a2 = law.a2_n_per_mm2;
    return (-a1 + std::sqrt(a1 * a1 + 4.0 * a2 * law.puncture_n)) / (2.0 * a2);
  };
  for (const double speed : {10.0, 100.0, 1000.0}) {
    Driver driver(model, body.labels);
    const int steps = static_cast<int>(63.0 / (0.01 * speed));
    for (int i = 0; i <= steps; ++i) driver.To(-3.0 + 0.01 * speed * i, 0.01 * i);
    std::vector<double> punctures;
    std::vector<double> interfaces;
    for (const PassedEvent& event : driver.all) {
      if (event.event == NeedleEvent::kPuncture) punctures.push_back(event.depth_mm);
      if (event.event == NeedleEvent::kInterface) interfaces.push_back(event.depth_mm);
    }
    ASSERT_EQ(punctures.size(), 2u) << Told(driver.all);
    EXPECT_NEAR(punctures[0], indentation_mm("skin"), 0.05);
    EXPECT_NEAR(punctures[1], 21.0 + indentation_mm("liver"), 0.05);
    EXPECT_NEAR(interfaces.back(), 21.0 + table.settings.interface_hysteresis_mm, 0.05);
  }
}

TEST(SweptLayers, ATipThatWasNotSeenForLongIsNotSwept) {
  const SweptBody body = ThinLayers();
  const ForceModel model(NeedleForceModel(Table(), Trocar18G()));
  Driver driver(model, body.labels);
  driver.To(-3.0, 0.0);
  driver.To(80.0, 5.0);  // Five seconds later it is in air again, on the other side.
  for (const PassedEvent& event : driver.all) EXPECT_EQ(NameOf(event.event), "contact");
}

}  // namespace
}  // namespace acus::forces
