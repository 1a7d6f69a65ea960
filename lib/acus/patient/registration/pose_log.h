// Tools in recordings of any kind.
#pragma once

#include <string>
#include <vector>

#include "acus/data/session/session.h"
#include "acus/patient/registration/marker_facets.h"
#include "acus/patient/registration/tasks.h"

namespace acus::registration {

/// The poses of one tool. @throws InputError if the recording has no such tool, naming those it
/// has.
session::PoseStream ReadTool(const LogTool& tool, RunContext& context);

/// Names of the tools of a recording that it gives in `reference`.
std::vector<std::string> ToolsOf(const std::filesystem::path& log, const std::string& reference,
                                 RunContext& context);

/// Whether a path is a recording (a session folder, a sequence, a CSV of poses), not a list of
/// points.
bool IsPoseLog(const std::filesystem::path& path);

/// Facets with their points from a CSV (facet, name, x_mm, y_mm, z_mm), in order of appearance.
/// @throws InputError at file:row.
std::vector<Facet> ReadFacetPoints(const std::filesystem::path& path);

/// Poses of facets (time_s, facet, x_mm .. qz, status) by moment: rows of the same time belong
/// together. Rows whose status is not OK are omitted. @throws InputError at file:row, also for a
/// facet that is not among `facets`.
std::vector<FacetPoses> ReadFacetPoses(const std::filesystem::path& path,
                                       const std::vector<Facet>& facets);

}  // namespace acus::registration
