// Sheets as PDF, SVG and PNG.
#include <cmath>
#include <cstdio>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <zlib.h>

#include "acus/base/core/atomic_file.h"
#include "acus/base/core/bytes.h"
#include "acus/base/core/error.h"
#include "acus/base/core/text_table.h"
#include "acus/rig/camera/sheet.h"

namespace acus::camera {
namespace {

constexpr double kPointsPerMm = 72.0 / 25.4;
constexpr double kPixelsPerMm = 300.0 / 25.4;

std::string Number(double value) {
  return FixedText(value, 4);
}

std::string PdfPage(const Sheet& sheet) {
  const auto x = [](double mm) { return Number(mm * kPointsPerMm); };
  const auto y = [&](double mm) { return Number((sheet.paper_mm[1] - mm) * kPointsPerMm); };
  std::string page = "0 g\n";
  for (const Rectangle& r : sheet.black) {
    page += x(r.corner_mm[0]) + " " + y(r.corner_mm[1] + r.size_mm[1]) + " " + x(r.size_mm[0]) +
            " " + x(r.size_mm[1]) + " re\n";
  }
  page += "f\n";  // All at once: no seams between neighbours.
  for (const Words& words : sheet.words) {
    std::string text;
    for (const char letter : words.text) {
      if (letter == '(' || letter == ')' || letter == '\\') text += '\\';
      text += letter;
    }
    page += "BT /F1 " + Number(words.height_mm * kPointsPerMm) + " Tf " + x(words.at_mm[0]) + " " +
            y(words.at_mm[1]) + " Td (" + text + ") Tj ET\n";
  }
  return page;
}

/// Says 300 pixels an inch in a PNG: a chunk pHYs behind the header.
std::string WithResolution(const std::vector<unsigned char>& png) {
  constexpr std::size_t kHeaderEnd = 8 + 25;
  const auto per_metre = static_cast<std::uint32_t>(std::lround(1000.0 * kPixelsPerMm));
  core::ByteWriter chunk(std::endian::big);
  chunk.Text("pHYs", 4);
  chunk.Number(per_metre);
  chunk.Number(per_metre);
  chunk.Number(std::uint8_t{1});
  const std::span<const std::uint8_t> bytes(png);
  core::ByteWriter out(std::endian::big);
  out.Raw(bytes.first(kHeaderEnd));
  out.Number(std::uint32_t{9});
  out.Raw(chunk.bytes);
  out.Number(static_cast<std::uint32_t>(
      crc32(0, chunk.bytes.data(), static_cast<uInt>(chunk.bytes.size()))));
  out.Raw(bytes.subspan(kHeaderEnd));
  return out.AsString();
}

std::string Png(const Sheet& sheet) {
  const auto px = [](double mm) { return static_cast<int>(std::lround(mm * kPixelsPerMm)); };
  cv::Mat image(px(sheet.paper_mm[1]), px(sheet.paper_mm[0]), CV_8UC1, cv::Scalar(255));
  const cv::Rect all(0, 0, image.cols, image.rows);
  for (const Rectangle& r : sheet.black) {
    // Each edge to its nearest pixel by itself, so that errors do not add up.
    const cv::Point a(px(r.corner_mm[0]), px(r.corner_mm[1]));
    const cv::Point b(px(r.corner_mm[0] + r.size_mm[0]), px(r.corner_mm[1] + r.size_mm[1]));
    image(cv::Rect(a, b) & all).setTo(0);
  }
  for (const Words& words : sheet.words) {
    const double scale = words.height_mm * kPixelsPerMm / 30.0;
    cv::putText(image, words.text, {px(words.at_mm[0]), px(words.at_mm[1])},
                cv::FONT_HERSHEY_SIMPLEX, scale, cv::Scalar(0), 2, cv::LINE_AA);
  }
  std::vector<unsigned char> png;
  ACUS_REQUIRE(cv::imencode(".png", image, png), sheet.name, ": the image cannot be encoded");
  return WithResolution(png);
}

}  // namespace

std::string PdfText(const std::vector<Sheet>& sheets) {
  std::vector<std::string> objects;  // Numbered from 1.
  std::string kids;
  for (std::size_t i = 0; i < sheets.size(); ++i) kids += std::to_string(4 + 2 * i) + " 0 R ";
  objects.emplace_back("<< /Type /Catalog /Pages 2 0 R >>");
  objects.push_back("<< /Type /Pages /Kids [" + kids + "] /Count " + std::to_string(sheets.size()) +
                    " >>");
  objects.emplace_back("<< /Type /Font /Subtype /Type1 /BaseFont /Helvetica >>");
  for (const Sheet& sheet : sheets) {
    objects.push_back("<< /Type /Page /Parent 2 0 R /MediaBox [0 0 " +
                      Number(sheet.paper_mm[0] * kPointsPerMm) + " " +
                      Number(sheet.paper_mm[1] * kPointsPerMm) +
                      "] /Resources << /Font << /F1 3 0 R >> >> /Contents " +
                      std::to_string(objects.size() + 2) + " 0 R >>");
    const std::string page = PdfPage(sheet);
    objects.push_back("<< /Length " + std::to_string(page.size()) + " >>\nstream\n" + page +
                      "endstream");
  }
  std::string out = "%PDF-1.4\n";
  std::string places;
  for (std::size_t i = 0; i < objects.size(); ++i) {
    char row[32];
    std::snprintf(row, sizeof row, "%010zu 00000 n \n", out.size());
    places += row;
    out += std::to_string(i + 1) + " 0 obj\n" + objects[i] + "\nendobj\n";
  }
  const std::string count = std::to_string(objects.size() + 1);
  const std::string start = std::to_string(out.size());
  return out + "xref\n0 " + count + "\n0000000000 65535 f \n" + places + "trailer\n<< /Size " +
         count + " /Root 1 0 R >>\nstartxref\n" + start + "\n%%EOF\n";
}

std::string SvgText(const Sheet& sheet) {
  const std::string width = Number(sheet.paper_mm[0]);
  const std::string height = Number(sheet.paper_mm[1]);
  std::string out = "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"" + width +
                    "mm\" height=\"" + height + "mm\" viewBox=\"0 0 " + width + " " + height +
                    "\">\n<rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n<path d=\"";
  for (const Rectangle& r : sheet.black) {
    out += "M" + Number(r.corner_mm[0]) + " " + Number(r.corner_mm[1]) + "h" +
           Number(r.size_mm[0]) + "v" + Number(r.size_mm[1]) + "h" + Number(-r.size_mm[0]) + "z\n";
  }
  out += "\"/>\n";
  for (const Words& words : sheet.words) {
    std::string text;
    for (const char letter : words.text) {
      text += letter == '&' ? "&amp;" : letter == '<' ? "&lt;" : std::string(1, letter);
    }
    out += "<text x=\"" + Number(words.at_mm[0]) + "\" y=\"" + Number(words.at_mm[1]) +
           "\" font-family=\"Helvetica, Arial, sans-serif\" font-size=\"" +
           Number(words.height_mm) + "\">" + text + "</text>\n";
  }
  return out + "</svg>\n";
}

void WriteSheets(const std::filesystem::path& folder, const std::string& all,
                 const std::vector<Sheet>& sheets) {
  for (const Sheet& sheet : sheets) {
    WriteTextFile(folder / (sheet.name + ".svg"), SvgText(sheet));
    WriteTextFile(folder / (sheet.name + ".png"), Png(sheet));
  }
  WriteTextFile(folder / (all + ".pdf"), PdfText(sheets));
}

}  // namespace acus::camera
