#include "acus/window/severity_mark.h"

#include <algorithm>

namespace acus::window {
namespace {

double StrokeOf(double radius_px) {
  return std::max(1.5, 0.4 * radius_px);
}

void DrawTick(const Eigen::Vector2d& centre, double radius, Colour colour, Sketch& sketch) {
  const double width = StrokeOf(radius);
  const Eigen::Vector2d foot = centre + radius * Eigen::Vector2d(-0.25, 0.8);
  sketch.Line(centre + radius * Eigen::Vector2d(-1.0, 0.05), foot, width, colour);
  sketch.Line(foot, centre + radius * Eigen::Vector2d(1.0, -0.8), width, colour);
}

void DrawCross(const Eigen::Vector2d& centre, double radius, Colour colour, Sketch& sketch) {
  for (const double side : {-1.0, 1.0}) {
    const Eigen::Vector2d reach = 0.85 * radius * Eigen::Vector2d(1.0, side);
    sketch.Line(centre - reach, centre + reach, StrokeOf(radius), colour);
  }
}

}  // namespace

Colour ColourOf(Severity severity) noexcept {
  switch (severity) {
    case Severity::kGood:
      return palette::kGood;
    case Severity::kNote:
      return palette::kFaint;
    case Severity::kWarning:
      return palette::kWarning;
    case Severity::kFault:
      return palette::kFault;
  }
  return palette::kText;
}

void DrawMark(Severity severity, const Eigen::Vector2d& centre, double radius_px, Sketch& sketch) {
  const Colour colour = ColourOf(severity);
  switch (severity) {
    case Severity::kGood:
      return DrawTick(centre, radius_px, colour, sketch);
    case Severity::kNote:
      return sketch.Dot(centre, 0.6 * radius_px, colour);
    case Severity::kWarning:
      return sketch.Triangle(centre + radius_px * Eigen::Vector2d(0.0, -1.0),
                             centre + radius_px * Eigen::Vector2d(1.1, 0.9),
                             centre + radius_px * Eigen::Vector2d(-1.1, 0.9), colour);
    case Severity::kFault:
      return DrawCross(centre, radius_px, colour, sketch);
  }
}

void DrawMark(training::StepState state, bool is_next, const Eigen::Vector2d& centre,
              double radius_px, Sketch& sketch) {
  switch (state) {
    case training::StepState::kDone:
      return DrawTick(centre, radius_px, palette::kGood, sketch);
    case training::StepState::kFailed:
      return DrawCross(centre, radius_px, palette::kFault, sketch);
    case training::StepState::kOpen:
      if (is_next) return sketch.Dot(centre, 0.8 * radius_px, palette::kNeedle);
      return sketch.Ring(centre, 0.7 * radius_px, 1.2, palette::kFaint);
  }
}

}  // namespace acus::window
