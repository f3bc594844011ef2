// The text of palp.idl, for files and tools that describe the wire types to others.
#pragma once

namespace palp {

extern const char* const kPalpIdlText;

}  // namespace palp
