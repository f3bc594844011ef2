// Tests which class a machine is of, and which table serves it.
#include "sim_server/trade/machine_class.h"

#include <gtest/gtest.h>
#include <sched.h>

namespace palp::test::machine_class_test {
namespace {

TEST(MachineClass, ACpuIsNamedByTheProcessorsThatThisProcessMayUse) {
  cpu_set_t before, one;
  ASSERT_EQ(sched_getaffinity(0, sizeof before, &before), 0);
  EXPECT_EQ(machine_class(Backend::cpu), "cpu-" + std::to_string(CPU_COUNT(&before)));
  CPU_ZERO(&one);
  for (int k = 0; k < CPU_SETSIZE && CPU_COUNT(&one) == 0; ++k)
    if (CPU_ISSET(k, &before)) CPU_SET(k, &one);
  ASSERT_EQ(sched_setaffinity(0, sizeof one, &one), 0);
  EXPECT_EQ(machine_class(Backend::cpu), "cpu-1");
  EXPECT_EQ(sched_setaffinity(0, sizeof before, &before), 0);
}

TEST(MachineClass, AGpuIsNamedByItsModel) {
  EXPECT_EQ(short_gpu_name("NVIDIA H200"), "h200");
  EXPECT_EQ(short_gpu_name("NVIDIA H100 80GB HBM3"), "h100");
  EXPECT_EQ(short_gpu_name("NVIDIA A100-SXM4-80GB"), "a100");
  EXPECT_EQ(short_gpu_name("NVIDIA GeForce RTX 4090"), "rtx-4090");
  EXPECT_EQ(short_gpu_name("Tesla V100-PCIE-16GB"), "v100");
  EXPECT_EQ(short_gpu_name(""), "gpu");
}

TEST(MachineClass, TheNearestOneServes) {
  const std::vector<std::string> classes{"cpu-16", "cpu-2", "h200"};
  EXPECT_EQ(nearest_class("cpu-2", classes), "cpu-2");
  EXPECT_EQ(nearest_class("cpu-1", classes), "cpu-2");
  EXPECT_EQ(nearest_class("cpu-4", classes), "cpu-2");
  EXPECT_EQ(nearest_class("cpu-8", classes), "cpu-16");
  EXPECT_EQ(nearest_class("cpu-192", classes), "cpu-16");
  EXPECT_EQ(nearest_class("h100", classes), "h200");
  EXPECT_EQ(nearest_class("h100", {"cpu-2"}), "cpu-2");
  EXPECT_EQ(nearest_class("cpu-2", {"h200"}), "h200");
  EXPECT_EQ(nearest_class("cpu-2", {}), "");
}

}  // namespace
}  // namespace palp::test::machine_class_test
