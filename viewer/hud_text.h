// The words of the head-up display. Pure.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "idl/messages.h"
#include "viewer/touch.h"

namespace palp {

// The figures. One that is not known is not set, and shown as a dash.
struct HudData {
  bool connected = false;           // a scene has arrived
  std::string scene;                // its name
  std::string server_state;         // Status::state of the server
  std::string server_text;          // Status::text
  double shown_rate_hz = 0;         // pictures
  double frame_rate_hz = 0;         // particle frames received
  std::optional<double> frame_age;  // [s] of the particles shown
  std::uint64_t lost_frames = 0;    // incomplete or overtaken
  std::string way;                  // by which frames come
  std::size_t particles = 0;        // drawn
  std::optional<double> sim_time;   // [s]
  std::optional<double> real_time_factor;
  std::optional<double> step_time;       // [s] of the wall clock per haptic step, median
  std::optional<double> kinetic_energy;  // [J] of all that moves
  std::optional<double> bridge_rate_hz;
  std::optional<double> bridge_late;      // [s] behind its deadline, 99th percentile
  std::optional<double> bridge_data_age;  // [s] of the samples that the bridge renders from, 99th percentile
  std::optional<double> force;            // [N] on the hand, largest of all devices
  std::optional<double> torque;           // [N m], likewise
  std::optional<double> contact;          // 0 in free space or fluid .. 1 in rigid contact, likewise
  std::optional<Touch> touched;           // of all tools, while it is marked
  double arrow_force = 1;                 // [N] that arrow_length stands for
  double arrow_length = 0.1;              // [m]
  bool paused = false;
  bool server_ended = false;             // as it said itself
  std::optional<double> server_silent;   // [s] since it was heard, while that is long
  std::optional<double> surfaces_built;  // the share, 0 .. 1, while building them takes long
  std::string note;                      // what the viewer itself has to say
  std::string hand_trouble;              // a bridge that holds its hand back, with the cause; or nothing
  std::string hand_state;                // of the only bridge
  std::string scales;                    // of its motion and force, where they are not 1
};

struct HudRow {
  std::string label;
  std::string value;
  bool warn = false;  // slow, old, lost: drawn in amber
  bool main = false;  // shown even where there is little room
};

// Returns all rows, always the same ones in the same order.
std::vector<HudRow> hud_rows(const HudData& data);

// Returns one line over the picture when something needs to be known: no server, paused, a fault, old data. Or nothing.
std::string hud_banner(const HudData& data);

// Returns two or three significant digits with the unit that suits: "0.42 ms", "1.3 s".
std::string format_time(double seconds);

// Fills the server's and the bridges' figures in data from their newest Status, by process name. Of several bridges the
// worst is taken.
void read_status(const std::map<std::string, Status>& newest, HudData& data);

}  // namespace palp
