// The messages that palp's processes exchange, as plain structs. palp.idl is the same list for the wire;
// tests/idl fills every field and sends it through both vendors, so the two cannot drift apart.
//
// Units are SI. Frames are right-handed; poses, twists and wrenches are given in the world frame (z up in palp's
// scenes). Quaternions are x y z w. Times in ns are readings of the sender's CLOCK_MONOTONIC: compare them with clocks
// of the same host only; a receiver on another host measures age from its own time of receipt (Received::t_receive_ns)
// or from the echo of its own stamp. Every sample carries the protocol version and the session of its sender, a random
// number drawn at start, so that a restarted peer whose sequence begins again at zero is told from an old, reordered
// sample.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "idl/gains.h"
#include "idl/look.h"
#include "idl/vocabulary.h"

namespace palp {

inline constexpr std::uint32_t kProtocolVersion = 5;
inline constexpr std::uint32_t kMaxDevices = 8;

struct Header {
  std::uint32_t version = kProtocolVersion;
  std::uint64_t session = 0;   // of the sender
  std::uint64_t sequence = 0;  // per topic and key, from 1
  std::int64_t t_send_ns = 0;
};

// The length of an orientation on the bus may be off from 1 by this.
inline constexpr double kUnitTolerance = 1e-3;

struct PoseD {
  std::array<double, 3> position{};               // [m]
  std::array<double, 4> orientation{0, 0, 0, 1};  // unit quaternion, x y z w
  bool operator==(const PoseD&) const = default;
};

// A velocity, whose linear part is that of the point that the pose names.
struct TwistD {
  std::array<double, 3> linear{};   // [m/s]
  std::array<double, 3> angular{};  // [rad/s]
  bool operator==(const TwistD&) const = default;
};

struct WrenchD {
  std::array<double, 3> force{};   // [N]
  std::array<double, 3> torque{};  // [N m], about the point that the pose names
  bool operator==(const WrenchD&) const = default;
};

// Bits of DeviceSample::flags and ProxySample::flags.
enum SampleFlag : std::uint32_t {
  kEngaged = 1u << 0,   // device: the hand holds the tool and force is wanted; proxy: coupled to that device
  kHealthy = 1u << 1,   // no fault on the sender's side
  kPaused = 1u << 2,    // proxy: the simulation stands still
  kRepeated = 1u << 3,  // proxy: an answer sent again, in case it was lost
  kButton0 = 1u << 8,
  kButton1 = 1u << 9,
};

// 1 kHz, bridge to server. Key: device.
struct DeviceSample {
  Header header;
  std::uint32_t device = 0;
  std::uint32_t flags = 0;
  std::int64_t t_device_ns = 0;  // when the pose was read from the device
  PoseD pose;                    // of the handle
  TwistD twist;
  CouplingGains gains;  // proposed
};

// The server's answer to a bridge, sent at the haptic rate. Key: device.
struct ProxySample {
  Header header;
  std::uint32_t device = 0;
  std::uint32_t flags = 0;
  double sim_time = 0;               // [s]
  std::uint64_t device_session = 0;  // which DeviceSample the wrench was computed from:
  std::uint64_t device_sequence = 0;
  std::int64_t t_device_ns = 0;  // its stamp, on the bridge's clock
  PoseD device_pose;
  TwistD device_twist;
  PoseD proxy_pose;  // of the proxy's handle
  TwistD proxy_twist;
  WrenchD wrench;                  // on the device, by the coupling, about the handle
  CouplingGains gains;             // used
  std::array<double, 2> blend{};   // linear, angular: 0 in free space or fluid .. 1 in rigid contact
  std::array<double, 2> energy{};  // [J] cumulative work of the proxy on the coupling: linear, angular
};

// A run of particles of one frame, in the order of the scene (not of the solver): kChunkParticles of them, the last
// chunk the rest, so that a chunk fits one datagram. A frame is complete when all chunk_count chunks of it have
// arrived. particle_sender.h cuts frames into chunks, frame_assembler.h puts them together.
inline constexpr std::uint32_t kChunkParticles = 3760;
struct ParticleChunk {
  Header header;  // sequence: over all chunks
  std::uint64_t frame = 0;
  double sim_time = 0;  // [s]
  std::uint32_t chunk = 0;
  std::uint32_t chunk_count = 0;
  std::uint32_t first = 0;           // index of the first particle: chunk * kChunkParticles
  std::uint32_t particle_count = 0;  // of the whole frame
  ScalarField field = ScalarField::none;
  std::vector<float> positions;     // [m], x y z per particle
  std::vector<float> scalars;       // one per particle, or empty
  std::vector<std::uint8_t> solid;  // how much of each is solid, in 255ths; empty: nothing changes state
};

struct BodyDescription {
  std::string name;
  BodyKind kind = BodyKind::fluid;
  std::uint32_t first = 0;  // particles [first, first + count)
  std::uint32_t count = 0;
  double density = 0;            // rest density [kg/m^3]
  std::array<float, 3> color{};  // sRGB, 0..1
  Look look;
  std::vector<float> vertices;           // closed surface in the body frame [m], x y z; empty: draw the particles
  std::vector<std::uint32_t> triangles;  // three vertex indices each, counter-clockwise seen from outside
  // of matter that has changed state: a fluid's that is solid, a solid's that is fluid. Clear or not as look is
  std::array<float, 3> changed_color{};
  Look changed_look;
  // The places of its particles at rest [m], x y z each, of an elastic body with a surface, whose body frame is the
  // world's: the surface moves along with them. Else empty.
  std::vector<float> rest;
};

struct ProxyDescription {
  std::uint32_t device = 0;
  std::uint32_t body = 0;  // index of its handle's body
  PoseD pose;              // of the handle at the start
};

// The scene as it is at the start, sent once and kept for late joiners.
struct SceneDescription {
  Header header;
  std::string name;
  std::string method;    // "paper" or "accurate"
  std::string numerics;  // what the accuracy level expanded to, one line
  std::uint64_t scene_hash = 0;
  std::uint32_t particle_count = 0;
  double spacing = 0;         // [m]
  double support_radius = 0;  // [m]
  double haptic_rate_hz = 0;
  std::array<double, 3> bounds_min{};  // [m]
  std::array<double, 3> bounds_max{};
  std::array<double, 3> gravity{};  // [m/s^2]
  std::vector<BodyDescription> bodies;
  std::vector<ProxyDescription> proxies;
};

// Poses of the rigid bodies, with each particle frame. Poses are of the body frame (see BodyDescription::vertices).
struct BodyPoses {
  Header header;
  double sim_time = 0;
  std::vector<std::uint32_t> body;
  std::vector<PoseD> pose;
};

struct Metric {
  std::string name;  // lower_snake_case with its unit: "step_p50_us"
  double value = 0;
};

// The state of a process, which every process sends a few times a second. Key: process.
struct Status {
  Header header;
  std::string process;  // "sim_server", "haptic_bridge 0", "viewer"
  std::string state;    // "running", "paused", "fault", ...
  std::string text;     // one sentence, or empty
  std::vector<Metric> metrics;
};

enum class Severity : std::uint32_t { info = 0, warning = 1, fault = 2 };

// Something happened that people must see. Reliable.
struct Event {
  Header header;
  std::string process;
  Severity severity = Severity::info;
  double sim_time = 0;
  std::string text;
};

enum class CommandKind : std::uint32_t {
  pause = 0,
  resume = 1,
  step = 2,
  reset = 3,
  quit = 4,
  set_parameter = 5,
  get_parameter = 6,  // name empty: all of them; kBillName: the bill; kScenesName: the scenes
  load_scene = 7      // name empty: the one that is served, read anew
};

// By this name get_parameter asks for the bill of the plan, what is computed and why, as lines for people.
inline constexpr const char* kBillName = "bill";
// By this name it asks for the names of the scenes that load_scene takes, a line each.
inline constexpr const char* kScenesName = "scenes";

// A request that anyone may send to the server. Reliable. The reply carries the same session and sequence.
struct Command {
  Header header;
  CommandKind kind = CommandKind::pause;
  std::string name;   // of the parameter or the scene
  std::string value;  // as written in a scene file
};

struct CommandReply {
  Header header;
  std::uint64_t command_session = 0;
  std::uint64_t command_sequence = 0;
  bool ok = false;
  // Says what was done, or why not. The reply to get_parameter has a line for each parameter, with name, value, unit,
  // lowest and highest value between tabs.
  std::string text;
};

}  // namespace palp
