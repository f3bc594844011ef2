// The kinds of refusals that the stability map knows.
#pragma once

#include <string>

namespace palp::stability {

// Returns the kind of cause that a refusal names; empty where it is none that is known, or where it does not say what
// to change.
std::string kind_of_refusal(const std::string& text);

}  // namespace palp::stability
