// Every tolerance of the physics tests in one place, with its reason. Two values: for physics in float and in double.
// Snapshots are float in both, so a comparison through a snapshot cannot be closer than about 1e-7 even in double.
// The environment variable TOL_SCALE multiplies all of them; TOL_SCALE=0 makes every check fail and print its residual.
#pragma once

#include <cstdlib>
#include <string>

#include <gtest/gtest.h>

#include "sim_server/physics/real.h"

namespace palp::test {

struct Tolerance {
  double in_float;
  double in_double;
  const char* why;
};

inline double value_of(const Tolerance& tolerance) {
  static const double scale = [] {
    const char* text = std::getenv("TOL_SCALE");
    return text != nullptr ? std::atof(text) : 1.0;
  }();
  return scale * (sizeof(real) == sizeof(float) ? tolerance.in_float : tolerance.in_double);
}

// True when |residual| is at most the tolerance; false for NaN.
inline ::testing::AssertionResult within(double residual, const Tolerance& tolerance) {
  const double limit = value_of(tolerance);
  if (std::abs(residual) <= limit && limit > 0) return ::testing::AssertionSuccess();
  return ::testing::AssertionFailure() << "residual " << residual << ", tolerance " << limit << " (" << tolerance.why
                                       << ")";
}

namespace tol {
// one sub-step against the equations restated in double, relative to the largest value of the field
inline constexpr Tolerance kOneStep{2e-5, 1e-6, "round-off of sums over ~100 neighbours with cancellation"};
// several sub-steps: the round-off of the first is carried on and grows by the sound that it makes
inline constexpr Tolerance kFewSteps{2e-4, 2e-6, "round-off carried over a few sub-steps"};
inline constexpr Tolerance kManySteps{5e-3, 2e-6, "as above over 40 sub-steps of a violent flow"};
inline constexpr Tolerance kBodyState{5e-6, 1e-13, "a body's state, relative to the size of the scene"};
inline constexpr Tolerance kBodyWrench{1e-4, 1e-12, "a sum of many pair forces that nearly cancel"};
// kernels
inline constexpr Tolerance kKernelIntegral{1e-5, 1e-6, "midpoint rule with 4000 shells, kernel in real"};
inline constexpr Tolerance kKernelFromSlope{1e-4, 2e-5, "midpoint rule within a midpoint rule"};
inline constexpr Tolerance kLatticeShear{0.02, 0.02, "of p, H = 2.6 to 3.5 dx; Wendland C2 has 0.18 with 2 dx"};
inline constexpr Tolerance kWallPressure{0.04, 0.04, "of the pressure: a sum over a lattice for an integral"};
inline constexpr Tolerance kKernelSlope{2e-3, 1e-6, "central difference of a kernel in real"};
// conservation, physics reference D18
inline constexpr Tolerance kMomentum{1e-5, 1e-12, "pair forces are equal and opposite up to round-off"};
inline constexpr Tolerance kMomentumOfSnapshot{1e-5, 2e-7, "as above, read through float"};
inline constexpr Tolerance kSymmetry{2e-4, 2e-6, "the same sums in another order"};
inline constexpr Tolerance kTranslation{2e-3, 2e-6, "positions near 1 m are rounded to 6e-8 m, 1e-6 of a spacing"};
inline constexpr Tolerance kClosedMomentum{1e-5, 2e-7, "of the sum of |m v|, over 10,000 steps; read through float"};
inline constexpr Tolerance kClosedEnergy{1e-3, 1e-3, "of the kinetic energy at the start: only dissipation is left"};
// analytic cases, reference D1 and D3
inline constexpr Tolerance kHydrostaticProfile{0.02, 0.02, "of the pressure at the bottom (Adami et al. 2012)"};
inline constexpr Tolerance kWallForce{0.01, 0.01, "of the weight, mean over an acoustic period"};
inline constexpr Tolerance kThinWallForce{0.12, 0.12,
                                          "of rho g h^2 / 2; within a support radius of a floor that floor bears a "
                                          "part, a tenth at twelve spacings of depth"};
inline constexpr Tolerance kRestDrift{0.1, 0.1, "of a spacing, over a minute"};
inline constexpr Tolerance kStirredVolume{
    0.03, 0.03, "of the height: particles in disorder fill space as well as a lattice to about 2 %"};
inline constexpr Tolerance kGuard{1e-5, 1e-11, "of the largest push, force, and force times radius: rounding"};
inline constexpr Tolerance kBeneath{0.03, 0.03,
                                    "of a hundredth of a spacing above the surface, where both are asked for"};
inline constexpr Tolerance kSurfaceBend{0.015, 0.015,
                                        "of the acceleration: half a spacing ahead on a radius of five or more"};
inline constexpr Tolerance kWallShare{
    0.023, 0.023, "layers err by 0.018 of an integral, quadrature by 0.005 in edges, products of shares by 0.01"};
inline constexpr Tolerance kSameWall{1e-5, 1e-11, "of a share and 1 / H: rounding"};
inline constexpr Tolerance kWallSlope{
    0.08, 0.08, "of 1 / H; 1.5 at a plane. Where shapes join, products of shares err by 0.06; quadrature errs by 0.02"};
inline constexpr Tolerance kWallShear{1e-4, 1e-8, "of the same: a rounded distance"};
inline constexpr Tolerance kWallPull{0.023, 0.023, "of the acceleration, for the same reasons as the share"};
inline constexpr Tolerance kPenetration{0.05, 0.05, "of a spacing: fluid that is stirred was within the ladle by 0.4"};
inline constexpr Tolerance kRestingSpeed{0.01, 0.01, "of sqrt(g H)"};
inline constexpr Tolerance kCompression{0.012, 0.012, "g H / c^2 = 1 % at c = 10 sqrt(g H), and sound"};
inline constexpr Tolerance kDamBreakFront{0.10, 0.10, "of the distance, Martin & Moyce 1952"};
inline constexpr Tolerance kFrontBetween{0.02, 0.02, "of the distance: half a spacing is a twentieth of the width"};
inline constexpr Tolerance kIdealFront{0.10, 0.10,
                                       "of the distance in potential flow; the tip is thinner than a spacing"};
inline constexpr Tolerance kRitter{0.03, 0.03,
                                   "of the time, which is two spacings of the way; no lower bound is known"};
inline constexpr Tolerance kImpactTime{0.10, 0.10, "of the time, as for the front of Martin & Moyce"};
inline constexpr Tolerance kImpactPressure{0.20, 0.20, "of the pressure, as is asked of this case elsewhere"};
inline constexpr Tolerance kImpactDepth{0.05, 0.05, "of the depth at the start"};
inline constexpr Tolerance kThroughFloor{1e-6, 1e-6, "of a spacing: no particle's centre gets below the floor"};
inline constexpr Tolerance kNoParticle{0.5, 0.5, "particles: not one"};
inline constexpr Tolerance kTilt{0.1, 0.1, "rad, of a box that is released a layer too high"};
inline constexpr Tolerance kTurning{0.05, 0.05, "of the torque: at six spacings"};
inline constexpr Tolerance kTurningCoarse{0.15, 0.15, "of the torque: at two spacings"};
inline constexpr Tolerance kBuoyancy{0.03, 0.03, "of rho g V"};
inline constexpr Tolerance kCoarseBuoyancy{0.06, 0.06, "of rho g V: a ball of 1.25 spacings"};
inline constexpr Tolerance kDraft{0.4, 0.4,
                                  "of a spacing: the gap at a solid and the level of a free surface; measured -0.26"};
inline constexpr Tolerance kHeave{0.05, 0.05, "of the period: the draft is off by up to 0.4 dx of the 9 dx that swing"};
inline constexpr Tolerance kStandingWave{0.02, 0.02,
                                         "of the period: the free surface is known to half a spacing of depth"};
inline constexpr Tolerance kShearFlow{0.05, 0.05, "of the middle speed"};
inline constexpr Tolerance kFilmFlow{0.05, 0.05, "of the surface's speed, as for the flow between plates"};
inline constexpr Tolerance kTaylorGreen{0.10, 0.10, "of the decay rate over the first 0.1 s at 20 particles a box"};
inline constexpr Tolerance kVortices{0.07, 0.07, "of the decay rate over half a second, which a hand does not notice"};
inline constexpr Tolerance kLidCavity{0.05, 0.05, "of the speed there, reference D6"};
// viscosity in stages
inline constexpr Tolerance kStagedFine{1e-3, 1e-3,
                                       "of the largest speed; both forms are of first order in the sub-step"};
inline constexpr Tolerance kStagedCoarse{0.05, 0.05, "as above, one sub-step instead of forty"};
inline constexpr Tolerance kStagedMomentum{2e-5, 1e-6, "pair forces are equal and opposite; read through float"};
inline constexpr Tolerance kStokesBalance{0.02, 0.02, "of the force that drives the flow"};
inline constexpr Tolerance kStokesDrag{0.15, 0.15, "of Hasimoto's drag for a sphere of radius 4 dx"};
inline constexpr Tolerance kSteadyPull{0.01, 0.01, "of the force, from step to step: below what a hand tells apart"};
inline constexpr Tolerance kLinearDrag{0.1, 0.1, "of the force: the slower tool has not come as far"};
// surface tension
inline constexpr Tolerance kLaplace{0.25, 0.25,
                                    "of 2 sigma / R: the share that pressure leaves is one number for all supports"};
inline constexpr Tolerance kGauge{0.35, 0.35,
                                  "of 2 sigma / R: as above, and from place to place 1 % of the attraction's 400 Pa"};
inline constexpr Tolerance kRoundness{0.05, 0.05, "longest over shortest axis of inertia"};
inline constexpr Tolerance kDropRadius{0.05, 0.05, "of the radius"};
inline constexpr Tolerance kAngularMomentum{1e-4, 1e-5, "central forces; positions and velocities of different times"};
inline constexpr Tolerance kLayerPressure{0.025, 0.025, "of the pressure at the bottom; measured 0.020 at 1:1000"};
inline constexpr Tolerance kLayerSpeed{0.03, 0.03, "of sqrt(g H); measured 0.019 at 1:100"};
inline constexpr Tolerance kDropFall{
    0.1, 0.1, "of the way in 0.1 s; the fluid below has a thousandth of its weight, and nowhere to go"};
inline constexpr Tolerance kRestingNoise{0.002, 0.002,
                                         "N, rms: 0.05 % of the lift of 4.4 N, half of it the waves of the start"};
// heat, reference C and D17
inline constexpr Tolerance kHeatProfile{0.02, 0.02, "of the temperature difference that drives it"};
inline constexpr Tolerance kRoundHeat{0.04, 0.04, "as above, over a curved surface made of cells"};
inline constexpr Tolerance kHeatAtPlane{0.004, 0.004, "as above, of a lattice half a spacing above what is held"};
inline constexpr Tolerance kDisorderedHeat{0.05, 0.05, "as above, particles off their lattice by up to a fifth of dx"};
inline constexpr Tolerance kMovedHeat{1e-3, 1e-3, "of the same: places in a step are rounded, and lists made anew"};
inline constexpr Tolerance kHeatDecay{0.02, 0.02, "of the decay rate of a sine of 20 particles"};
inline constexpr Tolerance kMeltFront{1.0, 1.0, "of a spacing: the front is smeared over the particles that melt"};
inline constexpr Tolerance kMeltSlope{0.03, 0.03, "of the front's slope over sqrt(t)"};
inline constexpr Tolerance kHeatKept{1e-7, 1e-7,
                                     "pair fluxes are equal and opposite up to round-off; read through float"};
inline constexpr Tolerance kHeatGiven{5e-6, 5e-7, "as above over hundreds of steps; of the heat given"};
inline constexpr Tolerance kPlaneLoss{0.01, 0.01, "of the rate: the surface of a lattice is calibrated"};
inline constexpr Tolerance kCubeLoss{0.06, 0.06, "of the rate: edges and corners of a cube"};
// changes of state
inline constexpr Tolerance kBondedMotion{2e-3, 1e-6,
                                         "of a spacing after 200 steps: positions, not displacements, are the state"};
inline constexpr Tolerance kChangeMomentum{
    1e-4, 1e-6, "of the sum of the sizes after 1200 steps: rotations are converged to 1e-6 rad"};
inline constexpr Tolerance kChangeEnergy{1e-3, 1e-3, "of the kinetic energy at the start: none is added"};
inline constexpr Tolerance kChangeJump{
    0.03, 0.03,
    "of the force, from one step to the next, when all freezes and melts in a quarter "
    "of a second each, in 25 changes: slower ones jump in proportion less"};
inline constexpr Tolerance kRigidShape{1e-5, 1e-5, "of a spacing: places up to 0.3 m are rounded to 3e-8 m"};
inline constexpr Tolerance kRigidEnergy{1e-3, 1e-3,
                                        "of the kinetic energy, over a turn or less: first moments in real"};
inline constexpr Tolerance kFreeFall{2e-6, 1e-12, "symplectic Euler of a constant acceleration, 1000 steps"};
inline constexpr Tolerance kTopEnergy{1e-4, 1e-4, "relative, over 60 s at 1 ms"};
inline constexpr Tolerance kTopFlip{0.5, 0.12,
                                    "s; round-off in float shifts the logarithm of the distance from the axis"};
inline constexpr Tolerance kElasticGradient{2e-5, 1e-12, "of an affine field; displacements of ten spacings in real"};
inline constexpr Tolerance kSectionStiffness{0.04, 0.04, "of E I or G J: bars of four spacings and more"};
inline constexpr Tolerance kSectionFrequency{0.02, 0.02, "of the frequency: half of what stiffness may err by"};
inline constexpr Tolerance kTwistFrequency{
    0.05, 0.05, "of the frequency: n layers of points have 1 - 1/n^2 of a section's polar inertia, 3 % at four"};
inline constexpr Tolerance kSolversFrequency{4e-3, 4e-3, "of the frequency: their sub-steps differ"};
inline constexpr Tolerance kElasticForce{2e-4, 1e-9, "of E dx^2 or of the exact force; strains in real"};
inline constexpr Tolerance kElasticMomentum{3e-6, 1e-13, "of the sum of the sizes"};
inline constexpr Tolerance kFarAtRest{2e-5, 1e-11,
                                      "m/s; lengths of a body in real, over a spacing, at the speed of sound"};
inline constexpr Tolerance kElasticSlope{3e-4, 1e-6, "of the largest force; central difference in double"};
inline constexpr Tolerance kImplicitSlope{2e-3, 1e-6, "of the largest; differences of strains of 1e-3, 1e-6 in double"};
inline constexpr Tolerance kImplicitEnergy{
    1e-3, 1e-3, "of the energy: velocities are those of half a step before, (w dt)^2 = 4e-4 of a turn's, and rounding"};
inline constexpr Tolerance kImplicitMomentum{
    1e-6, 1e-7, "of the momentum: rounding of places once a step, and snapshots are in single precision"};
inline constexpr Tolerance kImplicitShape{1e-4, 1e-4, "of the size: strains by the spin are 2e-6, and rounding"};
inline constexpr Tolerance kImplicitSagging{
    0.01, 0.01,
    "of the weight or what it stretches; a step damps vibrations to nothing, and what rounds leave is 1e-4"};
inline constexpr Tolerance kImplicitPush{0.02, 0.02,
                                         "of the friction; the stick leans on the block and lifts a little"};
inline constexpr Tolerance kSlidingFriction{0.15, 0.15, "of the weight, a step's friction over Coulomb's: 0.03 found"};
inline constexpr Tolerance kBreakLoose{
    0.05, 0.05, "of the impulse of friction; what begins to slip holds on like a spring to the end of that step"};
inline constexpr Tolerance kCrumbFall{1e-4, 1e-4, "m/s after 0.2 s; nothing may strain what has no extent"};
inline constexpr Tolerance kPlateSag{0.05, 0.05, "of the sag, reference D11"};
inline constexpr Tolerance kPlatePeriod{0.05, 0.05, "of the period, reference D12"};
inline constexpr Tolerance kCsm3{0.05, 0.05, "of Turek & Hron's values, as for the plate, reference D11"};
inline constexpr Tolerance kYoung{0.02, 0.02, "of E, reference D9"};
inline constexpr Tolerance kPoisson{0.02, 0.02, "of nu, as for E"};
inline constexpr Tolerance kWaveSpeed{0.05, 0.05,
                                      "of sqrt(E / rho): a pulse of thirty spacings in a bar of three across"};
inline constexpr Tolerance kBulkWaveSpeed{
    0.02, 0.02, "of the speed: the discrete wave of a pulse of thirty spacings is 1.5 % late (reference D13)"};
inline constexpr Tolerance kElasticStatics{0.03, 0.03,
                                           "of the stretch over 16 layers: the strain's step at the clamp is smoothed"};
inline constexpr Tolerance kSettled{0.01, 0.01, "of the force in the end, from 0.2 s after the tool has stopped"};
inline constexpr Tolerance kPlasticStress{1e-3, 1e-9, "of the yield stress: strains in real, times E over it"};
inline constexpr Tolerance kPlasticEnergy{5e-3, 1e-8, "of s_y^2 / E, where many times that is stored"};
inline constexpr Tolerance kPlasticStrain{1e-4, 1e-10, "of a strain: hundreds of steps in real"};
inline constexpr Tolerance kPlasticVolume{2e-6, 1e-13, "determinant, put right at each step"};
inline constexpr Tolerance kPlasticCurve{3e-4, 1e-9, "of the yield stress times the section; displacements in real"};
inline constexpr Tolerance kPlasticForce{3e-3, 1e-7, "of the yield stress times dx^2: differences of strains in real"};
inline constexpr Tolerance kElasticEnergy{
    0.1, 0.1, "of the energy: symplectic Euler's ripple, and the hourglass control's share"};
inline constexpr Tolerance kEnergyGain{
    1.5e-2, 1.5e-2, "of the energy at the start: the hourglass control's share is not counted, and ripples"};
inline constexpr Tolerance kBurstGain{5e-2, 5e-2,
                                      "of the energy at the start, once bits fly free; in torn, flat neighbourhoods "
                                      "the hourglass force is no exact gradient"};
inline constexpr Tolerance kRotation{2e-5, 1e-10, "orthonormality and optimality after convergence"};
inline constexpr Tolerance kFrictionlessSlide{0.01, 0.01, "of the way; the block settles on the plate at first"};
inline constexpr Tolerance kFrictionSlide{0.02, 0.02, "of the way, reference D14 and D16"};
inline constexpr Tolerance kRolling{1e-3, 1e-3, "of the speed: it follows from the body's inertia alone"};
inline constexpr Tolerance kRollingBumps{
    1e-5, 1e-5, "of the radius: a tenth of a micrometre of 5 cm is some bits of a place in float"};
inline constexpr Tolerance kRollingSwing{5e-3, 5e-3, "of the swing over five periods, sampled each millisecond"};
inline constexpr Tolerance kRestitution{0.02, 0.02,
                                        "of the speed, reference D16; the moment of arrival matters a little"};
inline constexpr Tolerance kToolRestitution{0.05, 0.05,
                                            "of the speed: its stiffer contact depends more on the moment of arrival"};
inline constexpr Tolerance kContactMomentum{1e-6, 1e-12, "of the sum of |m v|, reference D16: one force, two signs"};
inline constexpr Tolerance kContactSpin{3e-5, 1e-11, "of the sum of |L|: places are in float, levers short"};
inline constexpr Tolerance kStackForce{0.01, 0.01, "of the weight, reference D16"};
inline constexpr Tolerance kStackDrift{0.01, 0.01, "of a spacing in 4 s"};
inline constexpr Tolerance kFrictionAngle{0.02, 0.02, "of mu, reference D16: it holds so far below and slips above"};
inline constexpr Tolerance kPlateOnLayer{0.05, 0.05, "of the depth: the outermost of four or eight layers strain less"};
inline constexpr Tolerance kBallOnLayer{0.05, 0.05, "of the force; 0.048 found, over a corner of cells or a particle"};
inline constexpr Tolerance kReactionOfFloor{5e-3, 5e-3,
                                            "of the force: what the ball feels is the floor's, once all rests"};
inline constexpr Tolerance kForceBySubStep{5e-3, 5e-3, "of the force, with sub-steps half and a quarter as long"};
inline constexpr Tolerance kPlateRests{1e-3, 1e-3, "of the depth, after 1.5 s: it must not bounce on its contacts"};
inline constexpr Tolerance kSwitchedDrag{0.03, 0.03,
                                         "of the drag, on either side of a choice: half of what a hand tells apart"};
inline constexpr Tolerance kSwitchedPress{0.03, 0.03, "likewise, of a contact's force"};
inline constexpr Tolerance kSwitchedSolver{
    0.02, 0.02, "of the force: the two elastic solvers differ by their sub-steps alone; measured 0.009"};
inline constexpr Tolerance kReaction{
    1e-3, 1e-3, "of its rms: what a clamp bears is what the body loses, but that levers change within a step"};
inline constexpr Tolerance kSleepStirred{0.005, 0.005, "of the force: what sleeps is out of reach of what is stirred"};
inline constexpr Tolerance kSleepWoken{
    0.07, 0.07, "of the force in fluid that slept: less than a hand notices; its particles begin from other places"};
inline constexpr Tolerance kSleepFoot{
    0.02, 0.02, "of the largest force on what a body is bonded to: at most sleep_speed is taken from it at once"};
inline constexpr Tolerance kContactEnergy{1e-4, 1e-4, "of what the bodies began with: bounces end within a sub-step"};
inline constexpr Tolerance kCarried{0.05, 0.05,
                                    "of the weight, over a second in which a ball may still hop by a millimetre"};
inline constexpr Tolerance kSoftSlide{0.02, 0.02, "of the acceleration, reference D16"};
inline constexpr Tolerance kSoftMomentum{5e-5, 1e-6,
                                         "of the sum of |m v|: rounding of the block's own forces; measured to 2e-5"};
inline constexpr Tolerance kSoftSpin{1e-4, 1e-4, "of |m v| times 10 cm, as above; the box's own is read at mid-step"};
inline constexpr Tolerance kRipple{1e-3, 1e-3, "of the normal force, reference D19"};
inline constexpr Tolerance kRippleOfContact{
    2e-3, 1e-3, "as above, before hand and tool smooth it: the last bit of a place in float is 0.05 % of 5 N"};
inline constexpr Tolerance kLatticeLine{1e-3, 1e-3, "of the normal force, as for the ripple that it is part of"};
inline constexpr Tolerance kSoftLatticeLine{0.01, 0.01, "of the normal force, reference D19 at 5 N"};
inline constexpr Tolerance kSoftLatticeLineAlong{
    0.05, 0.05, "as above, row upon row of balls at once: half of what a hand tells apart, reference D20"};
inline constexpr Tolerance kDistance{3e-7, 1e-12, "m, of solids a metre large"};
inline constexpr Tolerance kCouplingForce{1e-4, 1e-9, "of the weight of the tool"};
inline constexpr Tolerance kSampledSpring{0.05, 0.05, "of the bound, which is that of slow oscillations"};
inline constexpr Tolerance kCouplingEnergy{2e-3, 1e-3, "first-order time integration of the device's motion"};
}  // namespace tol

}  // namespace palp::test
