#include "acus/rig/camera/sheet.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "acus/base/core/text_table.h"
#include "acus/rig/camera/canvas.h"

namespace acus::camera {
namespace {

constexpr double kLineMm = 0.2;
constexpr double kMarginMm = 12.0;

void AddWords(Sheet& sheet, double x_mm, double y_mm, double height_mm, const std::string& text) {
  sheet.words.push_back({{x_mm, y_mm}, height_mm, text});
}

/// Runs of black squares of a row as one rectangle: fewer seams for a printer to show.
void AddModules(Sheet& sheet, const std::vector<std::vector<bool>>& bits,
                const Eigen::Vector2d& corner_mm, double module_mm) {
  for (std::size_t row = 0; row < bits.size(); ++row) {
    for (std::size_t column = 0; column < bits[row].size();) {
      std::size_t end = column;
      while (end < bits[row].size() && !bits[row][end]) ++end;
      if (end > column) {
        sheet.black.push_back(
            {corner_mm +
                 module_mm * Eigen::Vector2d(static_cast<double>(column), static_cast<double>(row)),
             module_mm * Eigen::Vector2d(static_cast<double>(end - column), 1.0)});
      }
      column = std::max(end, column + 1);
    }
  }
}

void AddFrame(Sheet& sheet, const Eigen::Vector2d& corner_mm, const Eigen::Vector2d& size_mm) {
  const Eigen::Vector2d across(size_mm[0], kLineMm);
  const Eigen::Vector2d down(kLineMm, size_mm[1]);
  sheet.black.push_back({corner_mm, across});
  sheet.black.push_back({corner_mm + Eigen::Vector2d(0, size_mm[1] - kLineMm), across});
  sheet.black.push_back({corner_mm, down});
  sheet.black.push_back({corner_mm + Eigen::Vector2d(size_mm[0] - kLineMm, 0), down});
}

/// At the bottom: a length to hold a ruler to.
void AddRuler(Sheet& sheet) {
  const double length_mm =
      std::min(100.0, 10.0 * std::floor((sheet.paper_mm[0] - 2.0 * kMarginMm) / 10.0));
  const double y = sheet.paper_mm[1] - kMarginMm;
  sheet.black.push_back({{kMarginMm, y}, {length_mm, kLineMm}});
  for (double x = 0.0; x <= length_mm + 1e-9; x += 10.0) {
    const double tick_mm = std::fmod(x, 50.0) < 1e-9 ? 3.0 : 1.5;
    // Inside of the ends, so that the line is as long as it says.
    const double at = std::min(x, length_mm - kLineMm);
    sheet.black.push_back({{kMarginMm + at, y - tick_mm}, {kLineMm, tick_mm}});
  }
  AddWords(sheet, kMarginMm, y + 4.5, 2.8,
           "This line is " + FixedText(length_mm, 0) +
               " mm long: measure it. Print at 100 %, not fitted to the page.");
}

std::string FileName(const std::string& words) {
  std::string name;
  for (const char letter : words) {
    const bool plain = (letter >= 'a' && letter <= 'z') || (letter >= 'A' && letter <= 'Z') ||
                       (letter >= '0' && letter <= '9') || letter == '-';
    name += plain ? letter : '_';
  }
  return name;
}

struct FacetPrint {
  std::string object;
  std::vector<const Marker*> markers;
};

/// A facet's markers lie in one plane: x and y there, in the frame of its first marker.
Sheet FacetSheet(const FacetSet& set, const std::string& facet, const FacetPrint& print) {
  const Eigen::Isometry3d facet_from_object = print.markers[0]->object_from_marker.inverse();
  Eigen::AlignedBox2d box;
  for (const Marker* marker : print.markers) {
    const Eigen::Vector2d at =
        (facet_from_object * marker->object_from_marker.translation()).head<2>();
    const double reach = marker->side_mm * 0.75;  // With white around it.
    box.extend(Eigen::Vector2d(at.array() - reach));
    box.extend(Eigen::Vector2d(at.array() + reach));
  }
  Sheet sheet;
  sheet.name = FileName(print.object + "_" + facet);
  sheet.paper_mm =
      sheet.paper_mm.cwiseMax(box.sizes() + Eigen::Vector2d(2 * kMarginMm, 5 * kMarginMm));
  const Eigen::Vector2d corner_mm(0.5 * (sheet.paper_mm[0] - box.sizes()[0]), 2.5 * kMarginMm);
  std::string ids;
  for (const Marker* marker : print.markers) {
    const Eigen::Vector2d at =
        (facet_from_object * marker->object_from_marker.translation()).head<2>();
    const Eigen::Vector2d middle_mm =
        corner_mm + Eigen::Vector2d(at[0] - box.min()[0], box.max()[1] - at[1]);
    const PrintedSheet code = PrintMarker(set.dictionary, marker->id, marker->side_mm);
    AddModules(sheet, code.bits, middle_mm.array() - 0.5 * marker->side_mm, code.module_mm);
    ids += (ids.empty() ? "" : ", ") + std::to_string(marker->id) + " (" +
           FixedText(marker->side_mm, 1) + " mm)";
  }
  AddFrame(sheet, corner_mm, box.sizes());
  AddWords(sheet, kMarginMm, kMarginMm, 4.5, print.object + ": " + facet);
  AddWords(sheet, kMarginMm, kMarginMm + 6.0, 2.8,
           set.name + ", " + set.dictionary + ", markers " + ids + ".");
  AddWords(sheet, kMarginMm, kMarginMm + 11.0, 2.8,
           "Right is x and up is y of the facet. Cut along the frame; glue it on flat.");
  AddRuler(sheet);
  return sheet;
}

}  // namespace

Sheet BoardSheet(const CalibrationBoard& board) {
  Sheet sheet;
  sheet.name = "board";
  sheet.paper_mm = board.paper_mm;
  const Eigen::Vector2d size_mm = board.square_mm * Eigen::Vector2d(board.columns, board.rows);
  const Eigen::Vector2d corner_mm(0.5 * (sheet.paper_mm[0] - size_mm[0]), kMarginMm);
  AddModules(sheet, board.Modules(), corner_mm, board.ModuleMm());
  AddRuler(sheet);
  AddWords(
      sheet, kMarginMm, sheet.paper_mm[1] - 2.5, 2.8,
      board.name + ": squares of " + FixedText(board.square_mm, 2) + " mm, " + board.dictionary);
  return sheet;
}

std::vector<Sheet> FacetSheets(const FacetSet& facets) {
  std::vector<Sheet> sheets;
  for (const FacetObject& object : facets.objects) {
    // In the order of the file.
    std::vector<std::string> order;
    std::map<std::string, FacetPrint> prints;
    for (const Marker& marker : object.markers) {
      FacetPrint& print = prints[marker.facet];
      if (print.markers.empty()) order.push_back(marker.facet);
      print.object = object.name;
      print.markers.push_back(&marker);
    }
    for (const std::string& facet : order) {
      sheets.push_back(FacetSheet(facets, facet, prints.at(facet)));
    }
  }
  return sheets;
}

}  // namespace acus::camera
