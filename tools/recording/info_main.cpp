// palp-info: says what a recording contains.
#include <fmt/format.h>

#include <cstdio>
#include <string>

#include "config/command_line.h"
#include "tools/recording/info.h"

int main(int argc, char** argv) {
  CLI::App app("Says what a recording contains: duration, topics, counts and drops.");
  std::string path;
  app.add_option("file", path, "a recording (.mcap)")->required();
  return palp::run_program("palp-info", app, argc, argv, [&] {
    fmt::print("{}", palp::describe_recording(path));
    return 0;
  });
}
