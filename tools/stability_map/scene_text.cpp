#include "tools/stability_map/scene_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <iterator>
#include <stdexcept>

namespace palp::stability {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3i;

constexpr double kHot = 400, kWarm = 300, kCold = 200;  // [K]
constexpr double kMelting = 350;                        // [K]
constexpr double kInverting = 10;                       // speed of the farthest particle [m/s]
constexpr double kSpin = 100;                           // [rad/s]

std::string text_of(const Vector3d& v) { return fmt::format("[{:.12g}, {:.12g}, {:.12g}]", v.x(), v.y(), v.z()); }

// A body to be written: a box.
struct Part {
  std::string name, material, type;
  Vector3d size, center;  // [m]
  double temperature = kWarm;
  bool held = false;     // its temperature stays
  bool soft = false;     // its particles move each on its own
  bool elastic = false;  // it could hold on to something
};

class Writer {
 public:
  Writer(const Setup& setup, std::string folder, std::string name)
      : s_(setup), folder_(std::move(folder)), name_(std::move(name)), dx_(setup.spacing) {}

  std::string write() {
    plan_parts();
    put("[scene]\nmethod = \"{}\"\naccuracy = \"{}\"\ngravity = [0, 0, {:.9g}]\nrate_hz = {:.12g}\n",
        to_string(s_.method), to_string(s_.level), s_.gravity, s_.rate);
    write_domain();
    write_numerics();
    for (const std::string& material : materials_) text_ += material;
    for (const bool fixed : {true, false})  // bodies hold on to those that stand above them in the file
      for (const Part& part : parts_)
        if ((part.type == "static") == fixed) write_part(part);
    if (s_.has(Module::proxy)) write_proxy();
    for (const Part& part : parts_)
      if (part.type == "static") put("[[probe]]\nname = \"{0}\"\nquantity = \"body\"\nbody = \"{0}\"\n", part.name);
    const std::string path = folder_ + "/" + name_ + ".toml";
    save(path, text_);
    return path;
  }

 private:
  template <class... Args>
  void put(fmt::format_string<Args...> format, Args&&... args) {
    fmt::format_to(std::back_inserter(text_), format, std::forward<Args>(args)...);
  }

  static void save(const std::string& path, const std::string& text) {
    std::ofstream out(path);
    out << text;
    if (!out.flush()) throw std::runtime_error("cannot write '" + path + "'");
  }

  bool warm() const {
    return s_.has(Module::heat) || s_.has(Module::melting) || s_.has(Module::freezing) || s_.has(Module::rigidifying);
  }

  Vector3i cells() const {
    switch (s_.size) {
      case Size::one:
        return {1, 1, 1};
      case Size::line:
        return {3, 1, 1};
      case Size::sheet:
        return {4, 4, 1};
      case Size::block:
        return {4, 4, 3};
      case Size::thousand:
        return {10, 10, 10};
    }
    return {4, 4, 3};
  }

  // Adds a material and returns its name.
  std::string material(const std::string& name, double density, const std::string& more) {
    std::string text =
        fmt::format("[[material]]\nname = \"{}\"\ndensity = {:.9g}\nviscosity = {:.9g}\nfriction = {:.9g}\n", name,
                    density, s_.viscosity, s_.friction);
    if (warm()) text += fmt::format("conductivity = {:.9g}\nheat_capacity = 1000.0\n", s_.conductivity);
    materials_.push_back(text + more);
    return name;
  }

  std::string elastic() const {
    return fmt::format("young_modulus = {:.9g}\npoisson_ratio = {:.9g}\ndamping = {:.9g}\n", s_.young, s_.poisson,
                       s_.damping);
  }

  // Stacks a body of the cell's size on those before it.
  void stack(const std::string& name, const std::string& type, const std::string& more, double temperature = kWarm) {
    const double density = s_.density * (parts_.empty() ? 1 : s_.ratio);
    add(name, type, material(name, density, more), dx_ * cells().cast<double>(), temperature);
    parts_.back().soft = true;
    parts_.back().elastic = more.find("young") != std::string::npos;
  }

  void add(const std::string& name, const std::string& type, const std::string& material, const Vector3d& size,
           double temperature) {
    double gap = dx_;
    if (s_.start == Start::touching || s_.start == Start::bonded) gap = 0;
    if (s_.start == Start::overlapping) gap = -0.5 * dx_;
    const bool same = s_.start == Start::coincident && !parts_.empty();
    const double bottom = same ? parts_.front().center.z() - 0.5 * parts_.front().size.z() : top_ + gap;
    Part part;
    part.name = name;
    part.type = type;
    part.material = material;
    part.size = size;
    part.center = {0, 0, bottom + 0.5 * size.z()};
    part.temperature = temperature;
    top_ = std::max(top_, bottom + size.z());
    parts_.push_back(part);
  }

