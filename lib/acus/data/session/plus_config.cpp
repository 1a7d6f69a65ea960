#include "acus/data/session/plus_config.h"

#include "acus/base/core/atomic_file.h"
#include "acus/base/core/error.h"
#include "acus/base/core/xml_scan.h"
#include "acus/data/session/sequence_header.h"
#include "acus/data/session/sequence_writer.h"

namespace acus::session {

std::map<std::string, Eigen::Matrix4d> ReadPlusCalibrations(const std::filesystem::path& path) {
  const auto elements = core::ScanXml(ReadTextFile(path), path.string());
  ACUS_REQUIRE(elements.front().name == "PlusConfiguration", path.string(),
               ": is not a PLUS configuration; its first element is '", elements.front().name, "'");
  std::map<std::string, Eigen::Matrix4d> calibrations;
  for (const core::XmlElement& element : elements) {
    const auto from = element.Attribute("From");
    const auto to = element.Attribute("To");
    const auto text = element.Attribute("Matrix");
    if (element.name != "Transform" || !from || !to || !text) continue;
    const std::string name = *from + "To" + *to;
    const auto numbers = NumbersOf(*text);
    ACUS_REQUIRE(numbers && numbers->size() == 16, path.string(), ": the matrix of ", name,
                 " is not 16 finite numbers");
    calibrations[name] =
        Eigen::Map<const Eigen::Matrix<double, 4, 4, Eigen::RowMajor>>(numbers->data());
  }
  return calibrations;
}

void WritePlusCalibration(const std::filesystem::path& path, std::string_view from,
                          std::string_view to, const Eigen::Matrix4d& to_from_from,
                          double error_mm) {
  WriteTextFile(path, Message("<PlusConfiguration version=\"2.1\">\n  <CoordinateDefinitions>\n",
                              "    <Transform From=\"", from, "\" To=\"", to, "\"\n      Matrix=\"",
                              TransformText(to_from_from), "\"\n      Error=\"", error_mm,
                              "\" />\n  </CoordinateDefinitions>\n</PlusConfiguration>\n"));
}

}  // namespace acus::session
