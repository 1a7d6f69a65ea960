// A session that does all that an exercise with one insertion can require: what `--demo` shows.
#pragma once

#include "acus/patient/phantom/hands/session_script.h"

namespace acus::phantom {

/// Name and folder of the demonstration, beside `sessions`.
inline constexpr const char* kDemonstration = "demonstration";

/// The probe is pressed lightly to the skin where the target is in the middle of a narrow image,
/// and rests there for 3 s. The needle is put to the skin, advanced a little and moved in and out,
/// the breath is held, and the tip goes straight to the target, stays there for 3 s and is
/// withdrawn. No bone is touched.
/// @param settings  Of the patient's other session: its hands, its stand-off and its probe.
/// @throws NoAnswerError if there is no skin where the probe is to lie.
SessionSettings DemonstrationOf(const PatientField& field, const InsertionPlan& plan,
                                const SessionSettings& settings);

/// The demonstration of exercises/epidural.json, in kDemonstration + "_epidural": as above up to
/// the puncture of the skin, then to the ligament; from there on the thumb presses the plunger, the
/// needle advances at 2 mm/s, stops 1.5 mm behind the ligament, where the thumb lets go after 1 s,
/// and is withdrawn.
/// @return  nothing if the path does not leave a ligament for fat or the spinal canal.
/// @throws NoAnswerError as DemonstrationOf.
std::optional<SessionSettings> EpiduralDemonstrationOf(const PatientField& field,
                                                       const InsertionPlan& plan,
                                                       const SessionSettings& settings);

/// The demonstration of another exercise with a syringe or a stylet: as DemonstrationOf; once the
/// tip has come to rest at the target, the plunger is pressed or pulled for `fluid.hold_s`.
SessionSettings FluidDemonstrationOf(const PatientField& field, const InsertionPlan& plan,
                                     const SessionSettings& settings,
                                     const FluidDemonstration& fluid);

}  // namespace acus::phantom
