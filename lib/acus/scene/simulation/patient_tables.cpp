#include "acus/scene/simulation/patient_tables.h"

#include "acus/base/core/error.h"

namespace acus::simulation {
namespace {

template <typename Table>
Table Drawn(const Table& table, const scenario::Patient& patient, const std::filesystem::path& file,
            const RunContext& context) {
  const bool is_drawn = patient.stiffness_seed > 0 || patient.num_others > 0;
  if (is_drawn && !table.VariesBetweenPatients()) {
    context.Warn(
        Message(file.filename().string(),
                ": no row has between_patients: /patient/stiffness changes nothing there"));
  }
  return table.OfPatient(patient.stiffness_seed);
}

}  // namespace

forces::ForceTable ForcesOf(const scenario::Patient& patient, const std::filesystem::path& file,
                            const RunContext& context) {
  return Drawn(forces::ReadForceTable(file), patient, file, context);
}

mechanics::ElasticityTable ElasticityOf(const scenario::Patient& patient,
                                        const std::filesystem::path& file,
                                        const RunContext& context) {
  return Drawn(mechanics::ReadElasticityTable(file), patient, file, context);
}

}  // namespace acus::simulation
