#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "config/looks.h"
#include "config/parameter_ranges.h"
#include "config/scene_reader.h"
#include "config/text_file.h"

namespace palp {

namespace {

constexpr Range kLength{"m", 0, 1e9, true};

const std::vector<std::string> kBodyTypes(kBodyKindNames.begin(), kBodyKindNames.end());
const std::vector<std::string> kShapeTypes{"box", "sphere", "cylinder", "mesh", "particles"};
constexpr double kPi = 3.14159265358979323846;

template <class Item>
std::vector<std::string> names_of(const std::vector<Item>& items) {
  std::vector<std::string> names;
  names.reserve(items.size());
  for (const Item& item : items) names.push_back(item.name);
  return names;
}

// Keys that only some shapes have: each is needed by its shapes and refused on the others.
struct ShapeKey {
  const char* key;
  std::vector<ShapeType> shapes;
  bool required;
};
const std::vector<ShapeKey> kShapeKeys{
    {"size", {ShapeType::box}, true},        {"radius", {ShapeType::sphere, ShapeType::cylinder}, true},
    {"height", {ShapeType::cylinder}, true}, {"file", {ShapeType::mesh, ShapeType::particles}, true},
    {"scale", {ShapeType::mesh}, false},
};

// The values of a shape whose type is not known are judged, too, but not whether it has the right ones.
void read_shape_keys(TomlTable& table, const SceneConfig& scene, bool known_type, ShapeConfig& shape) {
  const auto need = [&](const char* key) {
    if (!known_type) return Need::optional;
    const auto& row = *std::find_if(kShapeKeys.begin(), kShapeKeys.end(),
                                    [&](const ShapeKey& item) { return std::string_view(item.key) == key; });
    const bool applies = std::find(row.shapes.begin(), row.shapes.end(), shape.type) != row.shapes.end();
    if (!applies && table.has(key)) {
      table.fault(key,
                  fmt::format("{} does not apply to a {}", key, kShapeTypes[static_cast<std::size_t>(shape.type)]));
    }
    return applies && row.required ? Need::required : Need::optional;
  };
  if (const auto size = table.numbers("size", 3, kLength, need("size")))
    shape.size = {(*size)[0], (*size)[1], (*size)[2]};
  shape.radius = table.number("radius", kLength, need("radius")).value_or(0);
  shape.height = table.number("height", kLength, need("height")).value_or(0);
  const std::string file = table.text("file", need("file")).value_or("");
  if (!file.empty()) shape.file = resolve_beside(scene.path, file);
  need("scale");
  shape.scale = table.number("scale", {"m per unit of the file", 0, 1e9, true}).value_or(1);
}

ShapeConfig read_shape(TomlTable& table, const SceneConfig& scene) {
  ShapeConfig shape;
  shape.where = table.where();
  const auto type = table.choice("type", kShapeTypes, Need::required);
  if (type) shape.type = static_cast<ShapeType>(*type);
  read_shape_keys(table, scene, type.has_value(), shape);
  shape.position = read_vector(table, "position", "m", shape.position);
  shape.orientation = read_orientation(table);
  shape.subtract = table.boolean("subtract").value_or(false);
  return shape;
}

void read_shapes(TomlTable& table, const SceneConfig& scene, BodyConfig& body) {
  std::vector<TomlTable> shapes = table.tables("shape");
  for (TomlTable& item : shapes) {
    body.shapes.push_back(read_shape(item, scene));
    const ShapeConfig& shape = body.shapes.back();
    if (body.shapes.size() == 1 && shape.subtract) {
      item.fault("subtract", "subtract is true on the first shape, expected a shape to subtract from before it");
    }
    if (shape.type == ShapeType::particles && shapes.size() > 1) {
      item.fault("type", "type is \"particles\" among other shapes, expected it to be the body's only shape");
    }
  }
  if (shapes.empty()) table.fault("", "shape is missing, expected at least one shape under [[body.shape]]");
}

// Reads bonded_to, the bodies that an elastic body holds on to, which are declared before it; a fluid that can become
// elastic may hold on, too. Checks that the material of an elastic body gives a stiffness.
void read_elastic(TomlTable& table, const SceneConfig& scene, const std::optional<std::size_t>& type,
                  BodyConfig& body) {
  body.bonded_to = table.texts("bonded_to");
  const auto material = std::find_if(scene.materials.begin(), scene.materials.end(),
                                     [&](const MaterialConfig& item) { return item.name == body.material; });
  const bool stiff = material != scene.materials.end() && material->young_modulus;
  if (type && body.type == BodyKind::elastic && material != scene.materials.end() && !stiff) {
    table.fault("material",
                fmt::format("material '{}' has no young_modulus, expected one for an elastic body", material->name));
  }
  if (type && !body.bonded_to.empty() && body.type != BodyKind::elastic && !(body.type == BodyKind::fluid && stiff)) {
    table.fault("bonded_to", "bonded_to is given, but only an elastic body has it, or a fluid that can become one");
  }
  for (const std::string& name : body.bonded_to) {
    const auto other = std::find_if(scene.bodies.begin(), scene.bodies.end(),
                                    [&](const BodyConfig& item) { return item.name == name; });
    if (other == scene.bodies.end() || (other->type != BodyKind::rigid && other->type != BodyKind::fixed)) {
      table.fault("bonded_to",
                  fmt::format("'{}' in bonded_to is no rigid or static body declared before this one", name));
    }
  }
}

BodyConfig read_body(TomlTable& table, const SceneConfig& scene) {
  BodyConfig body;
  body.where = table.where();
  body.name = read_name(table, "body", names_of(scene.bodies), false);
  const auto type = table.choice("type", kBodyTypes, Need::required);
  if (type) body.type = static_cast<BodyKind>(*type);
  body.material = table.text("material", Need::required).value_or("");
  const std::vector<std::string> materials = names_of(scene.materials);
  if (!body.material.empty() && std::find(materials.begin(), materials.end(), body.material) == materials.end()) {
    const std::string near = nearest_name(body.material, materials);
    table.fault("material", fmt::format("material '{}' is not declared, expected the name of a [[material]]{}",
                                        body.material, near.empty() ? "" : "; did you mean '" + near + "'?"));
  }
  body.position = read_vector(table, "position", "m", body.position);
  body.orientation = read_orientation(table);
  body.velocity = read_vector(table, "velocity", "m/s", body.velocity);
  body.angular_velocity = read_vector(table, "angular_velocity", "rad/s", body.angular_velocity);
  if (type && body.type != BodyKind::rigid && !body.angular_velocity.isZero(0)) {
    table.fault("angular_velocity", "angular_velocity is given, but only a rigid body has one");
  }
  body.temperature = table.number("temperature", {"K", 0, 1e5});
  if (table.has("temperature") && !body.temperature) body.temperature = 0;  // wrong, but the body has one
  read_elastic(table, scene, type, body);
  body.color = table.color("color");
  body.look = read_look(table, "look");
  read_shapes(table, scene, body);
  body.hold_temperature = read_hold_temperature(table, body);
  return body;
}

CouplingGains read_coupling_limit(TomlTable table) {
  CouplingGains limit = kDefaultGains;
  limit.stiffness = table.number("stiffness", not_negative("N/m")).value_or(limit.stiffness);
  limit.damping = table.number("damping", not_negative("N s/m")).value_or(limit.damping);
  limit.angular_stiffness =
      table.number("angular_stiffness", not_negative("N m/rad")).value_or(limit.angular_stiffness);
  limit.angular_damping = table.number("angular_damping", not_negative("N m s/rad")).value_or(limit.angular_damping);
  return limit;
}

// Beyond its yield stress an elastic body flows, beyond its tear strain it rips.
void read_plastic_keys(TomlTable& table, MaterialConfig& material) {
  material.yield_stress = table.number("yield_stress", range_of("material.yield_stress"));
  material.hardening = table.number("hardening", range_of("material.hardening")).value_or(material.hardening);
  if (table.has("hardening") && !table.has("yield_stress"))
    table.fault("hardening", "hardening is given without yield_stress, expected both or only yield_stress");
  material.tear_strain = table.number("tear_strain", range_of("material.tear_strain"));
  for (const char* key : {"yield_stress", "tear_strain"}) {
    if (table.has(key) && !table.has("young_modulus"))
      table.fault(key, fmt::format("{} is given without young_modulus, expected one in Pa", key));
  }
}

}  // namespace

const BodyConfig* read_body_name(TomlTable& table, const SceneConfig& scene, Need need) {
  const auto name = table.text("body", need);
  if (!name) return nullptr;
  for (const BodyConfig& body : scene.bodies) {
    if (body.name == *name) return &body;
  }
  const std::string near = nearest_name(*name, names_of(scene.bodies));
  table.fault("body", fmt::format("body '{}' is not declared, expected the name of a [[body]]{}", *name,
                                  near.empty() ? "" : "; did you mean '" + near + "'?"));
  return nullptr;
}

Eigen::Vector3d read_vector(TomlTable& table, std::string_view key, const char* unit, const Eigen::Vector3d& fallback,
                            Need need) {
  return read_vector(table, key, Range{unit, -1e9, 1e9}, fallback, need);
}

Eigen::Vector3d read_vector(TomlTable& table, std::string_view key, const Range& range, const Eigen::Vector3d& fallback,
                            Need need) {
  const auto values = table.numbers(key, 3, range, need);
  return values ? Eigen::Vector3d((*values)[0], (*values)[1], (*values)[2]) : fallback;
}

Eigen::Quaterniond read_orientation(TomlTable& table) {
  const auto values = table.numbers("orientation", 4, {"", -1.001, 1.001});
  Eigen::Quaterniond orientation = Eigen::Quaterniond::Identity();
  if (values) {
    orientation = Eigen::Quaterniond((*values)[3], (*values)[0], (*values)[1], (*values)[2]);
    if (std::abs(orientation.norm() - 1) > 1e-3) {
      table.fault("orientation", fmt::format("orientation has length {:g}, expected a unit quaternion [x, y, z, w]",
                                             orientation.norm()));
      orientation.setIdentity();
    }
    orientation.normalize();
  }
  if (!table.has("rotation_deg")) return orientation;
  if (values) table.fault("rotation_deg", "both orientation and rotation_deg are given, expected one of them");
  TomlTable rotation = table.table("rotation_deg");
  const Eigen::Vector3d axis = read_vector(rotation, "axis", "", Eigen::Vector3d::UnitZ(), Need::required);
  const double angle = rotation.number("angle", {"degrees", -360, 360}, Need::required).value_or(0);
  if (axis.norm() < 1e-9) {
    rotation.fault("axis", "axis has no length, expected a direction");
    return orientation;
  }
  return Eigen::Quaterniond(Eigen::AngleAxisd(angle * kPi / 180, axis.normalized()));
}

std::string read_name(TomlTable& table, const std::string& kind, const std::vector<std::string>& taken,
                      bool file_name) {
  const auto name = table.text("name", Need::required);
  if (!name) return {};
  table.set_title(fmt::format("{} '{}'", kind, name->substr(0, 64)));
  const auto fits = [&](char c) {
    const auto u = static_cast<unsigned char>(c);
    return std::isalnum(u) || c == '_' || c == '-' || (!file_name && (c == ' ' || c == '.' || u >= 128));
  };
  if (name->size() > 64 || !std::all_of(name->begin(), name->end(), fits)) {
    table.fault("name", fmt::format("name is \"{}\", expected at most 64 {}", name->substr(0, 64),
                                    file_name ? "letters, digits, - and _ (it names a file)"
                                              : "letters, digits, blanks, dots, - and _"));
  } else if (std::find(taken.begin(), taken.end(), *name) != taken.end()) {
    table.fault("name", fmt::format("name is taken by another {}, expected a name of its own", kind));
  }
  return *name;
}

namespace {

void read_contact(TomlTable& table, MaterialConfig& material) {
  const auto friction = table.number("friction", range_of("material.friction")),
             kinetic = table.number("kinetic_friction", range_of("material.kinetic_friction"));
  material.friction = friction.value_or(material.friction);
  material.kinetic_friction = kinetic.value_or(material.friction);
  material.restitution = table.number("restitution", range_of("material.restitution")).value_or(material.restitution);
  const bool known = friction || !table.has("friction");
  if (known && material.kinetic_friction > material.friction) {
    table.fault("kinetic_friction", fmt::format("kinetic_friction is {}, expected at most friction, which is {}",
                                                material.kinetic_friction, material.friction));
  }
}

}  // namespace

void read_materials(TomlTable& root, SceneConfig& scene) {
  for (TomlTable& table : root.tables("material")) {
    MaterialConfig material;
    material.where = table.where();
    material.name = read_name(table, "material", names_of(scene.materials), false);
    material.density = table.number("density", range_of("material.density"), Need::required).value_or(material.density);
    material.viscosity = table.number("viscosity", range_of("material.viscosity")).value_or(material.viscosity);
    material.surface_tension = table.number("surface_tension", range_of("material.surface_tension")).value_or(0);
    material.adhesion = table.number("adhesion", range_of("material.adhesion")).value_or(0);
    material.young_modulus = table.number("young_modulus", range_of("material.young_modulus"));
    material.poisson_ratio =
        table.number("poisson_ratio", range_of("material.poisson_ratio")).value_or(material.poisson_ratio);
    material.damping = table.number("damping", range_of("material.damping")).value_or(material.damping);
    read_plastic_keys(table, material);
    read_contact(table, material);
    read_heat_keys(table, material);
    material.color = table.color("color");
    material.look = read_look(table, "look");
    material.changed_look = read_look(table, "changed_look");
    check_changed_look(material);
    scene.materials.push_back(material);
  }
}

void read_bodies(TomlTable& root, SceneConfig& scene) {
  for (TomlTable& table : root.tables("body")) scene.bodies.push_back(read_body(table, scene));
  if (!root.has("body")) root.fault("", "the scene has no [[body]], expected at least one");
}

void read_proxies(TomlTable& root, SceneConfig& scene) {
  for (TomlTable& table : root.tables("proxy")) {
    ProxyConfig proxy;
    proxy.where = table.where();
    proxy.device = static_cast<unsigned>(table.integer("device", 0, 7).value_or(0));
    if (const BodyConfig* body = read_body_name(table, scene, Need::required)) {
      proxy.body = body->name;
      if (body->type != BodyKind::rigid) {
        table.fault("body", fmt::format("body '{}' is {}, expected a rigid body", body->name,
                                        kBodyTypes[static_cast<std::size_t>(body->type)]));
      }
    }
    for (const ProxyConfig& other : scene.proxies) {
      if (other.device == proxy.device) {
        table.fault("device", fmt::format("device {} already drives body '{}', expected one proxy per device",
                                          proxy.device, other.body));
      }
      if (!proxy.body.empty() && other.body == proxy.body) {
        table.fault("body", fmt::format("body '{}' is already the proxy of device {}, expected one device per body",
                                        proxy.body, other.device));
      }
    }
    proxy.hand = table.text("hand").value_or("");
    proxy.handle = read_vector(table, "handle", "m", proxy.handle);
    proxy.coupling_limit = read_coupling_limit(table.table("coupling_limit"));
    scene.proxies.push_back(proxy);
  }
}

}  // namespace palp
