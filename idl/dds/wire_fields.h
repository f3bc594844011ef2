// Copies messages (messages.h) to and from their wire types (palp.idl) by the lists of fields.h. The vendors' generated
// types differ in how a field is reached, so who includes this defines PALP_WIRE(object, name) first. Included by
// bus_cyclone.cpp and bus_fastdds.cpp only.
#pragma once

#include <concepts>
#include <type_traits>

#include "idl/fields.h"
#include "idl/topics.h"

#ifndef PALP_WIRE
#error "define PALP_WIRE(object, name) before including wire_fields.h"
#endif

namespace palp {

template <class T, class U>
concept MessageOf = std::same_as<std::remove_const_t<T>, U>;

// NOLINTBEGIN(bugprone-macro-parentheses): T is a type, the rest are names
#define PALP_FIELD(name) op(m.name, PALP_WIRE(w, name));
#define PALP_RENAMED(name, wire_name) op(m.name, PALP_WIRE(w, wire_name));
#define PALP_DERIVED(wire_name, value) op.derived(value, PALP_WIRE(w, wire_name));
#define PALP_MAP(T)                                            \
  template <class Op, MessageOf<T> M, class W>                 \
  void map_fields(Op& op, M& m, W& w) {                        \
    PALP_FIELDS_OF_##T(PALP_FIELD, PALP_RENAMED, PALP_DERIVED) \
  }
PALP_FOR_EACH_PART(PALP_MAP)
PALP_FOR_EACH_MESSAGE(PALP_MAP)
#undef PALP_FIELD
#undef PALP_RENAMED
#undef PALP_DERIVED
#undef PALP_MAP
// NOLINTEND(bugprone-macro-parentheses)

}  // namespace palp
