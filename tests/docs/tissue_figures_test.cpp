// docs/figures/displacement_functions.svg, after Alamilla-2021 fig. 12 and 13, is made here. This
// test compares it; with ACUS_WRITE_DOCS set it writes it instead.
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <gtest/gtest.h>
#include <string>

#include "acus/base/core/atomic_file.h"
#include "acus/physics/tissue/displacement_functions.h"

namespace acus::tissue {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kWidthMm = 60.0;
constexpr double kDepthMm = 60.0;
constexpr double kInterfaceMm = 24.0;
constexpr double kPixelsPerMm = 4.0;

std::string Number(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.1f", value + 0.0);
  return text;
}

struct Panel {
  const char* title;
  bool two_layers;
  bool pierced;
  double angle_rad;  ///< Of the needle from the vertical.
};

TissueLoad LoadOf(const Panel& panel) {
  TissueLoad load;
  NeedleLoad& needle = load.needle;
  needle.in_contact = true;
  needle.pierced = panel.pierced;
  needle.axis_in_ct = Vector3d(std::sin(panel.angle_rad), 0, std::cos(panel.angle_rad));
  needle.entry_in_ct_mm = Vector3d(panel.angle_rad == 0.0 ? 0.0 : -15.0, 0, 0);
  needle.tip_in_ct_mm = needle.entry_in_ct_mm + (panel.pierced ? 30.0 : 8.0) * needle.axis_in_ct;
  if (panel.pierced) {
    needle.cutting_n = 3.0;
    needle.friction_n = 45.0;
  } else {
    needle.pre_puncture_n = 3.0;
  }
  return load;
}

/// A 3 mm grid drawn on the tissue, deformed.
std::string Draw(const Panel& panel, const Vector2d& corner_px) {
  DisplacementFunctionSettings settings;
  settings.tip_length_mm = 1.0;  // The formula's numbers as they are printed.
  const DisplacementFunctions functions(settings, [&](const Vector3d& p) {
    if (p.z() < 0.0) return 0.0;
    return panel.two_layers && p.z() > kInterfaceMm ? 5.0 : 0.5;
  });
  const TissueLoad load = LoadOf(panel);
  const auto prepared = functions.Prepare(load);
  const auto to_px = [&](const Vector3d& p) {
    return Number(corner_px.x() + kPixelsPerMm * (p.x() + 0.5 * kWidthMm)) + "," +
           Number(corner_px.y() + kPixelsPerMm * (p.z() + 4.0));
  };
  const auto line = [&](const Vector3d& from, const Vector3d& to) {
    std::string points;
    for (int i = 0; i <= 40; ++i) {
      const Vector3d rest = from + (to - from) * (i / 40.0);
      points += (i == 0 ? "" : " ") + to_px(rest + functions.DisplacementMm(prepared, rest));
    }
    return points;
  };
  const double half = 0.5 * kWidthMm;
  std::string svg = "<text x='" + Number(corner_px.x()) + "' y='" + Number(corner_px.y() - 6) +
                    "'>" + panel.title + "</text>\n";
  if (panel.two_layers) {
    svg += "<polygon fill='#e8dcc8' points='" +
           line({-half, 0, kInterfaceMm}, {half, 0, kInterfaceMm}) + " " +
           to_px({half, 0, kDepthMm}) + " " + to_px({-half, 0, kDepthMm}) + "'/>\n";
  }
  for (int i = 0; i <= 20; ++i) {
    const double at_mm = 3.0 * i;
    svg += "<polyline points='" + line({-half, 0, at_mm}, {half, 0, at_mm}) + "'/>\n";
    svg += "<polyline points='" + line({at_mm - half, 0, 0}, {at_mm - half, 0, kDepthMm}) + "'/>\n";
  }
  const NeedleLoad& needle = load.needle;
  svg += "<polyline class='needle' points='" +
         to_px(needle.entry_in_ct_mm - 3.5 * needle.axis_in_ct) + " " + to_px(needle.tip_in_ct_mm) +
         "'/>\n";
  return svg;
}

std::string Figure() {
  const Panel panels[] = {
      {"one E, before puncture", false, false, 0.0},
      {"one E, after puncture", false, true, 0.0},
      {"one E, 45 degrees", false, true, 0.7853981633974483},
      {"E 0.5 and 5 N/mm², before puncture", true, false, 0.0},
      {"E 0.5 and 5 N/mm², after puncture", true, true, 0.0},
      {"E 0.5 and 5 N/mm², 45 degrees", true, true, 0.7853981633974483},
  };
  std::string svg =
      "<svg xmlns='http://www.w3.org/2000/svg' width='800' height='576' "
      "font-family='sans-serif' font-size='13'>\n"
      "<style>polyline{fill:none;stroke:#355070;stroke-width:.7}"
      ".needle{stroke:#c1121f;stroke-width:2.5}</style>\n"
      "<rect width='800' height='576' fill='white'/>\n";
  for (int i = 0; i < 6; ++i) {
    svg += Draw(panels[i], Vector2d(16 + 263 * (i % 3), 24 + 284 * (i / 3)));
  }
  return svg + "</svg>\n";
}

TEST(TissueFigures, DisplacementFunctionsAreDrawnAsTheyAre) {
  const std::filesystem::path file =
      std::filesystem::path(ACUS_SOURCE_DIR) / "docs/figures/displacement_functions.svg";
  const std::string svg = Figure();
  if (std::getenv("ACUS_WRITE_DOCS") != nullptr) {
    WriteTextFile(file, svg);
    return;
  }
  ASSERT_TRUE(std::filesystem::exists(file)) << "run tests/docs_figures with ACUS_WRITE_DOCS=1";
  EXPECT_TRUE(ReadTextFile(file) == svg)
      << file << " is out of date; run tests/docs_figures with ACUS_WRITE_DOCS=1";
}

}  // namespace
}  // namespace acus::tissue
