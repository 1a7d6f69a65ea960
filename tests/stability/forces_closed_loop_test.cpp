// Force models in the loop with a device and a hand: none drives the hand, none buzzes, but for the
// direct method, which shows that the observer sees it.
#include <cstdio>
#include <gmock/gmock.h>

#include "acus/physics/forces/laws/force_laws.h"
#include "support/bound.h"
#include "support/force_scenes.h"

namespace acus::forces {
namespace {

using testing_support::Abdomen;
using testing_support::Above;
using testing_support::AtMost;
using testing_support::Below;
using testing_support::BoundPlot;
using testing_support::DrivenAlamilla;
using testing_support::DrivenLayered;
using testing_support::DrivenMeasured;
using testing_support::DrivenPalpation;
using testing_support::DrivenProbe;
using testing_support::DrivenVidal;
using testing_support::FieldsOf;
using testing_support::HardCase;
using testing_support::Largest;
using testing_support::LayeredBodyField;
using testing_support::ShippedTable;
using testing_support::Trocar18G;

constexpr double kDuration = 60.0;

struct Report {
  double worst_mj = 0.0;
  double least_taken_mj = 1e300;
};

/// 60 s at random, for three hands.
template <typename MakeLoop>
Report RandomInteraction(const char* name, const RandomHand& motion, MakeLoop make_loop) {
  Report report;
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    Hand hand;
    hand.wants_in_ct_mm = RandomMotion(motion, kDuration, seed);
    auto driven = make_loop();
    const LoopResult result = RunClosedLoop({}, hand, driven.Loop(), kDuration);
    report.worst_mj = std::max(report.worst_mj, result.generated_mj);
    report.least_taken_mj = std::min(report.least_taken_mj, result.taken_mj);
    std::printf("  %-22s hand %d: generated %.4f mJ, took %.1f mJ, chatter %.3f N\n", name,
                static_cast<int>(seed), result.generated_mj, result.taken_mj,
                result.ChatterN(1.0, kDuration));
  }
  return report;
}

void ExpectPassive(const HardCase& hard, const std::string& name, const Report& report) {
  hard.Expect("energy generated, " + name, report.worst_mj, AtMost(1.0), "mJ");
  hard.Expect("energy taken, " + name, report.least_taken_mj, Above(1.0), "mJ");
}

TEST(ForcesClosedLoop, NoShippedModelGeneratesEnergy) {
  const HardCase hard(
      "Encoder steps and a late force, a hand at random for a minute, three times.");
  const LayeredBodyField body = Abdomen();
  for (const char* table : {"default.json", "viscoelastic.json", "alamilla.json", "vidal.json"}) {
    std::printf(" %s\n", table);
    const NeedleForceModel layered(ShippedTable(table), Trocar18G());
    const AlamillaModel alamilla(ShippedTable(table), Trocar18G());
    const VidalModel vidal(ShippedTable(table), Trocar18G(), body);
    const Report a = RandomInteraction("layered", {}, [&] { return DrivenLayered{layered, body}; });
    const std::string in = Message(" in ", table);
    ExpectPassive(hard, "layered" + in, a);
    const Report b = RandomInteraction("alamilla", {}, [&] {
      return DrivenAlamilla{alamilla, body};
    });
    ExpectPassive(hard, "alamilla" + in, b);
    const Report c = RandomInteraction("vidal", {}, [&] { return DrivenVidal{vidal, body}; });
    ExpectPassive(hard, "vidal" + in, c);
  }
}

// Forces as recorded: profiles that rise, and membranes that rise within a millimetre.
TEST(ForcesClosedLoop, MeasuredForcesGenerateNoEnergy) {
  const HardCase hard(
      "Resistance that changes with the depth could pay for a way back; every recording has "
      "others.");
  const LayeredBodyField body = Abdomen();
  const MeasuredForces liver = ReadMeasuredForces(std::filesystem::path(ACUS_SOURCE_DIR) /
                                                  "configs/measured/human_liver.json");
  const ForceTable table = ShippedTable("default.json");
  for (const char* name : {"mean", "Data0", "Data14", "Data36"}) {
    const MeasuredModel model(table, Trocar18G(), liver.Law(name), liver.needle_diameter_mm);
    const Report report = RandomInteraction(name, {}, [&] { return DrivenMeasured{model, body}; });
    ExpectPassive(hard, Message("measured, ", name), report);
  }
}

// Every guidance with every force along the needle. A hand that bears against its path by up to 8
// mm.
TEST(ForcesClosedLoop, NoGuidanceGeneratesEnergy) {
  const HardCase hard("A hand that bears against its guidance by up to 8 mm.");
  const LayeredBodyField body = Abdomen();
  const ForceTable table = ShippedTable("default.json");
  RandomHand motion;
  motion.across_mm = 8.0;
  for (const auto& [name, kind] :
       {std::pair{"none", GuidanceKind::kNone}, std::pair{"vidal", GuidanceKind::kVidal},
        std::pair{"virtual fixture", GuidanceKind::kVirtualFixture}}) {
    std::printf(" guidance %s\n", name);
    const NeedleForceModel layered(table, Trocar18G(), kind);
    const AlamillaModel alamilla(table, Trocar18G(), kind);
    const VidalModel vidal(table, Trocar18G(), body, kind);
    const auto check = [&](const char* model, auto make) {
      hard.Expect(Message("energy generated, ", model, ", guidance ", name),
                  RandomInteraction(model, motion, make).worst_mj, AtMost(1.0), "mJ");
    };
    check("layered", [&] { return DrivenLayered{layered, body}; });
    check("alamilla", [&] { return DrivenAlamilla{alamilla, body}; });
    check("vidal", [&] { return DrivenVidal{vidal, body}; });
  }
}

// The shaft is drawn out with less friction than it is pushed in, or with more.
TEST(ForcesClosedLoop, WithdrawalFrictionOfItsOwnGeneratesNoEnergy) {
  const HardCase hard("Friction that is another on the way out could pay for a way in.");
  const LayeredBodyField body = Abdomen();
  for (const double share : {0.0, 0.65, 2.0}) {
    ForceTable table = ShippedTable("default.json");
    for (TissueForce& tissue : table.tissue) {
      tissue.withdrawal_friction_n_per_mm = share * tissue.friction_n_per_mm;
    }
    const NeedleForceModel layered(table, Trocar18G());
    const Report report = RandomInteraction("layered", {}, [&] {
      return DrivenLayered{layered, body};
    });
    hard.Expect(Message("energy generated, friction out ", share, " times that in"),
                report.worst_mj, AtMost(1.0), "mJ");
  }
}

TEST(ForcesClosedLoop, TheProbeGeneratesNoEnergy) {
  const HardCase hard("A probe pressed on fat and bone, at random.");
  const LayeredBodyField body({{0.0, "fat", -100}, {8.0, "bone", 900}});
  const VidalProbe probe(ShippedTable("vidal.json"), body);
  RandomHand motion;
  motion.to_mm = 20.0;
  motion.across_mm = 30.0;
  const Report report = RandomInteraction("probe", motion, [&] { return DrivenProbe{probe}; });
  hard.Expect("energy generated", report.worst_mj, AtMost(1.0), "mJ");
}

TEST(ForcesClosedLoop, ManyProxiesGenerateNoEnergy) {
  const HardCase hard("Up to 16 proxies, each with a stop of its own, tilted or not.");
  const LayeredBodyField body({{0.0, "fat", -100}, {8.0, "bone", 900}});
  const ForceTable table = ShippedTable("vidal.json");
  RandomHand motion;
  motion.to_mm = 20.0;
  motion.across_mm = 30.0;
  for (const double tilt_rad : {0.0, 0.3}) {
    for (const auto& [name, tool] :
         {std::pair{"face, 16 proxies", ProbeFaceNodes(40.0, 12.0, 0.0, 16)},
          std::pair{"fingertip, 9 proxies", FingertipNodes(8.0, 9)}}) {
      const MultiProxyProbe model(table, tool, FieldsOf(table, body));
      const Report report = RandomInteraction(name, motion, [&] {
        DrivenPalpation driven{model};
        driven.ct_from_tool_turn =
            Eigen::AngleAxisd(tilt_rad, Eigen::Vector3d(1, 1, 0).normalized()) *
            DrivenPalpation::BeamAlongZ();
        return driven;
      });
      hard.Expect(Message("energy generated, ", name, ", tilt ", tilt_rad), report.worst_mj,
                  AtMost(1.0), "mJ");
    }
  }
}

/// A hand that goes in to `to_mm` within `in_s` and then stays there.
Hand GoesTo(double to_mm, double in_s, double from_mm = -2.0) {
  Hand hand;
  hand.wants_in_ct_mm = [=](double t) {
    const double s = std::clamp(t / in_s, 0.0, 1.0);
    const double share = s * s * s * (10.0 + s * (-15.0 + 6.0 * s));
    return Eigen::Vector3d(0.0, 0.0, from_mm + share * (to_mm - from_mm));
  };
  return hand;
}

// Alamilla-2021 fig. 14 against fig. 15: a hand that rests on a wall of 1 N with less than 1 N.
TEST(ForcesClosedLoop, TheDirectMethodChattersAndTheTrackingWallDoesNot) {
  const HardCase hard(
      "A hand that rests on a wall of 1 N with less than 1 N: it is thrown off, or held.");
  const Hand hand = GoesTo(1.5, 1.0);
  const LoopResult direct = RunClosedLoop(
      {}, hand,
      [](double, const Eigen::Vector3d& tip_mm) {
        return Eigen::Vector3d(0.0, 0.0, -DirectMethodN(tip_mm.z(), 1.0));
      },
      20.0);
  TrackingWall wall;
  const LoopResult tracking = RunClosedLoop(
      {}, hand,
      [&wall](double, const Eigen::Vector3d& tip_mm) {
        const double force_n =
            tip_mm.z() > 0.0 ? wall.AdvanceBothWays(tip_mm.z(), 1.0, 0.0, 0.25) : 0.0;
        return Eigen::Vector3d(0.0, 0.0, -force_n);
      },
      20.0);
  BoundPlot plot{.title = "Force of a wall of 1 N on a hand that rests on it",
                 .x_label = "time [s]",
                 .y_label = "force [N]"};
  for (const auto& [name, result] :
       {std::pair{"direct method", &direct}, std::pair{"tracking wall", &tracking}}) {
    plot.curves.push_back({.name = name});
    for (const LoopSample& sample : result->samples) {
      if (sample.time_s > 2.0 && sample.time_s < 2.5) {
        plot.curves.back().Add(sample.time_s, -sample.force_n.z());
      }
    }
  }
  hard.Plot(plot);
  std::printf("  direct method: chatter %.3f N, swing %.3f mm, generated %.2f mJ\n",
              direct.ChatterN(2.0, 20.0), direct.SwingMm(2.0, 20.0), direct.generated_mj);
  std::printf("  tracking wall: chatter %.5f N, swing %.5f mm, generated %.4f mJ\n",
              tracking.ChatterN(2.0, 20.0), tracking.SwingMm(2.0, 20.0), tracking.generated_mj);
  hard.Expect("chatter of the direct method, which is seen", direct.ChatterN(2.0, 20.0), Above(0.2),
              "N");
  hard.Expect("swing of the direct method, which is seen", direct.SwingMm(2.0, 20.0), Above(0.1),
              "mm");
  hard.Expect("chatter of the tracking wall", tracking.ChatterN(2.0, 20.0), Below(0.002), "N");
  hard.Expect("swing of the tracking wall", tracking.SwingMm(2.0, 20.0), Below(0.02), "mm");
  hard.Expect("energy generated by the tracking wall", tracking.generated_mj, Below(0.01), "mJ");
}

// Vidal-2008: the mean as printed is a late spring; the passive one is not. The printed one shakes
// the hand at resistances of real tissue.
TEST(ForcesClosedLoop, VidalsMeanAsPrintedDrivesTheHand) {
  const HardCase hard("A mean over the last samples is a late spring: it can drive the hand.");
  const LayeredBodyField body = Abdomen();
  ForceTable table = ShippedTable("vidal.json");
  table.vidal.passive_average = false;
  const VidalModel printed(table, Trocar18G(), body);
  const VidalModel shipped(ShippedTable("vidal.json"), Trocar18G(), body);
  DrivenVidal printed_drive{printed, body};
  DrivenVidal shipped_drive{shipped, body};
  const Hand hand = GoesTo(30.0, 4.0);
  const LoopResult shaking = RunClosedLoop({}, hand, printed_drive.Loop(), 5.0);
  const LoopResult quiet = RunClosedLoop({}, hand, shipped_drive.Loop(), 5.0);
  std::printf("  printed mean: chatter %.2f N, generated %.1f mJ; passive mean: %.4f N, %.4f mJ\n",
              shaking.ChatterN(1.0, 5.0), shaking.generated_mj, quiet.ChatterN(1.0, 5.0),
              quiet.generated_mj);
  hard.Expect("chatter of the printed mean, which is seen", shaking.ChatterN(1.0, 5.0), Above(0.5),
              "N");
  hard.Expect("chatter of the shipped mean", quiet.ChatterN(1.0, 5.0), Below(0.1), "N");
  hard.Expect("energy generated by the shipped mean", quiet.generated_mj, AtMost(1.0), "mJ");
}

/// Bone under air: nothing but the bone could take energy. (The layered and the Alamilla models
/// then have no skin; Vidal's pierces it on the way.)
TEST(ForcesClosedLoop, BoneAloneGeneratesNoEnergyAndHasNoLimitCycle) {
  const HardCase hard(
      "Standing still on bone under air, devices of 50 to 300 g: nothing else damps.");
  const LayeredBodyField body({{0.0, "gas", -200}, {8.0, "bone", 900}});
  for (const double mass_kg : {0.05, 0.1, 0.3}) {
    HapticDevice device;
    device.mass_kg = mass_kg;
    RandomHand motion;
    motion.from_mm = 4.0;
    motion.to_mm = 16.0;
    motion.across_mm = 0.5;
    const auto check = [&](const char* name, auto make) {
      double generated_mj = 0.0;
      for (std::uint64_t seed = 1; seed <= 2; ++seed) {
        Hand hand;
        hand.wants_in_ct_mm = RandomMotion(motion, kDuration, seed);
        auto driven = make();
        generated_mj = std::max(generated_mj,
                                RunClosedLoop(device, hand, driven.Loop(), kDuration).generated_mj);
      }
      // Without any friction the encoder's own step of 0.02 mm is left; the dry friction of the
      // lightest devices brings it to rest.
      for (const double dry_friction_n : {0.0, 0.05}) {
        device.dry_friction_n = dry_friction_n;
        auto driven = make();
        const LoopResult held = RunClosedLoop(device, GoesTo(14.0, 2.0), driven.Loop(), 10.0);
        EXPECT_TRUE(driven.state.on_bone) << name;
        std::printf(
            "  %-9s %.2f kg, dry friction %.2f N: generated %.4f mJ, holding: swing %.4f mm, "
            "chatter %.4f N\n",
            name, mass_kg, dry_friction_n, generated_mj, held.SwingMm(6.0, 10.0),
            held.ChatterN(6.0, 10.0));
        const std::string of = Message(", ", name, ", ", 1e3 * mass_kg, " g");
        hard.Expect("energy generated" + of, generated_mj, AtMost(1.0), "mJ");
        hard.Expect(Message("swing", of, ", dry friction ", dry_friction_n, " N"),
                    held.SwingMm(6.0, 10.0), AtMost(dry_friction_n > 0.0 ? 1e-6 : 0.02), "mm");
      }
      device.dry_friction_n = 0.0;
    };
    const NeedleForceModel layered(ShippedTable("bovine_2021.json"), Trocar18G());
    const AlamillaModel alamilla(ShippedTable("alamilla.json"), Trocar18G());
    const VidalModel vidal(ShippedTable("vidal.json"), Trocar18G(), body);
    check("layered", [&] { return DrivenLayered{layered, body}; });
    check("alamilla", [&] { return DrivenAlamilla{alamilla, body}; });
    check("vidal", [&] { return DrivenVidal{vidal, body}; });
  }
}

// The skin's spring takes energy that bone could give: here it is soft, and bone right under it.
TEST(ForcesClosedLoop, OnTopOfBoneAProbeHasNoLimitCycle) {
  const HardCase hard("A probe held on bone right under soft skin, devices of 50 to 300 g.");
  const LayeredBodyField body({{0.0, "fat", -100}, {3.0, "bone", 900}});
  const ForceTable table = ShippedTable("vidal.json");
  const VidalProbe vidal(table, body);
  const MultiProxyProbe face(table, ProbeFaceNodes(40.0, 12.0, 0.0, 16), FieldsOf(table, body));
  const MultiProxyProbe finger(table, FingertipNodes(8.0, 16), FieldsOf(table, body));
  const auto check = [&](const char* name, auto make) {
    for (const double mass_kg : {0.05, 0.1, 0.3}) {
      for (const double dry_friction_n : {0.0, 0.05}) {
        HapticDevice device;
        device.mass_kg = mass_kg;
        device.dry_friction_n = dry_friction_n;
        auto driven = make();
        const LoopResult held = RunClosedLoop(device, GoesTo(16.0, 2.0), driven.Loop(), 10.0);
        EXPECT_TRUE(driven.last.on_bone) << name;
        EXPECT_EQ(driven.last.structure, volume::LabelOf("bone")) << name;
        std::printf("  %-9s %.2f kg, dry friction %.2f N: swing %.4f mm, chatter %.4f N\n", name,
                    mass_kg, dry_friction_n, held.SwingMm(6.0, 10.0), held.ChatterN(6.0, 10.0));
        hard.Expect(Message("swing, ", name, ", ", 1e3 * mass_kg, " g, dry friction ",
                            dry_friction_n, " N"),
                    held.SwingMm(6.0, 10.0), AtMost(dry_friction_n > 0.0 ? 1e-6 : 0.02), "mm");
      }
    }
  };
  check("vidal", [&] { return DrivenProbe{vidal}; });
  check("face", [&] { return DrivenPalpation{face}; });
  check("fingertip", [&] { return DrivenPalpation{finger}; });
}

TEST(ForcesClosedLoop, StandingStillInTissueThereIsNoLimitCycle) {
  const HardCase hard("Standing still in muscle: stick and slip could take turns for ever.");
  const LayeredBodyField body = Abdomen();
  const auto check = [&](const char* name, auto make) {
    for (const double dry_friction_n : {0.0, 0.05}) {
      HapticDevice device;
      device.dry_friction_n = dry_friction_n;
      auto driven = make();
      const LoopResult held = RunClosedLoop(device, GoesTo(25.0, 3.0), driven.Loop(), 12.0);
      std::printf("  %-9s in muscle, dry friction %.2f N: swing %.4f mm, chatter %.4f N\n", name,
                  dry_friction_n, held.SwingMm(8.0, 12.0), held.ChatterN(8.0, 12.0));
      hard.Expect(Message("swing, ", name, ", dry friction ", dry_friction_n, " N"),
                  held.SwingMm(8.0, 12.0), AtMost(dry_friction_n > 0.0 ? 1e-6 : 0.04), "mm");
    }
  };
  const NeedleForceModel layered(ShippedTable("bovine_2021.json"), Trocar18G());
  const AlamillaModel alamilla(ShippedTable("alamilla.json"), Trocar18G());
  const VidalModel vidal(ShippedTable("vidal.json"), Trocar18G(), body);
  check("layered", [&] { return DrivenLayered{layered, body}; });
  check("alamilla", [&] { return DrivenAlamilla{alamilla, body}; });
  check("vidal", [&] { return DrivenVidal{vidal, body}; });
}

// The fixture in rotation: radians for mm, N mm for N (then mass / 1000 is in N mm s^2). A handle
// of 1e-4 kg m^2, encoders of 1.5 mrad as of a cheap gimbal.
TEST(ForcesClosedLoop, TheFixtureGeneratesNoEnergyInRotation) {
  const HardCase hard("A fixture turns the handle back: encoders of 1.5 mrad, a hand at random.");
  Largest generated_mj;
  const FixtureSettings settings = ShippedTable("alamilla.json").alamilla.clamping;
  HapticDevice device;
  device.mass_kg = 100.0;
  device.damping_n_s_per_m = 500.0;
  device.encoder_mm = 0.0015;
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    RandomHand motion;
    motion.axis_in_ct = Eigen::Vector3d::UnitX();
    motion.from_mm = -0.4;
    motion.to_mm = 0.4;
    motion.across_mm = 0.3;
    motion.tremor_mm = 0.005;
    const auto wants = RandomMotion(motion, kDuration, seed);
    Hand hand;
    hand.stiffness_n_per_m = 5e5;
    hand.damping_n_s_per_m = 5e3;
    hand.wants_in_ct_mm = [wants](double t) {
      Eigen::Vector3d turn = wants(t);
      turn.z() = 0.0;
      return turn;
    };
    Fixture fixture;  // Holds the direction that it begins with.
    fixture.ct_from_reference = Eigen::AngleAxisd(-0.4, Eigen::Vector3d::UnitX());
    Eigen::Vector3d before(-0.4, 0.0, 0.0);
    const LoopResult result = RunClosedLoop(
        device, hand,
        [&](double, const Eigen::Vector3d& turn_rad) -> Eigen::Vector3d {
          const double angle = turn_rad.norm();
          FixtureMotion move;
          const Eigen::Quaterniond needle(
              Eigen::AngleAxisd(angle, angle > 0.0 ? Eigen::Vector3d(turn_rad / angle)
                                                   : Eigen::Vector3d::UnitX().eval()));
          move.ct_from_needle =
              WithoutTwist(fixture.ct_from_reference, needle * Eigen::Vector3d::UnitZ());
          move.angular_velocity_rad_per_s = (turn_rad - before) / 0.001;
          before = turn_rad;
          // What the torque is on the rotation vector: the transposed left Jacobian, for the
          // energy.
          const Eigen::Vector3d torque = StepFixture(settings, fixture, move).torque_n_mm;
          if (angle < 1e-9) return torque;
          const Eigen::Vector3d a = turn_rad / angle;
          const double sinc = std::sin(angle) / angle;
          return Eigen::Vector3d(sinc * torque + (1.0 - sinc) * a.dot(torque) * a -
                                 (1.0 - std::cos(angle)) / angle * a.cross(torque));
        },
        kDuration);
    std::printf(
        "  fixture, rotation, hand %d: generated %.4f mJ, took %.1f mJ, chatter %.2f N mm\n",
        static_cast<int>(seed), result.generated_mj, result.taken_mj,
        result.ChatterN(1.0, kDuration));
    generated_mj.Add(result.generated_mj);
  }
  hard.Expect("energy generated", generated_mj, AtMost(1.0), "mJ");
}

}  // namespace
}  // namespace acus::forces
