// How wide the pulse and the beam of a probe are: closed forms from its bandwidth, aperture and
// focus. Equations and their check: docs/models/ultrasound_probes.md.
#pragma once

#include "acus/imaging/acoustics/probe.h"

namespace acus::acoustics {

/// The speed that scanners assume when they turn time into depth.
inline constexpr double kScannerSpeedMPerS = 1540.0;

/// c / f.
double WavelengthMm(const Probe& probe, double speed_m_per_s = kScannerSpeedMPerS);

/// Frequency at which echoes are received: the probe's, or twice that. Their pulse is as long.
double ReceivedMhz(const Probe& probe);

/// Amplitude of the second harmonic relative to that at the focus: it builds up on its way, and
/// grows no more behind the focus. 1 if the probe receives its own frequency. (A plane wave in the
/// quasilinear approximation: p2 = beta omega p1^2 z / (2 rho c^3) where attenuation grows with the
/// frequency, times the losses that BeamMaterials has at twice the frequency; Hamilton and
/// Blackstock, Nonlinear Acoustics, 1998, chapter 4.)
double HarmonicBuildUp(const Probe& probe, double depth_mm);

/// Full width at half maximum (-6 dB) of the envelope of an echo along the beam, for a Gaussian
/// spectrum: 2 ln 2 / pi * c / (B f).
double AxialFwhmMm(const Probe& probe, double speed_m_per_s = kScannerSpeedMPerS);

/// Standard deviation of a Gaussian of this full width at half maximum.
double SigmaOfFwhm(double fwhm);

/// Active aperture on transmission: all elements that the F-number allows at the focus.
double TransmitApertureMm(const Probe& probe);

/// Active aperture on reception at a depth: grows with it until all elements work.
double ReceiveApertureMm(const Probe& probe, double depth_mm);

/// FWHM across the beam in the plane, two-way (amplitude, -6 dB), at a depth along the line:
/// transmission is focused at focus_mm, reception at every depth. The second harmonic is made where
/// the square of the transmitted pressure is large, and received at half the wavelength.
/// @pre depth_mm >= 0.
double LateralFwhmMm(const Probe& probe, double depth_mm,
                     double speed_m_per_s = kScannerSpeedMPerS);

/// FWHM across the plane, two-way: one lens both ways.
double ElevationFwhmMm(const Probe& probe, double depth_mm,
                       double speed_m_per_s = kScannerSpeedMPerS);

/// FWHM of one way's amplitude for a line aperture focused at `focus_mm`, as that of the Gaussian
/// beam with the same width in the focus, 1.207 lambda focus / aperture (where sinc falls to half).
double OneWayFwhmMm(double aperture_mm, double focus_mm, double depth_mm, double wavelength_mm);

}  // namespace acus::acoustics
