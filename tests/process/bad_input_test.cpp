// Tests what a person may get wrong in a scene or on the command line: one clear message and status 2, from the server
// and from palp-run alike.
#include <cstdlib>

#include "tests/process/running_system.h"

namespace palp::test::bad_input_test {
namespace {

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return at == std::string::npos ? text : text.replace(at, from.size(), to);
}

int lines_with(const std::string& text, const std::string& word) {
  std::istringstream in(text);
  int count = 0;
  for (std::string line; std::getline(in, line);) count += line.find(word) != std::string::npos;
  return count;
}

// Returns "scene.toml:LINE" for the line where the text begins, plus so many.
std::string at_line(const std::string& scene, const std::string& text, int more = 0) {
  const std::size_t at = scene.find(text);
  return "scene.toml:" +
         std::to_string(1 + std::count(scene.begin(), scene.begin() + static_cast<long>(at), '\n') + more);
}

class BadInput : public testing::TestWithParam<std::string> {
 protected:
  BadInput() : scene_(text_of(kHere + "small_tray.toml")) {}

  // Runs the program on the scene's text with what it needs besides.
  int run(const std::string& scene, std::vector<std::string> more = {}) {
    write_text(folder_ / "scene.toml", scene);
    more.insert(more.begin(), folder_ / "scene.toml");
    return run_with(more);
  }
  int run_with(const std::vector<std::string>& arguments) {
    std::vector<std::string> command{kBin + GetParam()};
    command.insert(command.end(), arguments.begin(), arguments.end());
    if (GetParam() == "palp-run")
      command.insert(command.end(), {"--out", folder_ / "out", "--duration", "0.01"});
    else
      command.insert(command.end(), {"--domain", std::to_string(1 + getpid() % 100), "--seconds", "0.1"});
    ChildProcess child(command, folder_ / "said.txt");
    const int status = child.wait(15s);
    said_ = child.output();
    return status;
  }
  // Expects one fault, told in one message that holds all of the texts.
  void expect_one_message(const std::vector<std::string>& texts) {
    const std::string mark = GetParam() + ": ";
    EXPECT_EQ(lines_with(said_, mark), 1) << said_;
    for (const std::string& text : texts) EXPECT_NE(said_.find(text), std::string::npos) << text << "\n" << said_;
  }

  ScratchFolder folder_;
  const std::string scene_;
  std::string said_;
};

TEST_P(BadInput, TheSceneItselfIsSound) { EXPECT_EQ(run(scene_, {"--backend", "cpu"}), 0) << said_; }

TEST_P(BadInput, AFaultInTheSceneIsNamedWithItsLine) {
  const std::string ball = "type = \"sphere\"\nradius = 0.06";
  const std::string fluid = "size = [0.24, 0.24, 0.12]";
  // a tetrahedron without its fourth side
  const std::string open = "v 0 0 0\nv 0.1 0 0\nv 0 0.1 0\nv 0 0 0.1\nf 1 3 2\nf 1 2 4\nf 1 4 3\n";
  write_text(folder_ / "open.obj", open);
  struct Fault {
    std::string from, to;
    std::vector<std::string> expected;
  };
  const std::vector<Fault> faults{
      {"viscosity = 0.05", "viscosty = 0.05", {at_line(scene_, "viscosity = 0.05"), "viscosty", "did you mean"}},
      {"rate_hz = 1000", "rate_hz = \"fast\"", {at_line(scene_, "rate_hz = 1000"), "expected a number"}},
      {"density = 1000", "density = -1", {at_line(scene_, "density = 1000"), "density is -1, expected"}},
      {"spacing = 0.04", "spacing = nan", {at_line(scene_, "spacing = 0.04"), "nan"}},
      {"[stream]", "[stream", {at_line(scene_, "[stream]")}},
      {ball, "type = \"mesh\"\nfile = \"absent.obj\"", {at_line(scene_, ball, 1), "absent.obj"}},
      {ball, "type = \"mesh\"\nfile = \"open.obj\"", {"open.obj", "open"}},
      {"position = [0.0, 0.0, 0.3]", "position = [0.0, 0.0, 0.08]", {"scene.toml:", "'ladle' overlaps", "fluid"}},
      {fluid,
       fluid + "\n[[body.shape]]\ntype = \"box\"\nsize = [0.3, 0.3, 0.3]\nsubtract = true",
       {at_line(scene_, "[[body]]\nname = \"fluid\""), "body 'fluid' holds no particle"}},
      {"spacing = 0.04", "spacing = 0.00002", {"memory here allows"}},
      {"body = \"ladle\"", "body = \"spoon\"", {at_line(scene_, "body = \"ladle\""), "spoon"}},
  };
  for (const Fault& fault : faults) {
    SCOPED_TRACE(GetParam() + ": " + fault.to);
    const auto begin = std::chrono::steady_clock::now();
    EXPECT_EQ(run(replaced(scene_, fault.from, fault.to)), 2) << said_;
    EXPECT_LT(std::chrono::steady_clock::now() - begin, 10s);
    expect_one_message(fault.expected);
  }
}

TEST_P(BadInput, AWrongWordOnTheCommandLineIsNamed) {
  EXPECT_EQ(run_with({"tray_fluit"}), 2) << said_;
  expect_one_message({"tray_fluit", "did you mean 'tray_fluid'?"});
  EXPECT_EQ(run_with({folder_ / "absent.toml"}), 2) << said_;
  expect_one_message({"absent.toml", "no such scene file"});
  EXPECT_EQ(run(scene_, {"--backend", "abacus"}), 2) << said_;
  EXPECT_NE(said_.find("--backend"), std::string::npos) << said_;
  EXPECT_EQ(run(scene_, {"--colour"}), 2) << said_;
  EXPECT_NE(said_.find("--colour"), std::string::npos) << said_;
}

TEST_P(BadInput, CudaWithoutAGpuIsRefused) {
  setenv("CUDA_VISIBLE_DEVICES", "-1", 1);
  const int status = run(scene_, {"--backend", "cuda"});
  unsetenv("CUDA_VISIBLE_DEVICES");
  EXPECT_GT(status, 0) << said_;
  EXPECT_LT(status, 128) << said_;
  expect_one_message({"CUDA", "--backend cpu"});
}

INSTANTIATE_TEST_SUITE_P(Programs, BadInput, testing::Values("palp-sim-server", "palp-run"),
                         [](const auto& of) { return of.param == "palp-run" ? "run" : "server"; });

}  // namespace
}  // namespace palp::test::bad_input_test
