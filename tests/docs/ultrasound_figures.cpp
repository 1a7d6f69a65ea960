// Panels of ultrasound for the documentation, from a folder that acus-phantom made:
//   ultrasound_figures PATIENT PROBE.json FIGURE OUT.png
// FIGURE: models - the same moment by every model; vidal, alamilla, beams - the effects of one
// model, one after the other; expensive - the more expensive effects of the beams; vidal_7,
// alamilla_6, alamilla_9_10 - figures of the papers.
#include <algorithm>
#include <cstdint>
#include <functional>
#include <iostream>
#include <nlohmann/json.hpp>
#include <numbers>
#include <utility>

#include "acus/base/config/json_file.h"
#include "acus/base/config/pose_json.h"
#include "acus/base/core/error.h"
#include "acus/base/core/run_context.h"
#include "acus/data/image/png.h"
#include "acus/data/session/session_io.h"
#include "acus/data/volume/volume_io.h"
#include "acus/imaging/slicing/ct_slice.h"
#include "acus/imaging/ultrasound/aperture/aperture_renderer.h"
#include "acus/imaging/ultrasound/beams/beam_renderer.h"
#include "acus/imaging/ultrasound/columns/alamilla.h"
#include "acus/imaging/ultrasound/columns/bmode.h"
#include "acus/imaging/ultrasound/columns/vidal.h"
#include "acus/imaging/ultrasound/display/annotate.h"

