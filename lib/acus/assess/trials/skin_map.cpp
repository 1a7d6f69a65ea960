#include "acus/assess/trials/skin_map.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "acus/base/core/text_table.h"
#include "acus/base/report/markup.h"

namespace acus::trials {
namespace {

constexpr double kSizePx = 620.0;
constexpr double kLegendPx = 150.0;

/// Dark blue, green, yellow: readable in greyscale, and with colour blindness.
std::string ColourOf(double share) {
  constexpr std::array<std::array<double, 3>, 5> kStops = {
      {{68, 1, 84}, {59, 82, 139}, {33, 145, 140}, {94, 201, 98}, {253, 231, 37}}};
  const double at = std::clamp(share, 0.0, 1.0) * 4.0;
  const std::size_t low = std::min<std::size_t>(3, static_cast<std::size_t>(at));
  const double part = at - static_cast<double>(low);
  std::string text = "rgb(";
  for (std::size_t c = 0; c < 3; ++c) {
    const double value = (1.0 - part) * kStops[low][c] + part * kStops[low + 1][c];
    text += Message(c == 0 ? "" : ",", std::lround(value));
  }
  return text + ")";
}

/// Maps CT space to pixels: the skin seen from outside, the patient's head or left upwards.
class SkinView {
 public:
  SkinView(const TrialLine& line, double half_width_mm)
      : origin_mm_(line.entry_ct_mm), px_per_mm_(0.5 * kSizePx / half_width_mm) {
    const Eigen::Vector3d head(0.0, 0.0, 1.0);
    up_ = head - head.dot(line.inward_in_ct) * line.inward_in_ct;
    if (up_.norm() < 0.3) {
      const Eigen::Vector3d front(0.0, -1.0, 0.0);
      up_ = front - front.dot(line.inward_in_ct) * line.inward_in_ct;
    }
    up_.normalize();
    right_ = line.inward_in_ct.cross(up_);  // Seen from outside.
  }

  Eigen::Vector2d Px(const Eigen::Vector3d& point_ct_mm) const {
    const Eigen::Vector3d d = point_ct_mm - origin_mm_;
    return {0.5 * kSizePx + px_per_mm_ * d.dot(right_), 0.5 * kSizePx - px_per_mm_ * d.dot(up_)};
  }
  double px_per_mm() const { return px_per_mm_; }
  std::string UpWords() const { return PatientDirection(up_); }
  std::string RightWords() const { return PatientDirection(right_); }

