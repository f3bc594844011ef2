// toml++ as the reader needs it. Only for sources of config/ that work on its tables.
#pragma once

// In builds without NDEBUG it would end the process at some malformed keys, which its parser then refuses.
#define TOML_ASSERT(expr) static_cast<void>(0)
#include <toml++/toml.h>
