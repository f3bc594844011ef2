// Messages as the bytes that stand on the wire and in recordings, without a DDS vendor: an RTPS SerializedPayload, 4
// bytes of encapsulation header and then plain little-endian XCDR1 of palp.idl. The lists of fields.h, whose order is
// that of palp.idl, say what is written; tests/idl holds the bytes against those of both vendors.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "idl/topics.h"
#include "idl/validate.h"

namespace palp {

// to_cdr returns the payload of a message whose header is filled in. from_cdr reads a payload, trusts no byte of it and
// judges what it holds as a reader of the bus does; unless it returns Fault::none, out holds nothing of use. Giving the
// same out again and again keeps its memory.
// NOLINTBEGIN(bugprone-macro-parentheses): T is a type
#define PALP_CDR(T)                             \
  std::vector<std::uint8_t> to_cdr(const T& m); \
  Fault from_cdr(std::span<const std::uint8_t> payload, T& out);
PALP_FOR_EACH_MESSAGE(PALP_CDR)
#undef PALP_CDR
// NOLINTEND(bugprone-macro-parentheses)

}  // namespace palp
