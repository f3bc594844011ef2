#include "haptic_bridge/scene_start.h"

#include <vector>

#include "config/stop_signal.h"
#include "idl/clock.h"
#include "idl/convert.h"

namespace palp {

namespace {

// Returns the newest scene of that server, or of any where it is not known which one answers; null: none has come.
const SceneDescription* scene_of(std::uint64_t server, std::vector<Received<SceneDescription>>& scenes) {
  constexpr std::size_t kMost = 8;  // whoever sends more replaces the oldest
  if (scenes.size() > kMost) scenes.erase(scenes.begin(), scenes.end() - kMost);
  for (std::size_t i = scenes.size(); i-- > 0;)
    if (server == 0 || scenes[i].message.header.session == server) return &scenes[i].message;
  return nullptr;
}

}  // namespace

std::optional<HandleStart> wait_for_start(Bus& bus, BusLink& link, StatusReporter& reporter,
                                          std::uint32_t device_number) {
  const auto reader = bus.reader<SceneDescription>();
  std::vector<Received<SceneDescription>> scenes;
  std::optional<RigidState> home;
  std::uint64_t home_of = 0;  // the server whose scene that is
  std::int64_t t_home_ns = 0;
  while (!wait_for_stop(home ? kHousekeepingNs / 5 : kHousekeepingNs)) {
    reader->take_all(scenes);
    ProxySample proxy;
    const bool moves = link.newest_proxy(proxy);
    const SceneDescription* scene = scene_of(link.server_session(), scenes);
    if (!scene) {
      home.reset();
      home_of = 0;
    } else if (scene->header.session != home_of) {
      home = reporter.home_in(*scene, device_number);
      home_of = scene->header.session;
      t_home_ns = now_ns();
    }
    if (home && moves) return HandleStart{*home, to_state(proxy.proxy_pose, TwistD{})};
    // a server that stands still says nothing: its proxy is where the scene put it
    if (home && now_ns() - t_home_ns > 3 * kHousekeepingNs) return HandleStart{*home, *home};
    reporter.tell_waiting(*reader, link);
  }
  return std::nullopt;
}

}  // namespace palp