  void add_rigid(const std::string& name) {
    const double edge = std::clamp(s_.mass > 0 ? std::cbrt(s_.mass / 2000) : 0, 2 * dx_, 6 * dx_);
    const Vector3d size = s_.size == Size::one ? Vector3d::Constant(dx_) : Vector3d::Constant(edge);
    const double density = s_.mass > 0 ? s_.mass / size.prod() : 2000;
    add(name, "rigid", material(name, density, ""), size, kWarm);
  }

  void plan_parts() {
    const std::string changing = elastic() + fmt::format("melting_temperature = {}\nlatent_heat = 1e4\n", kMelting);
    const auto has = [&](Module m) { return s_.has(m); };
    const bool flows = has(Module::fluid) || has(Module::staged) || has(Module::tension);
    if (flows)
      stack("fluid", "fluid",
            has(Module::tension)
                ? fmt::format("surface_tension = {:.9g}\nadhesion = {:.9g}\n", s_.tension, 0.5 * s_.tension)
                : "");
    if (has(Module::melting)) stack("melting", "fluid", changing);
    if (has(Module::freezing)) stack("freezing", "fluid", changing, kHot);
    if (has(Module::rigidifying))
      stack("rigidifying", "fluid", changing + fmt::format("rigid_below = {}\n", kMelting - 20));
    if (has(Module::plastic))
      stack("plastic", "elastic", elastic() + fmt::format("yield_stress = {:.9g}\n", 0.02 * s_.young));
    if (has(Module::tearing)) stack("tearing", "elastic", elastic() + "tear_strain = 0.1\n");
    if (has(Module::elastic_explicit)) stack("explicit", "elastic", elastic());
    if (has(Module::elastic_implicit)) stack("implicit", "elastic", elastic());
    if (has(Module::rigid)) add_rigid("rigid");
    if (parts_.empty() && !has(Module::proxy)) stack("fluid", "fluid", "");  // heat, a tray or a period, of something
    if (has(Module::proxy)) {
      add_rigid("tool");
      tool_ = parts_.back();
    }
    if (has(Module::fixed))
      add_tray(flows || has(Module::melting) || has(Module::freezing) || has(Module::rigidifying));
  }

  // The inner width of the tray [m].
  double width() const {
    double w = 0;
    for (const Part& part : parts_) w = std::max(w, part.size.x());
    return w + 2 * dx_;
  }
  double thickness() const { return (s_.level == Accuracy::fast && !s_.has(Module::tension) ? 2 : 3) * dx_; }
  // The length of a period: of whole spacings, more than three support radii.
  double period() const { return std::max(10 * dx_, dx_ * std::ceil(width() / dx_ - 1e-9)); }

  void add_tray(bool walls) {
    const double t = thickness(), w = s_.has(Module::periodic) ? period() : width() + 2 * t;
    Part tray;
    tray.name = "tray";
    tray.type = "static";
    tray.material = material("tray", 2000, "");
    tray.held = warm();
    tray.temperature = s_.has(Module::freezing) ? kCold : s_.has(Module::melting) ? 500 : kWarm;
    tray.size = {w, w, t};
    tray.center = {0, 0, -0.5 * t};
    if (walls && !s_.has(Module::periodic)) {
      const double high = dx_ * std::ceil(std::min(top_, 0.5 * w) / dx_ + 1);
      tray.size.z() += high;
      tray.center.z() += 0.5 * high;
      hole_ = {width(), width(), high};
    }
    parts_.push_back(tray);
  }

  void write_domain() {
    const double T = kMostSteps / s_.rate;
    const double far = std::min(3e5 * dx_, 20 * dx_ + 0.5 * std::abs(s_.gravity) * T * T + kInverting * T);
    Vector3d low = Vector3d::Constant(-far), high = Vector3d::Constant(far);
    high.z() += top_;
    if (s_.has(Module::periodic)) {
      low.head<2>().setConstant(-0.5 * period());
      high.head<2>().setConstant(0.5 * period());
    }
    const Vector3d at = Vector3d::Constant(s_.origin);
    put("[domain]\nmin = {0}\nmax = {1}\nperiodic = [{2}, {2}, false]\n", text_of(low + at), text_of(high + at),
        s_.has(Module::periodic));
  }

