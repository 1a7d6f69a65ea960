// Tables of forces and moduli as the scenario's patient has them.
#pragma once

#include <filesystem>

#include "acus/base/core/run_context.h"
#include "acus/physics/forces/laws/force_table.h"
#include "acus/physics/mechanics/elements/elasticity_table.h"
#include "acus/scene/scenario/scenario.h"

namespace acus::simulation {

/// Reads a table and draws by patient.stiffness_seed. Warns if patients are drawn and no row of
/// the table varies. @throws InputError if the file is not readable.
forces::ForceTable ForcesOf(const scenario::Patient& patient, const std::filesystem::path& file,
                            const RunContext& context);
mechanics::ElasticityTable ElasticityOf(const scenario::Patient& patient,
                                        const std::filesystem::path& file,
                                        const RunContext& context);

}  // namespace acus::simulation
