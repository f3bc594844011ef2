// Mesh files: each format read, each way to be unfit refused with a message, and no harm from damaged files.
#include <gtest/gtest.h>

#include <cstring>
#include <random>
#include <sstream>

#include "config/error.h"
#include "sim_server/geometry/mesh.h"
#include "sim_server/scene/particle_csv.h"
#include "tests/support/seed.h"

namespace palp::test::mesh_test {
namespace {

// A unit cube of 12 triangles, counter-clockwise seen from outside.
SurfaceMesh cube() {
  SurfaceMesh mesh;
  for (int i = 0; i < 8; ++i) mesh.vertices.emplace_back(i & 1, i >> 1 & 1, i >> 2 & 1);
  mesh.triangles = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                    {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
  return mesh;
}

std::string obj(const SurfaceMesh& mesh) {
  std::ostringstream out;
  out << "# a comment\nmtllib none\no thing\n";
  for (const auto& v : mesh.vertices) out << "v " << v.x() << " " << v.y() << " " << v.z() << "\n";
  out << "vn 0 0 1\n";
  for (const auto& t : mesh.triangles) out << "f " << t[0] + 1 << "//1 " << t[1] + 1 << "/2/1 " << t[2] + 1 << "\n";
  return out.str();
}

std::string text_stl(const SurfaceMesh& mesh) {
  std::ostringstream out;
  out << "solid thing\n";
  for (const auto& t : mesh.triangles) {
    out << " facet normal 0 0 0\n  outer loop\n";
    for (const std::uint32_t v : t) out << "   vertex " << mesh.vertices[v].transpose() << "\n";
    out << "  endloop\n endfacet\n";
  }
  out << "endsolid thing\n";
  return out.str();
}

template <class Value>
void put(std::string& out, Value value) {
  char bytes[sizeof(Value)];
  std::memcpy(bytes, &value, sizeof(Value));
  out.append(bytes, sizeof(Value));
}

std::string binary_stl(const SurfaceMesh& mesh) {
  std::string out(80, '\0');
  std::memcpy(out.data(), "solid but binary", 16);
  put(out, static_cast<std::uint32_t>(mesh.triangles.size()));
  for (const auto& t : mesh.triangles) {
    for (int i = 0; i < 3; ++i) put(out, 0.f);
    for (const std::uint32_t v : t) {
      for (int a = 0; a < 3; ++a) put(out, static_cast<float>(mesh.vertices[v][a]));
    }
    put(out, std::uint16_t{0});
  }
  return out;
}

std::string ply(const SurfaceMesh& mesh, bool binary) {
  std::ostringstream head;
  head << "ply\nformat " << (binary ? "binary_little_endian" : "ascii") << " 1.0\ncomment made here\nelement vertex "
       << mesh.vertices.size()
       << "\nproperty float x\nproperty double y\nproperty float z\nproperty uchar red\nelement face "
       << mesh.triangles.size() << "\nproperty list uchar int vertex_indices\nend_header\n";
  std::string out = head.str();
  std::ostringstream text;
  for (const auto& v : mesh.vertices) {
    if (binary) {
      put(out, static_cast<float>(v.x()));
      put(out, v.y());
      put(out, static_cast<float>(v.z()));
      put(out, std::uint8_t{7});
    } else {
      text << v.transpose() << " 7\n";
    }
  }
  for (const auto& t : mesh.triangles) {
    if (binary) {
      put(out, std::uint8_t{3});
      for (const std::uint32_t v : t) put(out, static_cast<std::int32_t>(v));
    } else {
      text << "3 " << t[0] << " " << t[1] << " " << t[2] << "\n";
    }
  }
  return out + text.str();
}

struct Format {
  const char* path;
  std::string bytes;
};

std::vector<Format> all_formats(const SurfaceMesh& mesh) {
  return {{"cube.obj", obj(mesh)},
          {"text.stl", text_stl(mesh)},
          {"binary.STL", binary_stl(mesh)},
          {"text.ply", ply(mesh, false)},
          {"binary.ply", ply(mesh, true)}};
}

std::string fault_of(const SurfaceMesh& mesh) {
  try {
    checked_mesh(mesh, "m.obj");
  } catch (const ConfigError& error) {
    return error.what();
  }
  return "";
}

std::string read_fault(const std::string& bytes, const std::string& path) {
  try {
    read_mesh(bytes, path);
  } catch (const ConfigError& error) {
    return error.what();
  }
  return "";
}

TEST(Mesh, EveryFormatGivesTheCube) {
  for (const Format& format : all_formats(cube())) {
    SCOPED_TRACE(format.path);
    SurfaceMesh mesh;
    ASSERT_NO_THROW(mesh = checked_mesh(read_mesh(format.bytes, format.path), format.path));
    EXPECT_EQ(mesh.vertices.size(), 8u);
    EXPECT_EQ(mesh.triangles.size(), 12u);
    const Moments moments = mesh_moments(mesh);
    EXPECT_NEAR(moments.volume, 1, 1e-9);
    EXPECT_LT((moments.center() - Eigen::Vector3d::Constant(0.5)).norm(), 1e-9);
    EXPECT_LT((moments.inertia() - Eigen::Matrix3d::Identity() / 6).norm(), 1e-9);
  }
}

TEST(Mesh, MeshesInsideOutAreTurned) {
  SurfaceMesh mesh = cube();
  for (auto& t : mesh.triangles) std::swap(t[0], t[1]);
  EXPECT_LT(mesh_moments(mesh).volume, 0);
  EXPECT_NEAR(mesh_moments(checked_mesh(mesh, "m.obj")).volume, 1, 1e-12);
}

TEST(Mesh, UnfitMeshesAreNamed) {
  SurfaceMesh open = cube();
  open.triangles.pop_back();
  EXPECT_NE(fault_of(open).find("m.obj: the mesh is open: 3 edges have only one triangle, the first from ("),
            std::string::npos);
  SurfaceMesh twisted = cube();
  std::swap(twisted.triangles[3][0], twisted.triangles[3][1]);
  EXPECT_NE(fault_of(twisted).find("face opposite ways at 3 edges"), std::string::npos);
  SurfaceMesh crowded = cube();
  crowded.triangles.push_back(crowded.triangles[0]);
  EXPECT_NE(fault_of(crowded).find("more than two triangles"), std::string::npos);
  SurfaceMesh flat = cube();
  for (auto& v : flat.vertices) v.z() = 0;
  EXPECT_NE(fault_of(flat), "");
  SurfaceMesh point = cube();
  for (auto& v : point.vertices) v.setZero();
  EXPECT_NE(fault_of(point), "");
  SurfaceMesh infinite = cube();
  infinite.vertices[3].x() = INFINITY;
  EXPECT_NE(fault_of(infinite).find("not a finite number"), std::string::npos);
  EXPECT_EQ(fault_of(SurfaceMesh{}), "m.obj: the mesh has no triangles");
  EXPECT_EQ(fault_of(cube()), "");
}

TEST(Mesh, DamagedFilesAreNamedWithTheirLine) {
  EXPECT_EQ(read_fault("", "m.obj"), "m.obj: the file is empty");
  EXPECT_EQ(read_fault("v 0 0 0", "m.step"), "m.step: the ending '.step' is not known, expected .obj, .stl or .ply");
  EXPECT_EQ(read_fault("v 0 0 0\nv 0 nan 0\n", "m.obj"), "m.obj:2: 'nan' is not a finite number");
  EXPECT_EQ(read_fault("v 0 0 0\nf 1 2 3\n", "m.obj"),
            "m.obj:2: a face names vertex '2', expected a whole number from 1 to 1");
  EXPECT_EQ(read_fault("v 0 0 0\nf 1 1\n", "m.obj"), "m.obj:2: a face has fewer than three corners");
  EXPECT_EQ(read_fault("v 0 0\n", "m.obj"), "m.obj:1: the line has 3 words, expected at least 4");
  EXPECT_NE(read_fault(binary_stl(cube()).substr(0, 300), "m.stl").find("cut off"), std::string::npos);
  EXPECT_NE(read_fault("solid x\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\n", "m.stl").find("cut off"),
            std::string::npos);
  EXPECT_NE(read_fault(ply(cube(), true).substr(0, 400), "m.ply").find("cut off"), std::string::npos);
  EXPECT_NE(read_fault("ply\nformat binary_big_endian 1.0\n", "m.ply").find("m.ply:2: the format is not known"),
            std::string::npos);
  EXPECT_THROW(load_mesh("/nowhere/m.obj", 1), ConfigError);
}

// Some programs write "solid" at the beginning of binary files, too.
TEST(Mesh, BinaryStlThatBeginsAsTextIsStillBinary) {
  for (const char filler : {' ', '\0'}) {
    std::string bytes = binary_stl(cube());
    bytes.replace(0, 80, "solid made by a program" + std::string(57, filler));
    EXPECT_EQ(read_mesh(bytes, "m.stl").triangles.size(), 12u);
    for (const std::size_t size : {90u, 300u, 500u}) {
      EXPECT_EQ(read_fault(bytes.substr(0, size), "m.stl"),
                "m.stl: a binary STL of 12 triangles has 684 bytes, but the file has " + std::to_string(size) +
                    "; it is cut off or not an STL");
    }
  }
  const std::string fault = read_fault("solid x\n" + std::string(1000, ' ') + "\n\x01\x1b[31m\xff\n", "m.stl");
  EXPECT_EQ(fault, "m.stl:3: '\\x01\\x1b[31m\\xff' has no meaning in an STL file");
}

// Any damage: the mesh is read, or refused with a message that names the file.
TEST(Mesh, FuzzedFilesAreReadOrRefused) {
  const unsigned seed = drawn_seed();
  SCOPED_TRACE(::testing::Message() << "seed " << seed);
  std::mt19937 random(seed);
  for (const Format& format : all_formats(cube())) {
    for (int round = 0; round < 1500; ++round) {
      std::string bytes = format.bytes;
      if (random() % 2 == 0) bytes.resize(random() % bytes.size());
      for (unsigned edit = random() % 5; edit > 0 && !bytes.empty(); --edit) {
        const std::size_t at = random() % bytes.size();
        if (random() % 3 == 0)
          bytes.erase(at, random() % 8);
        else
          bytes[at] = static_cast<char>(random() % 3 == 0 ? "0123456789-+e. \n"[random() % 16] : random() % 256);
      }
      try {
        const SurfaceMesh mesh = checked_mesh(read_mesh(bytes, format.path), format.path);
        std::vector<Interval> inside;
        ColumnMesh(mesh).column(0.4, 0.3, inside);
      } catch (const ConfigError& error) {
        EXPECT_EQ(std::string(error.what()).rfind(format.path, 0), 0u) << error.what();
      }
    }
  }
}

std::string csv_fault(const std::string& text) {
  try {
    parse_particle_csv(text, "p.csv", 1, 3);
  } catch (const ConfigError& error) {
    return error.what();
  }
  return "";
}

TEST(ParticleCsv, ReadsColumnsInAnyOrder) {
  const Particles p = parse_particle_csv(
      "# made by hand\nz, y,x,volume,temperature,vx,vy,vz\r\n3,2,1,0.5,300,7,8,9\r\n\n-3,2e0,1,1,301,7,8,+9\n", "p.csv",
      1, 10);
  ASSERT_EQ(p.position.size(), 2u);
  EXPECT_EQ(p.position[0], Eigen::Vector3d(1, 2, 3));
  EXPECT_EQ(p.position[1], Eigen::Vector3d(1, 2, -3));
  EXPECT_EQ(p.velocity[1], Eigen::Vector3d(7, 8, 9));
  EXPECT_EQ(p.volume[0], 0.5);
  EXPECT_EQ(p.temperature[1], 301);
  const Particles q = parse_particle_csv("x,y,z\n1,2,3", "p.csv", 0.25, 10);
  EXPECT_TRUE(q.velocity.empty());
  EXPECT_TRUE(q.temperature.empty());
  // as spreadsheets write it
  EXPECT_EQ(parse_particle_csv("\xef\xbb\xbfx,y,z\r\n1,2,3\r\n", "p.csv", 0.25, 10).position.size(), 1u);
  EXPECT_EQ(q.volume, std::vector<double>{0.25});
}

TEST(ParticleCsv, NamesFaultsWithTheirLine) {
  EXPECT_EQ(csv_fault(""), "p.csv: the file is empty, expected a header x,y,z,... and rows of numbers");
  EXPECT_EQ(csv_fault("x,y,z\n"), "p.csv: no particle after the header");
  EXPECT_EQ(csv_fault("x,y\n"), "p.csv:1: columns x, y and z are needed");
  EXPECT_EQ(csv_fault("x,y,z,x\n"), "p.csv:1: column 'x' stands twice");
  EXPECT_EQ(csv_fault("x,y,z,mass\n"),
            "p.csv:1: unknown column 'mass', expected columns x,y,z and if wanted vx,vy,vz,temperature,volume");
  EXPECT_EQ(csv_fault("x,y,z,vx\n"), "p.csv:1: expected all of vx, vy and vz, or none");
  EXPECT_EQ(csv_fault("x,y,z\n1,2\n"), "p.csv:2: the row has 2 cells, expected 3 as in the header");
  EXPECT_EQ(csv_fault("x,y,z\n1,2,3\n1,nan,3\n"), "p.csv:3: y is 'nan', expected a number from -1e+09 to 1e+09");
  EXPECT_EQ(csv_fault("x,y,z\n1,2,\n"), "p.csv:2: z is '', expected a number from -1e+09 to 1e+09");
  const std::string sizes = "a number in m^3 from 0.001 to 1000, a thousandth to a thousand times the spacing cubed";
  for (const char* volume : {"0", "-1", "1e-300", "0.0009", "1001", "1e9", "big"})
    EXPECT_EQ(csv_fault(std::string("x,y,z,volume\n1,2,3,") + volume + "\n"),
              std::string("p.csv:2: volume is '") + volume + "', expected " + sizes);
  for (const char* temperature : {"-5", "1e9", "inf"})
    EXPECT_EQ(csv_fault(std::string("x,y,z,temperature\n1,2,3,") + temperature + "\n"),
              std::string("p.csv:2: temperature is '") + temperature + "', expected a number in K from 0 to 100000");
  EXPECT_EQ(csv_fault("x,y,z\n1,1,1\n1,1,1\n1,1,1\n1,1,1\n"),
            "p.csv:5: more than 3 particles, which is what memory here allows");
}

}  // namespace
}  // namespace palp::test::mesh_test
