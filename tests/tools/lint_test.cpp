// tools/lint over a tree of faults, each of which it must name.
#include <gtest/gtest.h>

#include "tests/support/process.h"

namespace palp::test {
namespace {

class Lint : public testing::Test {
 protected:
  Lint() {
    write("tools/lint", text_of(PALP_SOURCE_DIR "/tools/lint"));
    std::filesystem::permissions(folder_ / "tools/lint", std::filesystem::perms::owner_all);
    EXPECT_EQ(run({"/usr/bin/git", "init", "-q", folder_ / ""}), 0) << said_;
  }
  void write(const std::string& name, const std::string& text) {
    std::filesystem::create_directories(std::filesystem::path(folder_ / name).parent_path());
    write_text(folder_ / name, text);
  }
  int run(std::vector<std::string> command) {
    const Outcome outcome = run_program(std::move(command));
    said_ = outcome.output;
    return outcome.status;
  }
  int lint(const std::string& check) { return run({folder_ / "tools/lint", check}); }
  bool says(const std::string& text) const { return said_.find(text) != std::string::npos; }

  ScratchFolder folder_;
  std::string said_;
};

TEST_F(Lint, NamesAnIncludeAgainstTheArrows) {
  write("sim_server/geometry/ball.h", "#include \"idl/topics.h\"\n");
  EXPECT_EQ(lint("--includes"), 0) << said_;
  write("sim_server/geometry/ball.h", "\n#include \"sim_server/solver/plan.h\"\n");
  EXPECT_EQ(lint("--includes"), 1) << said_;
  EXPECT_TRUE(says("sim_server/geometry/ball.h:2: sim_server/geometry may include")) << said_;
}

TEST_F(Lint, NamesACircleOfRooms) {
  write("config/a.h", "#include \"idl/b.h\"\n");
  write("idl/b.h", "#include \"idl/dds/c.h\"\n");
  write("idl/dds/c.h", "#include \"config/a.h\"\n");
  EXPECT_EQ(lint("--includes"), 1) << said_;
  EXPECT_TRUE(says("a circle of rooms: ")) << said_;
  EXPECT_TRUE(says("config includes idl (config/a.h:1)")) << said_;
  EXPECT_TRUE(says("idl/dds includes config (idl/dds/c.h:1)")) << said_;
}

TEST_F(Lint, NamesFilesAndFunctionsThatAreTooLong) {
  const auto lines = [](int n) {
    std::string all;
    for (int i = 0; i < n; ++i) all += "  f('{', \"}\");  // {\n";
    return all;
  };
  write("viewer/a.cpp", "namespace palp::test {\nvoid most() {\n" + lines(59) + "}\nstruct A {\n  int b() const {\n" +
                            lines(60) + "  }\n};\n}\n" + std::string(400 - 128, '\n'));
  EXPECT_EQ(lint("--sizes"), 1) << said_;
  EXPECT_TRUE(says("viewer/a.cpp:64: b has 61 lines, at most 60 were expected")) << said_;
  EXPECT_TRUE(says("1 files, 1 faults")) << said_;
  write("viewer/a.cpp", std::string(401, '\n'));
  EXPECT_EQ(lint("--sizes"), 1) << said_;
  EXPECT_TRUE(says("viewer/a.cpp: 401 lines, at most 400 were expected")) << said_;
  write("viewer/a.cpp", std::string(400, '\n'));
  EXPECT_EQ(lint("--sizes"), 0) << said_;
}

TEST_F(Lint, NamesCommentsThatBeginWithoutASubject) {
  write("idl/a.h", "// Of the step that was filled last.\nint a;  // What it is\n// Returns it.\n// Whether it is.\n");
  EXPECT_EQ(lint("--comments"), 1) << said_;
  EXPECT_TRUE(says("idl/a.h:1: ")) << said_;
  EXPECT_TRUE(says("idl/a.h:2: ")) << said_;
  EXPECT_TRUE(says("2 that begin without a subject")) << said_;
  write("idl/a.h", "// Returns it.\nconst char* a = \"// What is\";\nconst char* b = R\"(\n// Of text\n)\";\n");
  EXPECT_EQ(lint("--comments"), 0) << said_;
}

}  // namespace
}  // namespace palp::test