namespace acus {
namespace {

namespace fs = std::filesystem;
using image::GrayImage;

/// What every panel shows.
struct Moment {
  volume::CtVolume ct;
  volume::LabelMap labels;
  acoustics::Probe probe;
  Eigen::Isometry3d ct_from_probe;
  image::NeedleInImage needle;
};

Eigen::Isometry3d CtFromReference(const fs::path& patient) {
  return config::PoseFromRows(config::ReadJson(patient / "truth.json").at("reference_from_ct"))
      .inverse();
}

/// The recorded session where the needle is at its deepest.
Moment MomentOf(const fs::path& patient, const fs::path& probe) {
  const RunContext context;
  const fs::path folder = fs::directory_iterator(patient / "sessions")->path();
  const session::Session session = session::ReadSession(folder, context);
  const Eigen::Isometry3d ct_from_reference = CtFromReference(patient);
  Moment moment{.ct = volume::ReadCt(patient / "ct.nrrd", "", RunContext()),
                .labels = volume::ReadTissues(patient / "labels.seg.nrrd"),
                .probe = acoustics::ReadProbe(probe),
                .ct_from_probe = Eigen::Isometry3d::Identity(),
                .needle = {}};
  moment.probe.image_width_px = moment.probe.image_height_px = 340;  // Speckle hardly compresses.
  const Eigen::Vector3d start = session.needle.front().reference_from_tool.translation();
  double deepest_mm = 0.0;
  for (const auto& sample : session.needle) {
    const double way_mm = (sample.reference_from_tool.translation() - start).norm();
    if (!sample.valid || way_mm < deepest_mm) continue;
    deepest_mm = way_mm;
    const Eigen::Isometry3d pose = ct_from_reference * sample.reference_from_tool;
    moment.needle.tip_in_ct_mm = pose.translation();
    moment.needle.axis_in_ct = pose.linear().col(2);
    const auto probe_sample =
        std::ranges::lower_bound(session.probe, sample.time_ns, {}, &session::PoseSample::time_ns);
    if (probe_sample != session.probe.end()) {
      moment.ct_from_probe = ct_from_reference * probe_sample->reference_from_tool;
    }
  }
  moment.needle.length_mm = 150.0;
  moment.needle.radius_mm = 0.6;
  return moment;
}

struct Panel {
  std::string title;
  GrayImage image;
};

/// Side by side, `columns` in a row, each with its title.
GrayImage Joined(const std::vector<Panel>& panels, int columns) {
  const int width = panels.front().image.width;
  const int height = panels.front().image.height;
  const int rows = (static_cast<int>(panels.size()) + columns - 1) / columns;
  GrayImage out;
  out.Resize(columns * width, rows * height);
  for (std::size_t n = 0; n < panels.size(); ++n) {
    GrayImage image = panels[n].image;
    std::fill_n(image.pixels.begin(), 24 * width, std::uint8_t{0});  // Behind the title.
    ultrasound::DrawText(image, 8, 8, panels[n].title, 255, 0.9);
    const int left = static_cast<int>(n) % columns * width;
    const int top = static_cast<int>(n) / columns * height;
    for (int r = 0; r < height; ++r) {
      std::copy_n(image.pixels.data() + static_cast<std::ptrdiff_t>(r) * width, width,
                  out.pixels.data() + static_cast<std::ptrdiff_t>(top + r) * out.width + left);
    }
  }
  return out;
}

fs::path Acoustics(const char* name) {
  return fs::path(ACUS_SOURCE_DIR) / "configs/acoustics" / name;
}

GrayImage Vidal(const Moment& m, const ultrasound::VidalOptions& options) {
  GrayImage image;
  ultrasound::VidalRenderer(m.ct, m.probe, options).Render(m.ct_from_probe, m.needle, image);
  return image;
}

GrayImage Alamilla(const Moment& m, const ultrasound::AlamillaOptions& options) {
  GrayImage image;
  ultrasound::AlamillaRenderer(m.labels, m.probe, options).Render(m.ct_from_probe, m.needle, image);
  return image;
}

GrayImage Columns(const Moment& m, const char* acoustics) {
  GrayImage image;
  ultrasound::BModeRenderer(m.ct, m.probe, ultrasound::ReadBModeOptions(Acoustics(acoustics)))
      .Render(m.ct_from_probe, m.needle, image);
  return image;
}

GrayImage Beams(const Moment& m, const ultrasound::BeamOptions& options) {
  const auto table = acoustics::ReadTissueAcoustics(Acoustics("tissues.json"));
  acoustics::Probe probe = m.probe;
  probe.frequency_mhz = 3.5;
  probe.gain_db = 22.0;
  probe.tgc_db_per_cm = 4.0;
  GrayImage image;
  ultrasound::BeamRenderer({.labels = &m.labels, .acoustics = &table}, probe, options)
      .Render(m.ct_from_probe, m.needle, image);
  return image;
}

/// With the settings of a scenario that names no others.
GrayImage Aperture(const Moment& m) {
  const auto table = acoustics::ReadTissueAcoustics(Acoustics("tissues.json"));
  acoustics::Probe probe =
      acoustics::ReadProbe(fs::path(ACUS_SOURCE_DIR) / "configs/probes/curvilinear_c5_2.json");
  probe.image_width_px = m.probe.image_width_px;
  probe.image_height_px = m.probe.image_height_px;
  ultrasound::ApertureOptions options;
  options.organ_structure = options.fibre_texture = true;
  GrayImage image;
  ultrasound::ApertureRenderer({.ct = &m.ct, .labels = &m.labels, .acoustics = &table}, probe,
                               options)
      .Render(m.ct_from_probe, m.needle, image);
  return image;
}

GrayImage CtSlice(const Moment& m) {
  GrayImage image;
  slicing::CtSliceRenderer(m.ct, acoustics::ImageOf(m.probe), m.probe.slice_thickness_mm)
      .Render(m.ct_from_probe, m.needle, image);
  return image;
}

ultrasound::BeamOptions ThreePlanes() {
  ultrasound::BeamOptions options;
  options.elevation_planes = 3;
  options.coupling_gap_mm = 10.0;
  return options;
}

/// All standard effects, and each image without one of them.
std::vector<Panel> BeamSteps(const Moment& m) {
  std::vector<Panel> panels{{"all standard effects", Beams(m, ThreePlanes())}};
  const auto without = [&](const char* title, auto&& change) {
    ultrasound::BeamOptions options = ThreePlanes();
    change(options);
    panels.push_back({title, Beams(m, options)});
  };
  using Options = ultrasound::BeamOptions;
  without("no point spread", [](Options& o) { o.point_spread = false; });
  without("no speckle", [](Options& o) { o.speckle = false; });
  without("no interfaces", [](Options& o) { o.interfaces = false; });
  without("no attenuation", [](Options& o) { o.attenuation = false; });
  without("no needle shadow, no tails", [](Options& o) { o.needle_shadow = o.comet_tail = false; });
  return panels;
}

std::vector<Panel> ExpensiveSteps(const Moment& m) {
  std::vector<Panel> panels{{"standard effects", Beams(m, ThreePlanes())}};
  ultrasound::BeamOptions options = ThreePlanes();
  options.refraction = options.time_of_flight = true;
  panels.push_back({"+ refraction, time of flight", Beams(m, options)});
  options.multiple_reflections = true;
  panels.push_back({"+ multiple reflections", Beams(m, options)});
  options.elevation_planes = 9;
  panels.push_back({"+ 9 elevation planes", Beams(m, options)});
  return panels;
}

std::vector<Panel> Models(const Moment& m) {
  return {{"CT slice", CtSlice(m)},
          {"vidal_2008", Vidal(m, ultrasound::ReadVidalOptions(Acoustics("vidal_2008.json")))},
          {"alamilla_2021",
           Alamilla(m, ultrasound::ReadAlamillaOptions(Acoustics("alamilla_2021.json")))},
          {"columns_2010", Columns(m, "hu_textured.json")},
          {"beams", Beams(m, ThreePlanes())},
          {"aperture", Aperture(m)}};
}

std::vector<Panel> VidalSteps(const Moment& m) {
  auto options = ultrasound::ReadVidalOptions(Acoustics("vidal_2008.json"));
  options.shadow = options.noise = options.reflections = false;
  std::vector<Panel> panels{{"look-up table", Vidal(m, options)}};
  options.noise = true;
  panels.push_back({"+ noise volume", Vidal(m, options)});
  options.reflections = true;
  panels.push_back({"+ Sobel reflections", Vidal(m, options)});
  options.shadow = true;
  panels.push_back({"+ shadow mask", Vidal(m, options)});
  return panels;
}

/// Figure 7 of Vidal-2008: mask and noise are images of a look-up table that is white.
std::vector<Panel> VidalFigure7(const Moment& m) {
  const auto all = ultrasound::ReadVidalOptions(Acoustics("vidal_2008.json"));
  auto options = all;
  options.noise = options.reflections = false;
  options.grey = {{-1000.0, 1.0}, {3000.0, 1.0}};
  std::vector<Panel> panels{{"A: slice", CtSlice(m)}, {"B: shadow mask", Vidal(m, options)}};
  options.shadow = false;
  options.noise = true;
  panels.push_back({"C: noise", Vidal(m, options)});
  options.shadow = true;
  options.grey = {{-200.0, 0.0}, {300.0, 1.0}};
  panels.push_back({"D: the three multiplied", Vidal(m, options)});
  panels.push_back({"E: table, reflections, contrast", Vidal(m, all)});
  return panels;
}

ultrasound::AlamillaOptions AlamillaSlice(const char* acoustics = "alamilla_2021.json") {
  auto options = ultrasound::ReadAlamillaOptions(Acoustics(acoustics));
  options.reflection = options.shadow = options.absorption = options.speckle = false;
  options.fibres = false;
  return options;
}

/// Figure 6 of Alamilla-2021, each stage on the slice.
std::vector<Panel> AlamillaFigure6(const Moment& m) {
  auto options = AlamillaSlice();
  std::vector<Panel> panels{{"init: slice", Alamilla(m, options)}};
  options.reflection = options.shadow = true;
  panels.push_back({"a: reflection, shadow", Alamilla(m, options)});
  options = AlamillaSlice("alamilla_2021_examples.json");
  options.speckle = options.fibres = true;
  panels.push_back({"b: texture of examples", Alamilla(m, options)});
  options = AlamillaSlice();
  options.speckle = options.absorption = true;
  panels.push_back({"c: noise, absorption", Alamilla(m, options)});
  options.fibres = true;
  panels.push_back({"d: blur along the fibres", Alamilla(m, options)});
  options.reflection = options.shadow = true;
  panels.push_back({"e: all", Alamilla(m, options)});
  return panels;
}

/// Figures 9 and 10 of Alamilla-2021: fibres of muscle along and across the image; muscle as thin
/// fibres, by the grain of the noise that is blurred.
std::vector<Panel> AlamillaFibres(const Moment& m) {
  Moment turned = m;
  turned.ct_from_probe.rotate(Eigen::AngleAxisd(std::numbers::pi / 2.0, Eigen::Vector3d::UnitY()));
  turned.needle.length_mm = 0.0;
  auto options = ultrasound::ReadAlamillaOptions(Acoustics("alamilla_2021.json"));
  std::vector<Panel> panels{{"9: along the fibres", Alamilla(m, options)},
                            {"9: across them", Alamilla(turned, options)}};
  for (const auto& [title, grain_mm] : {std::pair{"10: grains of 0.25 mm", 0.25},
                                        {"10: grains of 0.5 mm", 0.5},
                                        {"10: grains of 1 mm", 1.0},
                                        {"10: grains of 2 mm", 2.0}}) {
    for (auto& tissue : options.tissues) {
      if (tissue.tissue != "muscle") continue;
      tissue.texture = ultrasound::TissueTexture::kThinFibres;
      tissue.grain_mm = grain_mm;
    }
    panels.push_back({title, Alamilla(m, options)});
  }
  return panels;
}

/// The shallow half of a linear probe's image, without its margins.
Moment Shallow(Moment m) {
  m.probe.depth_mm = 50.0;
  m.probe.image_width_px = 260;
  return m;
}

std::vector<Panel> AlamillaSteps(const Moment& m) {
  auto options = AlamillaSlice();
  std::vector<Panel> panels{{"labels in grey", Alamilla(m, options)}};
  options.speckle = true;
  panels.push_back({"+ Perlin speckle", Alamilla(m, options)});
  options.fibres = true;
  panels.push_back({"+ fibres", Alamilla(m, options)});
  options.reflection = options.shadow = options.absorption = true;
  panels.push_back({"+ surfaces, shadow, absorption", Alamilla(m, options)});
  return panels;
}

void Run(const fs::path& patient, const fs::path& probe, const std::string& figure,
         const fs::path& out) {
  const Moment moment = MomentOf(patient, probe);
  const auto panels = figure == "models"          ? Models(moment)
                      : figure == "vidal"         ? VidalSteps(moment)
                      : figure == "beams"         ? BeamSteps(moment)
                      : figure == "expensive"     ? ExpensiveSteps(moment)
                      : figure == "vidal_7"       ? VidalFigure7(moment)
                      : figure == "alamilla_6"    ? AlamillaFigure6(Shallow(moment))
                      : figure == "alamilla_9_10" ? AlamillaFibres(Shallow(moment))
                                                  : AlamillaSteps(moment);
  image::WritePng(out, Joined(panels, panels.size() > 4 ? 3 : 2));
}

}  // namespace
}  // namespace acus

int main(int argc, char** argv) {
  if (argc != 5) {
    std::cerr
        << "usage: ultrasound_figures PATIENT PROBE.json models|vidal|alamilla|beams|expensive|"
           "vidal_7|alamilla_6|alamilla_9_10 OUT.png\n";
    return 2;
  }
  try {
    acus::Run(argv[1], argv[2], argv[3], argv[4]);
  } catch (const std::exception& error) {
    std::cerr << "ultrasound_figures: " << error.what() << '\n';
    return 1;
  }
  return 0;
}