 private:
  Eigen::Vector3d origin_mm_;
  Eigen::Vector3d up_;
  Eigen::Vector3d right_;
  double px_per_mm_;
};

std::string Number(double value) {
  return FixedText(value, 1);
}

std::string Label(double x, double y, const std::string& text, const char* anchor = "start") {
  return Message("<text x=\"", Number(x), "\" y=\"", Number(y), "\" text-anchor=\"", anchor,
                 "\" font-size=\"13\" fill=\"#333\">", report::Escaped(text), "</text>\n");
}

std::string Disc(const SkinView& view, const WhatIf& what_if, const Outcome& outcome,
                 const std::vector<std::string>& avoid, double share) {
  const Eigen::Vector2d px = view.Px(outcome.alternative.entry_ct_mm);
  return Message("<circle cx=\"", Number(px.x()), "\" cy=\"", Number(px.y()), "\" r=\"5\" fill=\"",
                 ColourOf(share), "\" stroke=\"#fff\" stroke-width=\"0.5\">", "<title>",
                 report::Escaped(ChangeText(what_if.line, outcome.alternative.change) + ": " +
                                 OutcomeText(what_if, outcome, avoid)),
                 "</title></circle>\n");
}

std::string TargetCross(const SkinView& view, const TrialScene& scene) {
  if (!scene.target_ct_mm) return {};
  const Eigen::Vector2d px = view.Px(*scene.target_ct_mm);
  if (px.minCoeff() < 0.0 || px.maxCoeff() > kSizePx) return {};
  return Message("<path d=\"M", Number(px.x() - 7), " ", Number(px.y()), "h14M", Number(px.x()),
                 " ", Number(px.y() - 7), "v14\" stroke=\"#d00\" stroke-width=\"2\"/>\n",
                 Label(px.x() + 9, px.y() - 4, "target below"));
}

std::string ProbeFace(const SkinView& view, const TrialScene& scene, const session::Session& trial,
                      const TrialLine& line) {
  if (trial.probe.empty()) return {};
  const Eigen::Isometry3d ct_from_probe =
      scene.scene.ct_from_reference *
      session::PoseAt(trial.probe, line.deepest_ns).reference_from_tool.isometry();
  constexpr double kHalfFaceMm = 25.0;
  const Eigen::Vector2d a = view.Px(ct_from_probe * Eigen::Vector3d(-kHalfFaceMm, 0.0, 0.0));
  const Eigen::Vector2d b = view.Px(ct_from_probe * Eigen::Vector3d(kHalfFaceMm, 0.0, 0.0));
  return Message("<line x1=\"", Number(a.x()), "\" y1=\"", Number(a.y()), "\" x2=\"", Number(b.x()),
                 "\" y2=\"", Number(b.y()),
                 "\" stroke=\"#888\" stroke-width=\"4\" stroke-opacity=\"0.5\"/>\n");
}

std::string Legend(double worst, double best) {
  std::string text = Label(kSizePx + 20, 40, "score");
  constexpr int kBands = 20;
  for (int i = 0; i < kBands; ++i) {
    text +=
        Message("<rect x=\"", Number(kSizePx + 20), "\" y=\"", 250 - 10 * i,
                "\" width=\"18\" height=\"10\" fill=\"", ColourOf((i + 0.5) / kBands), "\"/>\n");
  }
  return text + Label(kSizePx + 46, 262, FixedText(worst, 2)) +
         Label(kSizePx + 46, 70, FixedText(best, 2));
}

}  // namespace

std::string SkinMapSvg(const TrialScene& scene, const session::Session& trial,
                       const WhatIf& what_if) {
  double half_width_mm = 10.0;
  double worst = 1.0;
  double best = 0.0;
  for (const Outcome& outcome : what_if.outcomes) {
    const double away_mm = (outcome.alternative.entry_ct_mm - what_if.line.entry_ct_mm).norm();
    half_width_mm = std::max(half_width_mm, 1.15 * away_mm);
    worst = std::min(worst, outcome.score);
    best = std::max(best, outcome.score);
  }
  const SkinView view(what_if.line, half_width_mm);
  const double span = best > worst ? best - worst : 1.0;
  std::string svg =
      Message("<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"", kSizePx + kLegendPx,
              "\" height=\"", kSizePx, "\" viewBox=\"0 0 ", kSizePx + kLegendPx, " ", kSizePx,
              "\" font-family=\"sans-serif\">\n<rect width=\"", kSizePx, "\" height=\"", kSizePx,
              "\" fill=\"#f6f2ee\"/>\n");
  // Content outside the square is clipped.
  svg += Message("<svg width=\"", kSizePx, "\" height=\"", kSizePx, "\">\n");
  svg += ProbeFace(view, scene, trial, what_if.line);
  for (auto place = what_if.ranking.rbegin(); place != what_if.ranking.rend(); ++place) {
    const Outcome& outcome = what_if.outcomes[*place];
    svg += Disc(view, what_if, outcome, scene.exercise.avoid, (outcome.score - worst) / span);
  }
  const Eigen::Vector2d entry = view.Px(what_if.line.entry_ct_mm);
  svg += Message("<circle cx=\"", Number(entry.x()), "\" cy=\"", Number(entry.y()),
                 "\" r=\"9\" fill=\"none\" stroke=\"#000\" stroke-width=\"2\"/>\n",
                 Label(entry.x() + 12, entry.y() + 16, "trial"));
  svg += TargetCross(view, scene);
  svg += Label(0.5 * kSizePx, 16, view.UpWords(), "middle");
  svg += Label(kSizePx - 6, 0.5 * kSizePx, view.RightWords(), "end");
  const double bar_px = 10.0 * view.px_per_mm();
  svg += Message("<rect x=\"16\" y=\"", Number(kSizePx - 20), "\" width=\"", Number(bar_px),
                 "\" height=\"4\" fill=\"#333\"/>\n", Label(16, kSizePx - 26, "10 mm"));
  return svg + "</svg>\n" + Legend(worst, best) + "</svg>\n";
}

}  // namespace acus::trials
