// The books of a simulation: whether energy was created or momentum lost while it ran.
#pragma once

#include <string>
#include <vector>

#include "sim_server/solver/plan.h"
#include "sim_server/solver/simulation.h"

namespace palp::stability {

// The quantities that must stay bounded, each over its bound: up to 1 holds.
struct Balance {
  double energy = 0;    // the largest so far of energy created over what may be
  double momentum = 0;  // the largest so far of momentum that came from nowhere over what may
  double heat = 0;      // likewise for the temperatures outside the range of the start
};

// Energy. Counted are kinetic and potential energy of all that moves, what elastic bodies have stored, less what
// pushes on their faces have given to it, taken as there from the first (contact_energy()), and what fluid has stored
// by compression. Of a push that grew with the strain that leaves out twice what it gave, so that while it lasts as
// much could be made unseen; once it has gone nothing is left out. Energy that is not known (springs of contact, bonds
// of matter that changes state, elastic bodies of method "paper") is not negative and none at the start, so that it
// can only hide a loss. What fluid with surface tension can release is at most the tension times its first surface;
// what begins at the surface of a solid is pushed away by it. So with the work of the hands, which the simulation
// reports, counted energy may grow by no more than the work and what these release; conduction of heat does no work,
// and no scene of the map has moving walls. Allowed beside that is kCreated of all energy that was turned over, and
// the agitation that books.cpp names.
//
// Strain and velocity are half a sub-step apart. What symplectic Euler keeps of a vibration is their energy less half a
// sub-step times the power between the two, which for matter that swings with the frequency w is at most w sqrt(K S), K
// and S being its kinetic and stored energy. So w dt sqrt(K S) is allowed, too, with the frequency at which a wave goes
// a radian in a spacing: a block of 168 m/s that shook at half the limit seemed to gain nine tenths of its energy
// within a millisecond, and nothing with a tenth of the limit.
//
// Momentum, of all that moves but tools: it changes by weight and by the opposite of what tools and fixed bodies report
// to feel. Allowed is kLost of all impulses and of the momenta that the agitation may have. Where a tool can meet a
// fixed body momentum is not looked at: the tool's step is implicit in that contact, and the fixed body reports only
// the explicit part. Once something has left the domain, where solids are stopped, it is not looked at any more.
//
// Temperatures stay between the lowest and the highest of the start: nothing in the map heats but by conduction.
class Books {
 public:
  // Opens the books of a simulation that has not stepped yet, by its plan.
  Books(Simulation& simulation, const Plan& plan);
  // Notes the impulses of the step that was just made.
  void note(const StepOutput& output);
  // Looks at the whole state. Costs a snapshot.
  void check(const StepOutput& output);
  const Balance& balance() const { return balance_; }

 private:
  struct Sums {
    double kinetic = 0, potential = 0, stored = 0;
    double swing = 0;    // what the energy that is counted may be off by while waves pass [J]
    double momenta = 0;  // sum of |m v|
    Eigen::Vector3d momentum = Eigen::Vector3d::Zero();
  };
  Sums sums(const StepOutput& output);
  void add_particles(std::size_t body, Sums& out);
  double compression(std::size_t particle, double density) const;
  double stored_by_pushing(std::size_t body) const;
  double stored_by_guard() const;
  void check_heat();

  // Sets the masses of particles, which are those of the start: a fluid that begins under its own weight is denser.
  void weigh(double sound_speed);
  void follow_waves(const Plan& plan);

  Simulation& simulation_;
  const Scene& scene_;
  double sound_speed_;  // [m/s]
  Snapshot snapshot_;
  std::vector<bool> tool_;       // by body
  std::vector<double> waves_;    // by body: the way of a wave in a sub-step, in spacings
  std::vector<double> mass_of_;  // of particles [kg]
  std::vector<double> gone_;     // energy of particles when they were last seen within the domain [J]
  double mass_ = 0;              // of what moves but tools [kg]
  double sub_step_ = 0;          // [s]
  double fluid_step_ = 0;        // that fluids take at once [s]
  double fastest_ = 0;           // speed so far [m/s]
  double noise_ = 0;             // energy of the agitation that is allowed [J]
  double agitation_ = 0;         // its momenta [N s]
  double released_ = 0;          // by surfaces and by fluid that begins at solids, at most [J]
  Sums start_, last_;
  double turned_over_ = 0;               // potential energy that came and went [J]
  double work_ = 0, work_absolute_ = 0;  // of the hands [J]
  double last_work_ = 0;
  Eigen::Vector3d impulse_ = Eigen::Vector3d::Zero();
  double impulses_ = 0;  // sum of absolute values [N s]
  double time_ = 0, coldest_ = 0, hottest_ = 0;
  bool closed_ = true;  // nothing has left the domain
  Balance balance_;
};

}  // namespace palp::stability
