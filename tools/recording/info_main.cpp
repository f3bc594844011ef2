// palp-info: says what a recording contains.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <string>

#include "config/version.h"
#include "tools/recording/info.h"

int main(int argc, char** argv) {
  CLI::App app("Says what a recording contains: duration, topics, counts and drops.", "palp-info");
  app.set_version_flag("--version", palp::version_of("palp-info"));
  std::string path;
  app.add_option("file", path, "a recording (.mcap)")->required();
  CLI11_PARSE(app, argc, argv);
  try {
    fmt::print("{}", palp::describe_recording(path));
    return 0;
  } catch (const std::exception& error) {
    fmt::print(stderr, "palp-info: {}\n", error.what());
    return 1;
  }
}
