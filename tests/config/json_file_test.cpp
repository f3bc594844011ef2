// Tests that what is written as JSON is JSON, whatever the words and numbers in it.
#include "config/json_file.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "tests/support/files.h"

namespace palp::test::json_file_test {
namespace {

TEST(JsonFile, FieldsStayInOrderAndReadBack) {
  const std::string words = "a \"quoted\" path\\name,\n\ttab, \x01, \xc3\xa4";
  const Json json{{"z", words}, {"a", 0.1}, {"steps", std::numeric_limits<std::uint64_t>::max()}, {"healthy", true}};
  const std::string text = json_text(json);
  EXPECT_LT(text.find("\"z\": "), text.find("\"a\": 0.1,")) << text;
  EXPECT_NE(text.find("\"steps\": 18446744073709551615"), std::string::npos) << text;
  EXPECT_EQ(text.back(), '\n');
  const Json back = Json::parse(text);
  EXPECT_EQ(back.at("z"), words);
  EXPECT_EQ(back, json);
}

TEST(JsonFile, WhatJsonHasNoWordForIsReplaced) {
  const Json json{{"nan", std::nan("")}, {"inf", -std::numeric_limits<double>::infinity()}, {"name", "caf\xe9"}};
  const Json back = Json::parse(json_text(json));
  EXPECT_TRUE(back.at("nan").is_null());
  EXPECT_TRUE(back.at("inf").is_null());
  EXPECT_EQ(back.at("name"), "caf\xef\xbf\xbd");
}

TEST(JsonFile, AnOlderFileIsReplaced) {
  const ScratchFolder folder;
  const std::string path = folder / "summary.json";
  write_text(path, std::string(1000, '#'));
  write_json(path, {{"steps", 3}});
  EXPECT_EQ(text_of(path), "{\n  \"steps\": 3\n}\n");
}

TEST(JsonFile, AFileThatCannotBeWrittenIsNamed) {
  for (const char* path : {"/no/such/folder/summary.json", "/dev/full"}) {
    try {
      write_json(path, {{"steps", 3}});
      ADD_FAILURE() << path << " was written";
    } catch (const std::runtime_error& error) {
      EXPECT_EQ(std::string(error.what()).rfind(path, 0), 0u) << error.what();
    }
  }
}

}  // namespace
}  // namespace palp::test::json_file_test
