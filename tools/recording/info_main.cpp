// palp-info: says what a recording contains.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <string>

#include "tools/recording/info.h"

int main(int argc, char** argv) {
  CLI::App app("Says what a recording contains: duration, topics, counts and drops.");
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
