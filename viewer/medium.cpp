#include "viewer/medium.h"

namespace palp {

Medium usual_medium(const BodyDescription& body) {
  if (body.kind != BodyKind::fluid && body.kind != BodyKind::elastic) return Medium::beads;
  return body.look.clear ? Medium::clear : Medium::opaque;
}

bool foams(const BodyDescription& body) {
  return body.kind == BodyKind::fluid && (body.look.foam > 0 || body.changed_look.foam > 0);
}

bool changes_look(const BodyDescription& body) {
  return body.changed_color != body.color || body.changed_look != body.look;
}

}  // namespace palp