  void write_numerics() {
    put("[numerics]\nspacing = {:.9g}\nsafety = {:.9g}\n", dx_, s_.safety);
    if (s_.share > 0) put("sub_steps = 1\n");
    if (s_.has(Module::staged) && s_.method == Method::accurate) put("viscosity = \"staged\"\n");
    if (s_.has(Module::elastic_explicit) != s_.has(Module::elastic_implicit))
      put("elastic_solver = \"{}\"\n", s_.has(Module::elastic_explicit) ? "explicit" : "implicit");
  }

  void write_part(const Part& part) {
    put("[[body]]\nname = \"{}\"\ntype = \"{}\"\nmaterial = \"{}\"\nposition = {}\n", part.name, part.type,
        part.material, text_of(part.center + Vector3d::Constant(s_.origin)));
    if (warm()) put("temperature = {}\nhold_temperature = {}\n", part.temperature, part.held);
    if (part.type == "rigid" && s_.start == Start::spinning)
      put("angular_velocity = [{0}, {1}, {0}]\n", 0.3 * kSpin, kSpin);
    if (&part == &parts_.front() && part.elastic && s_.start == Start::bonded && s_.has(Module::fixed))
      put("bonded_to = [\"tray\"]\n");
    if (part.soft && loose()) return write_particles(part);
    put("[[body.shape]]\ntype = \"box\"\nsize = {}\n", text_of(part.size));
    if (part.name != "tray" || hole_.isZero()) return;
    put("[[body.shape]]\ntype = \"box\"\nsize = {}\nposition = [0, 0, {:.12g}]\nsubtract = true\n", text_of(hole_),
        0.5 * (part.size.z() - hole_.z()));
  }

  bool loose() const {
    return s_.start == Start::inverting || s_.start == Start::spinning || s_.start == Start::close ||
           (s_.start == Start::coincident &&
            std::count_if(parts_.begin(), parts_.end(), [](const Part& p) { return p.type != "static"; }) == 1);
  }

  // Writes the particles of a body with velocities of their own.
  void write_particles(const Part& part) {
    const Vector3i n = cells();
    std::string rows = "x,y,z,vx,vy,vz\n";
    const auto row = [&](const Vector3d& x, const Vector3d& v) {
      rows += fmt::format("{:.9g},{:.9g},{:.9g},{:.9g},{:.9g},{:.9g}\n", x.x(), x.y(), x.z(), v.x(), v.y(), v.z());
    };
    const double rate = s_.start == Start::inverting ? -kInverting / (0.5 * part.size.norm()) : 0;
    const Vector3d turn = s_.start == Start::spinning ? Vector3d(0.3 * kSpin, kSpin, 0.3 * kSpin) : Vector3d::Zero();
    for (int k = 0; k < n.z(); ++k)
      for (int j = 0; j < n.y(); ++j)
        for (int i = 0; i < n.x(); ++i) {
          const Vector3d x = dx_ * (Vector3d(i + 0.5, j + 0.5, k + 0.5) - 0.5 * n.cast<double>());
          row(x, rate * x + turn.cross(x));
        }
    const Vector3d last = 0.5 * dx_ * (n.cast<double>() - Vector3d::Ones());
    if (s_.start == Start::coincident) row(last, Vector3d::Zero());
    if (s_.start == Start::close) row(last - Vector3d(0.01 * dx_, 0, 0), Vector3d::Zero());
    const std::string file = name_ + "_" + part.name + ".csv";
    save(folder_ + "/" + file, rows);
    put("[[body.shape]]\ntype = \"particles\"\nfile = \"{}\"\n", file);
  }

  void write_proxy() {
    put("[[proxy]]\nbody = \"tool\"\ndevice = 0\n[proxy.coupling_limit]\nstiffness = {:.9g}\ndamping = {:.9g}\n"
        "angular_stiffness = {:.9g}\nangular_damping = {:.9g}\n",
        s_.coupling * kDefaultGains.stiffness, s_.coupling * kDefaultGains.damping,
        s_.coupling * kDefaultGains.angular_stiffness, s_.coupling * kDefaultGains.angular_damping);
  }

  const Setup& s_;
  std::string folder_, name_, text_;
  double dx_, top_ = 0;
  std::vector<Part> parts_;
  std::vector<std::string> materials_;
  Part tool_;
  Vector3d hole_ = Vector3d::Zero();
};

}  // namespace

std::string write_scene(const Setup& setup, const std::string& folder, const std::string& name) {
  return Writer(setup, folder, name).write();
}

}  // namespace palp::stability
