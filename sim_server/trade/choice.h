// --budget and --error: a simulation whose spacing and numerics are chosen by what was measured.
#pragma once

#include <memory>
#include <string>

#include "config/json_file.h"
#include "sim_server/solver/simulation.h"
#include "sim_server/trade/measured_choice.h"

namespace palp {

// Reads the table of this machine's class, or the nearest one, chooses, times candidates for about a second, and
// returns the simulation of the chosen one in its initial state; its scene's config.choice says what was chosen and
// what is expected. overrides: what the command line gave beside the request; a spacing or a level must not be among
// it. Throws ConfigError, or std::runtime_error when the back end cannot serve or a candidate diverges.
std::unique_ptr<Simulation> choose_simulation(const std::string& scene_file, const SceneOverrides& overrides,
                                              Backend backend, const ChoiceRequest& request);

// One line for people: what was chosen, for what, by what, and the options that give the same again.
std::string told(const NumericsChoice& choice);

// Null where nothing was chosen.
Json json_of(const std::shared_ptr<const NumericsChoice>& choice);

}  // namespace palp
