// Repeats figures 14, 15, 19 and 20 of Alamilla-2021 by simulation: alamilla_figures OUT_FOLDER
#include <filesystem>
#include <iostream>
#include <string>

#include "acus/base/core/error.h"
#include "acus/base/report/svg_plot.h"
#include "acus/physics/forces/laws/force_laws.h"
#include "support/force_scenes.h"

namespace acus::forces {
namespace {

using Eigen::Vector3d;
using report::Plot;
using report::Series;
using testing_support::DrivenAlamilla;
using testing_support::LayeredBodyField;

struct Knot {
  double time_s;
  double value;
};

/// Through the knots by minimum-jerk moves.
double Follow(const std::vector<Knot>& knots, double t) {
  double value = knots.front().value;
  for (std::size_t i = 1; i < knots.size(); ++i) {
    const double s =
        std::clamp((t - knots[i - 1].time_s) / (knots[i].time_s - knots[i - 1].time_s), 0.0, 1.0);
    value += s * s * s * (10.0 + s * (-15.0 + 6.0 * s)) * (knots[i].value - knots[i - 1].value);
  }
  return value;
}

Plot PlotOf(const std::string& title, const char* y_label) {
  Plot plot;
  plot.title = title;
  plot.x_label = "time [s]";
  plot.y_label = y_label;
  plot.height_px = 210;
  return plot;
}

/// Fig. 14 or 15: a hand that wants to be at `wants_mm`, with position and force.
void DrawLoop(const std::filesystem::path& file, const char* title,
              const std::vector<Knot>& wants_mm, double duration_s,
              const std::function<double(double)>& force_of_depth) {
  Hand hand;
  hand.wants_in_ct_mm = [&](double t) { return Vector3d(0.0, 0.0, Follow(wants_mm, t)); };
  const LoopResult result = RunClosedLoop(
      {}, hand,
      [&](double, const Vector3d& tip_mm) {
        return Vector3d(0.0, 0.0, -force_of_depth(tip_mm.z()));
      },
      duration_s);
  Plot place = PlotOf(title, "depth [mm]");
  Plot force = PlotOf("", "force on the tool [N]");
  Series tool{.name = "tool"};
  Series wall{.name = "wall"};
  Series acting{.name = ""};
  for (const LoopSample& sample : result.samples) {
    tool.x.push_back(sample.time_s);
    tool.y.push_back(sample.device_in_ct_mm.z());
    acting.x.push_back(sample.time_s);
    acting.y.push_back(-sample.force_n.z());
  }
  wall.x = {0.0, duration_s};
  wall.y = {0.0, 0.0};
  place.series = {tool, wall};
  force.series = {acting};
  const Plot plots[] = {place, force};
  WriteSvg(file, plots);
  std::cout << file.string() << ": chatter above 30 Hz " << result.ChatterN(0.0, duration_s)
            << " N\n";
}

struct Insertion {
  const char* name;
  std::vector<Knot> depth_mm;
  std::vector<Knot> angle_deg;
};

/// Fig. 19 and 20: the two insertions into the shoulder.
void DrawInsertions(const std::filesystem::path& folder) {
  const LayeredBodyField shoulder({{0, "skin", 20},
                                   {4, "muscle", 55},
                                   {24, "bursa", 10},
                                   {27, "tendon", 80},
                                   {33, "cartilage", 120},
                                   {36, "bone", 900}});
  const AlamillaModel model(testing_support::ShippedTable("alamilla.json"),
                            testing_support::Trocar18G());
  // The paper's text: in until 0.7 s, then out; and in until 2.5 s, back, turned from 3 s on, in
  // again at 4.4 s, bone at 4.9 s, out.
  const Insertion insertions[] = {
      {"straight", {{0.0, -3}, {0.7, 31}, {0.8, 31}, {1.7, -4}}, {{0.0, 0}, {1.7, 1.5}}},
      {"turned",
       {{0.0, -3}, {2.5, 30}, {3.0, 17}, {4.4, 17}, {4.95, 37}, {5.3, 37}, {6.3, -4}},
       {{0.0, 0}, {3.0, 0}, {4.3, 7}, {4.95, 7}, {6.3, 10}}}};
  Plot moved[2];
  Plot clamping[2];
  Plot cutting[2];
  for (int n = 0; n < 2; ++n) {
    const Insertion& insertion = insertions[n];
    const std::string name = insertion.name;
    moved[n] = PlotOf("Displacement of the tip, " + name + " insertion", "displacement [mm]");
    Series axes[] = {{.name = "across, in the plane of turning"},
                     {.name = "across it"},
                     {.name = "into the body"}};
    clamping[n] = PlotOf("Clamping, " + name + " insertion", "clamping [N]");
    cutting[n] = PlotOf("Cutting and friction, " + name + " insertion", "axial force [N]");
    Series sideways{.name = "force across the path"};
    Series torque{.name = "torque / 100 mm"};
    Series wall{.name = "cutting (above 0), withdrawal (below)"};
    Series friction{.name = "friction"};
    DrivenAlamilla needle{model, shoulder};
    const double end_s = insertion.depth_mm.back().time_s;
    for (int i = 0; i <= static_cast<int>(1000.0 * end_s); ++i) {
      const double t = 0.001 * i;
      const double angle = Follow(insertion.angle_deg, t) * 0.017453292519943295;
      const double depth_mm = Follow(insertion.depth_mm, t);
      const double unsteady_mm = 0.4 * std::sin(9.0 * t) * std::sin(2.3 * t);
      needle.axis = {std::sin(angle), 0.0, std::cos(angle)};
      // The hand turns the needle about where it entered the skin.
      const Vector3d tip_mm = depth_mm * needle.axis + unsteady_mm * Vector3d::UnitY();
      const NeedleForce& out = needle.Step(t, tip_mm);
      for (int k = 0; k < 3; ++k) {
        axes[k].x.push_back(t);
        axes[k].y.push_back(tip_mm[k]);
      }
      for (Series* series : {&sideways, &torque, &wall, &friction}) series->x.push_back(t);
      sideways.y.push_back(out.lateral_n);
      torque.y.push_back(0.01 * out.torque_in_ct_n_mm.norm());
      wall.y.push_back(out.cutting_n);
      friction.y.push_back(out.friction_n);
      if (out.event != NeedleEvent::kNone) {
        cutting[n].marks.push_back({t, std::string(NameOf(out.event))});
      }
    }
    moved[n].series.assign(std::begin(axes), std::end(axes));
    clamping[n].series = {sideways, torque};
    cutting[n].series = {wall, friction};
  }
  for (int n = 0; n < 2; ++n) {
    WriteSvg(folder / ("alamilla_18_displacement_" + std::string(insertions[n].name) + ".svg"),
             moved[n]);
    WriteSvg(folder / ("alamilla_19_clamping_" + std::string(insertions[n].name) + ".svg"),
             clamping[n]);
    WriteSvg(folder / ("alamilla_20_cutting_" + std::string(insertions[n].name) + ".svg"),
             cutting[n]);
  }
}

void DrawAll(const std::filesystem::path& folder) {
  DrawLoop(folder / "alamilla_14_direct_method.svg", "Direct method: a wall of 1 N",
           {{0.0, -15}, {2.5, -15}, {4.2, 1.5}, {6.0, 1.5}, {6.5, 0.3}, {7.0, 0.3}}, 7.0,
           [](double depth_mm) { return DirectMethodN(depth_mm, 1.0); });
  TrackingWall wall;
  DrawLoop(
      folder / "alamilla_15_tracking_wall.svg", "Tracking wall: a spring of 250 N/m",
      {{0.0, -15}, {2.0, -15}, {5.0, 5}, {9.0, 14}, {12.5, 20}, {13.0, 20}, {15.0, 2}, {16.0, 2}},
      16.0, [&wall](double depth_mm) {
        return depth_mm > 0.0 ? wall.AdvanceBothWays(depth_mm, 2.5, 0.0, 0.25) : 0.0;
      });
  DrawInsertions(folder);
}

}  // namespace
}  // namespace acus::forces

int main(int argc, char** argv) {
  if (argc != 2) {
    std::cerr << "usage: alamilla_figures OUT_FOLDER\n";
    return 2;
  }
  try {
    acus::forces::DrawAll(argv[1]);
  } catch (const std::exception& error) {
    std::cerr << error.what() << '\n';
    return 1;
  }
  return 0;
}
