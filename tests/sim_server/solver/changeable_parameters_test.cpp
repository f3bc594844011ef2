// A scene file and a command at run time take the same values.
#include "sim_server/solver/changeable_parameters.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "config/error.h"
#include "config/parameter_ranges.h"
#include "config/scene_reader.h"

namespace palp::test::changeable_parameters_test {
namespace {

std::string digits(double value) {
  char text[40];
  std::snprintf(text, sizeof text, "%.17g", value);
  return text;
}

// Returns whether a scene that holds the value, else nothing of note, is refused because of it.
bool file_refuses(const ParameterRow& row, double value) {
  const std::string key = row.key, name = key.substr(key.find('.') + 1);
  const std::string table = key.find('.') == std::string::npos ? "scene" : key.substr(0, key.find('.'));
  const std::string number =
      digits(value).find_first_of(".en") == std::string::npos ? digits(value) + ".0" : digits(value);
  std::string text;
  for (const char* head : {"scene", "domain", "numerics", "stream"}) {
    text += std::string("[") + head + "]\n";
    if (table == head) text += name + " = " + (row.count == 1 ? number : "[" + number + ", 0, 0]") + "\n";
  }
  text += "[[material]]\nname = \"mud\"\n";
  if (table == "material") text += name + " = " + number + "\n";
  TomlFile file = TomlFile::parse(text, "s.toml");
  read_scene(file, "s.toml", {});
  try {
    file.finish();
  } catch (const ConfigError& error) {
    for (const std::string& fault : error.faults())
      if (fault.find(" " + name + (row.count == 1 ? " is " : "[0] is ")) != std::string::npos &&
          fault.find("expected a number") != std::string::npos)
        return true;
  }
  return false;
}

bool command_refuses(const ParameterRow& row, const std::string& name, double value) {
  SceneConfig config;
  config.materials.resize(1);
  config.materials[0].name = "mud";
  try {
    const std::string text = digits(value) + (row.count == 1 ? "" : " 0 0");
    parse_parameter(row, name, text);
    if (name.rfind("stream.", 0) != 0) apply_parameter(config, name, text);
  } catch (const ConfigError&) {
    return true;
  }
  return false;
}

TEST(Parameters, FilesAndCommandsTakeTheSame) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  int changeable = 0;
  const auto judge = [](const ParameterRow& row, const std::string& name, double value, bool refused) {
    EXPECT_EQ(file_refuses(row, value), refused) << row.key << " = " << value << " in a file";
    if (name.empty()) return;
    EXPECT_EQ(command_refuses(row, name, value), refused) << name << " = " << value;
  };
  for (const ParameterRow& row : parameter_rows()) {
    if (row.count == 0) continue;
    std::string name;
    for (const ChangeableParameter& item : changeable_parameters({"mud"}))
      if (item.row == &row) name = item.name;
    EXPECT_EQ(row.while_running, !name.empty()) << row.key;
    changeable += row.while_running ? 1 : 0;
    const Range& range = row.range;
    judge(row, name, range.min, range.above);
    judge(row, name, std::nextafter(range.min, kInfinity), false);
    judge(row, name, std::nextafter(range.min, -kInfinity), true);
    judge(row, name, range.max, false);
    judge(row, name, std::nextafter(range.max, kInfinity), true);
    judge(row, name, std::nan(""), true);
    EXPECT_STRNE(row.reason, "") << row.key;
  }
  EXPECT_EQ(changeable, 6);
}

TEST(Parameters, ACommandsValueIsRead) {
  const ParameterRow& gravity = parameter_row("gravity");
  EXPECT_EQ(parse_parameter(gravity, "gravity", " 0  1e1\t-2 "), (std::vector<double>{0, 10, -2}));
  for (const char* bad : {"", "1 2", "1 2 3 4", "1 2 x", "1,2,3", "1 2 inf"})
    EXPECT_THROW(parse_parameter(gravity, "gravity", bad), ConfigError) << bad;
  SceneConfig config;
  EXPECT_THROW(apply_parameter(config, "numerics.safety", "0.5"), ConfigError);  // not while it runs
}

}  // namespace
}  // namespace palp::test::changeable_parameters_test
