// Watches whether a run keeps to what its sound speed was chosen for. Single steps tell little: an impact compresses
// for a moment, a drop may fly off. So means over a tenth of a second are judged.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "sim_server/solver/plan.h"
#include "sim_server/solver/simulation.h"

namespace palp {

// The bounds were measured with 20 scenes of config/scenes, most at level fast, some at the others, for 0.3 to 2 s,
// with tools moved at 0.6 m/s; the largest means over 0.1 s, promise being expected_compression():
//   mean compression over the promise: 0.16 to 0.45; with a max_speed of a half and of a third of what the scene
//     reaches 1.65 and 3.2;
//   largest compression: 5.4 % where hot butter meets a pan, 6.8 % in a vortex array that tears at the fluid;
//   largest speed over max_speed: 1.14, but for a cup of batter that a hand moves as fast as max_speed, 1.8.
inline constexpr double kMeanOverPromise = 1;
inline constexpr double kLeastPromise = 0.01;  // taken for the promise of a sound speed that is higher than needed
inline constexpr double kMostCompression = 0.1;
inline constexpr double kMostOverMaxSpeed = 1.25;

class FluidWatch {
 public:
  FluidWatch(const Scene& scene, const Plan& plan);
  void reset();
  // Takes a step's health in and adds what is doubtful from now on: health.doubt, which makes a run unhealthy, and
  // health.notice, which does not. Both stay until reset().
  void judge(Health& health);

 private:
  // A running mean over a number of values.
  class Mean {
   public:
    explicit Mean(std::size_t values) : value_(values, 0.0) {}
    void reset();
    // Takes a value in and returns the mean of the last ones; zero before there are as many.
    double add(double value);

   private:
    std::vector<double> value_;
    double sum_ = 0;
    std::size_t next_ = 0;
    bool full_ = false;
  };
  const Scene& scene_;
  const Plan& plan_;
  Mean mean_compression_, max_compression_, max_speed_;
  std::string doubt_, notice_;
};

}  // namespace palp
