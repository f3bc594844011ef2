// Which GPU is meant: addresses, the match of CUDA's numbers with EGL's, and the choice.
#include "viewer/gpu_devices.h"

#include <gtest/gtest.h>

#include <stdexcept>

#include "tests/support/files.h"

namespace palp::test::gpu_devices_test {
namespace {

TEST(PciAddress, IsReadAsLspciAndNvidiaSmiWriteIt) {
  EXPECT_EQ(parse_pci_address("0000:65:00.0"), (PciAddress{0, 0x65, 0, 0}));
  EXPECT_EQ(parse_pci_address("00000000:C1:1f.7"), (PciAddress{0, 0xc1, 0x1f, 7}));
  EXPECT_EQ(parse_pci_address("10de:0a:02.1"), (PciAddress{0x10de, 0x0a, 2, 1}));
  EXPECT_EQ(parse_pci_address("65:00.0"), (PciAddress{0, 0x65, 0, 0}));
  EXPECT_EQ(to_string(*parse_pci_address("00000001:C1:00.0")), "0001:c1:00.0");
}

TEST(PciAddress, OtherTextIsNone) {
  for (const char* text :
       {"", "65", "65:00", "00.0", "65:00.8", "65:20.0", "165:00.0", ":65:00.0", "0000:65:00.", "0000:65:00.0 ",
        "000000000:65:00.0", "0000:0000:65:00.0", "-1:65:00.0", "0x1:65:00.0", "65:00:00"})
    EXPECT_FALSE(parse_pci_address(text)) << text;
}

TEST(PciAddress, OfADrmFileStandsInTheSystemsTables) {
  const ScratchFolder folder;
  for (const auto& [node, device] :
       {std::pair("card1", "../../../0000:c1:00.0"), std::pair("card2", "../../../vgem")}) {
    std::filesystem::create_directories(folder.path() / "class/drm" / node);
    std::filesystem::create_symlink(device, folder.path() / "class/drm" / node / "device");
  }
  EXPECT_EQ(address_of_drm("/dev/dri/card1", folder.path()), (PciAddress{0, 0xc1, 0, 0}));
  EXPECT_FALSE(address_of_drm("/dev/dri/card2", folder.path())) << "it is on no PCI bus";
  EXPECT_FALSE(address_of_drm("/dev/dri/card3", folder.path()));
  EXPECT_FALSE(address_of_drm("", folder.path()));
}

// CUDA counts from the other end than EGL, and a GPU of another maker stands between.
class TwoGpus : public testing::Test {
 protected:
  const PciAddress left_{0, 0x17, 0, 0}, right_{0, 0x65, 0, 0}, other_{0, 0x03, 0, 0};
  const std::vector<CudaDevice> cuda_{{right_, "right"}, {left_, "left"}};
};

TEST_F(TwoGpus, AreMatchedByIdentityThenByAddressThenByWhatEglTold) {
  GpuDevice by_identity{.cuda = 0, .identity = "left"};
  match_cuda(by_identity, cuda_);
  EXPECT_EQ(by_identity.cuda, 1) << "CUDA numbers those that it sees";
  EXPECT_EQ(by_identity.address, left_);
  GpuDevice by_address{.address = left_};
  match_cuda(by_address, cuda_);
  EXPECT_EQ(by_address.cuda, 1);
  EXPECT_EQ(by_address.identity, "left");
  GpuDevice told{.cuda = 1};
  match_cuda(told, cuda_);
  EXPECT_EQ(told.cuda, 1);
  EXPECT_EQ(told.address, left_);
}

TEST_F(TwoGpus, WhatCudaDoesNotKnowStaysAsItWas) {
  GpuDevice other{.address = other_, .identity = "other"};
  match_cuda(other, cuda_);
  EXPECT_FALSE(other.cuda);
  EXPECT_EQ(other.address, other_);
  GpuDevice software{.software = true};
  match_cuda(software, cuda_);
  EXPECT_FALSE(software.cuda || software.address);
  GpuDevice beyond{.cuda = 7};
  match_cuda(beyond, cuda_);
  EXPECT_FALSE(beyond.address);
}

std::string refusal_of(const std::string& gpu, const std::vector<GpuDevice>& devices) {
  try {
    gpus_named(gpu, devices);
  } catch (const std::runtime_error& error) {
    return error.what();
  }
  return "none";
}

TEST_F(TwoGpus, AreNamedByEglByAddressAndByCuda) {
  const std::vector<GpuDevice> devices{
      {.address = left_, .cuda = 1}, {.address = right_, .cuda = 0}, {.software = true}};
  using Numbers = std::vector<std::size_t>;
  EXPECT_EQ(gpus_named("egl:2", devices), Numbers{2});
  EXPECT_EQ(gpus_named("pci:0000:65:00.0", devices), Numbers{1});
  EXPECT_EQ(gpus_named("pci:17:00.0", devices), Numbers{0});
  EXPECT_EQ(gpus_named("cuda:0", devices), Numbers{1});
  EXPECT_EQ(gpus_named("cpu", devices), Numbers{});
  for (const char* gpu :
       {"egl:3", "egl:", "egl:-1", "pci:0000:03:00.0", "pci:left", "cuda:2", "cuda:x", "cuda:", "fast", ""})
    EXPECT_NE(refusal_of(gpu, devices)
                  .find("egl:0, pci:0000:17:00.0, cuda:1; egl:1, pci:0000:65:00.0, cuda:0; egl:2, software"),
              std::string::npos)
        << gpu << ": " << refusal_of(gpu, devices);
  EXPECT_NE(refusal_of("egl:0", {}).find("EGL has no devices here"), std::string::npos);
}

TEST_F(TwoGpus, AutoPrefersTheOneWithoutASimulation) {
  std::vector<GpuDevice> devices{{.software = true}, {.address = left_}, {.address = right_}};
  using Numbers = std::vector<std::size_t>;
  EXPECT_EQ(gpus_named("auto", devices), (Numbers{1, 2}));
  devices[1].simulates = true;
  EXPECT_EQ(gpus_named("auto", devices), (Numbers{2, 1}));
  devices[2].simulates = true;
  EXPECT_EQ(gpus_named("auto", devices), (Numbers{1, 2}));
  EXPECT_EQ(gpus_named("auto", {{.software = true}}), Numbers{});
}

}  // namespace
}  // namespace palp::test::gpu_devices_test
