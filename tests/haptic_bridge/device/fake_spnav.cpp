// A libspnav whose daemon is the test: what the test pushes, the client polls.
#include <spnav.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <cstdlib>
#include <cstring>

namespace {
int g_ends[2] = {-1, -1};  // the client's, the daemon's
using Words = std::array<int, 8>;
}  // namespace

#define PALP_EXPORT extern "C" __attribute__((visibility("default")))

PALP_EXPORT int spnav_open() {
  if (std::getenv("PALP_NO_SPACENAV")) return -1;
  return socketpair(AF_UNIX, SOCK_SEQPACKET, 0, g_ends);
}
PALP_EXPORT int spnav_close() {
  for (int& end : g_ends) {
    if (end >= 0) close(end);
    end = -1;
  }
  return 0;
}
PALP_EXPORT int spnav_fd() { return g_ends[0]; }
PALP_EXPORT int spnav_poll_event(spnav_event* event) {
  Words words{};
  if (recv(g_ends[0], words.data(), sizeof words, MSG_DONTWAIT) <= 0) return 0;
  std::memcpy(event, words.data(), sizeof words);
  return words[0];
}
PALP_EXPORT void fake_spnav_say(const int* words) {
  [[maybe_unused]] const ssize_t n = send(g_ends[1], words, sizeof(Words), 0);
}
PALP_EXPORT void fake_spnav_hang_up() {
  close(g_ends[1]);
  g_ends[1] = -1;
}
